// Messages between the ranks of one instance of LAMMPS, through the MPI that it is linked with: found by name, as all
// else, and only bytes, so that nothing of an MPI's header is needed but one constant.
#ifndef DEMLAWS_RANKS_H
#define DEMLAWS_RANKS_H

#include "stock.h"

namespace {

class Ranks {
public:
  Ranks(void *lmp, void *error) : me(0), count(1), comm_(NULL), byte_(NULL), broadcast_(NULL), gather_(NULL) {
    const Stock &stock = Stock::get();
    count = std::max(1, stock.setting(lmp, "world_size"));
    if (count == 1) return;
    me = stock.setting(lmp, "world_rank");
    void *(*convert)(int);
    stock.look_for("MPI_Bcast", broadcast_);
    stock.look_for("MPI_Allgather", gather_);
    stock.look_for("MPI_Comm_f2c", convert); // a macro of MPICH's, where handles are the integers that Fortran has
    stock.look_for("ompi_mpi_byte", byte_);
    if (!byte_) byte_ = (void *)0x4c00010d; // MPICH's MPI_BYTE, and of all that share its binary interface
    if (!broadcast_ || !gather_ || !stock.communicator)
      raise(error, true, "demlaws/table: the MPI of this LAMMPS is not one that demlaws can reach; run on one rank");
    const int handle = stock.communicator(lmp);
    comm_ = convert ? convert(handle) : (void *)(long)handle;
  }
  // Rank 0's bytes to all.
  void share(std::string &bytes) const {
    if (count == 1) return;
    long size = (long)bytes.size();
    broadcast_(&size, sizeof size, byte_, 0, comm_);
    bytes.resize(size);
    if (size) broadcast_(&bytes[0], (int)size, byte_, 0, comm_);
  }
  // What every rank has, in their order.
  template <class T> std::vector<T> gather(const T &mine) const {
    std::vector<T> all(count, mine);
    if (count > 1) gather_(&mine, sizeof mine, byte_, &all[0], sizeof mine, byte_, comm_);
    return all;
  }
  // All that the ranks have, one after another.
  template <class T> std::vector<T> join(const std::vector<T> &mine) const {
    const std::vector<long> sizes = gather((long)mine.size());
    const long most = *std::max_element(sizes.begin(), sizes.end());
    if (count == 1 || !most) return mine;
    std::vector<T> padded(mine), all(count * most), joined;
    padded.resize(most);
    const int bytes = (int)(most * sizeof(T));
    gather_(&padded[0], bytes, byte_, &all[0], bytes, byte_, comm_);
    for (int rank = 0; rank < count; rank++)
      joined.insert(joined.end(), all.begin() + rank * most, all.begin() + rank * most + sizes[rank]);
    return joined;
  }
  int me, count;

private:
  void *comm_, *byte_;
  int (*broadcast_)(void *, int, void *, int, void *);
  int (*gather_)(const void *, int, void *, void *, int, void *, void *);
};

} // namespace
#endif
