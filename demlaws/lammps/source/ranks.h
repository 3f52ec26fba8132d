// Messages between the ranks of one instance of LAMMPS.
#ifndef DEMLAWS_RANKS_H
#define DEMLAWS_RANKS_H

#include "demlaws_plugin.h"
#include "stock.h"

namespace {

class Ranks : public demlaws::Ranks {
public:
  explicit Ranks(void *lmp) : comm_(instance(lmp)->world) {
    me = instance(lmp)->comm->me;
    count = instance(lmp)->comm->nprocs;
  }

private:
  const MPI_Comm comm_;
  void broadcast(void *bytes, int size) const { MPI_Bcast(bytes, size, MPI_BYTE, 0, comm_); }
  void collect(const void *mine, int size, void *all) const {
    MPI_Allgather(const_cast<void *>(mine), size, MPI_BYTE, all, size, MPI_BYTE, comm_);
  }
};

} // namespace
#endif
