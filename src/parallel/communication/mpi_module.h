// The interface between the program and its modules for MPI.
//
// Open MPI and MPICH have the same functions and nothing else in common: a program that is linked
// to one starts under that one alone, and needs it to start at all. So all that includes mpi.h
// (mpi_module.cpp) is a library apart, compiled once for each MPI that is there, opened by those
// processes that a launcher has started as ranks (mpi_ranks.h).
#pragma once

#include <memory>

#include "src/parallel/communication/communicator.h"

namespace sluice {

// Begins MPI: the ranks are all processes that the launcher has started.
using JoinMpi = void(std::unique_ptr<Communicator>& ranks);
inline constexpr const char* kJoinMpi = "sluiceJoinMpi";

// The ranks of a communicator of a program that has begun MPI itself: the number that
// MPI_Comm_c2f() gives. All of its ranks call; it is duplicated, and MPI stays as it is.
using ShareMpi = void(int fortran_communicator, std::unique_ptr<Communicator>& ranks);
inline constexpr const char* kShareMpi = "sluiceShareMpi";

// A module must export this first: the version of sluice and of this interface. The number counts
// up with each change of the interface.
inline constexpr const char* kMpiModuleVersionOf = "sluiceMpiModuleVersion";
inline constexpr const char* kMpiModuleVersion = SLUICE_VERSION " mpi module 3";

}  // namespace sluice
