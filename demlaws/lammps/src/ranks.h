// Messages between the ranks of one instance of LAMMPS, through the MPI that it is linked with: found by name, as all
// else, and only bytes, so that nothing of an MPI's header is needed but one constant.
#ifndef DEMLAWS_RANKS_H
#define DEMLAWS_RANKS_H

#include "demlaws_plugin.h"
#include "stock.h"

namespace {

class Ranks : public demlaws::Ranks {
public:
  explicit Ranks(void *lmp) : lmp_(lmp) {
    const Stock &stock = Stock::get();
    count = std::max(1, stock.setting(lmp, "world_size"));
    if (count == 1) return;
    me = stock.setting(lmp, "world_rank");
    void *(*convert)(int);
    stock.look_for("MPI_Bcast", broadcast_);
    stock.look_for("MPI_Allgather", gather_);
    stock.look_for("MPI_Ibarrier", barrier_);
    stock.look_for("MPI_Test", test_);
    stock.look_for("MPI_Comm_f2c", convert); // a macro of MPICH's, where handles are the integers that Fortran has
    stock.look_for("ompi_mpi_byte", byte_);
    if (!byte_) byte_ = (void *)0x4c00010d; // MPICH's MPI_BYTE, and of all that share its binary interface
    if (!broadcast_ || !gather_ || !barrier_ || !test_ || !stock.communicator)
      raise(lmp, true, "demlaws/table: the MPI of this LAMMPS is not one that demlaws can reach; run on one rank");
    const int handle = stock.communicator(lmp);
    comm_ = convert ? convert(handle) : (void *)(long)handle;
  }

private:
  void *const lmp_;
  void *comm_ = NULL, *byte_ = NULL;
  mutable void *request_ = NULL; // MPICH's is a number, which has room in it
  int (*broadcast_)(void *, int, void *, int, void *) = NULL;
  int (*gather_)(const void *, int, void *, void *, int, void *, void *) = NULL;
  int (*barrier_)(void *, void *) = NULL;
  int (*test_)(void *, int *, void *) = NULL;
  void start() const { barrier_(comm_, &request_); }
  bool arrived() const {
    int all = 0;
    double status[16]; // more than any MPI_Status takes
    test_(&request_, &all, status);
    return all != 0;
  }
  void end(const std::string &why) const {
    fprintf(stderr, "%s\n", why.c_str()); // of what a rank writes just before MPI_Abort mpiexec may lose all
    usleep(500000);
    raise(lmp_, false, why);
  }
  void broadcast(void *bytes, int size) const { broadcast_(bytes, size, byte_, 0, comm_); }
  void collect(const void *mine, int size, void *all) const { gather_(mine, size, byte_, all, size, byte_, comm_); }
};

} // namespace
#endif
