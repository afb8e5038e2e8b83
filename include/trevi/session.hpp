// MPI and PETSc for the lifetime of a program that uses Trevi. There is one Session at a time, constructed before the
// first solver and destroyed after the last. A program that is to report an error of the Session itself on one rank
// only constructs an Mpi object before it. Collective. PETSc reads its own options (-log_view and others) from the
// command line; its signal handler is off, because the solver has its own. Denormal numbers are flushed to zero,
// because they are very slow in the high powers of the artificial pressure s_corr. Threads: OpenMP threads share the
// loops of a solver, and their settings remain those of the host. Only the thread of the Session calls MPI.
#pragma once

#include <mpi.h>

#include <optional>
#include <string>
#include <vector>

namespace trevi {

/// Initialises MPI for the lifetime of the object, unless the program has already done so.
class Mpi {
 public:
  Mpi(int& argc, char**& argv);
  ~Mpi();
  Mpi(const Mpi&) = delete;
  Mpi& operator=(const Mpi&) = delete;

 private:
  bool owner_ = false;
};

class Session {
 public:
  /// Throws InputError on all ranks alike for an -options_file that cannot be read, and RunError for an MPI library
  /// that does not support threads.
  Session(int& argc, char**& argv);
  /// For a program that has called MPI_Init() itself, on the ranks of `comm`, which must outlive the session. If the
  /// program has also initialised PETSc, the session uses it as it is.
  explicit Session(MPI_Comm comm);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  MPI_Comm comm() const { return comm_; }
  int rank() const { return rank_; }
  int size() const { return size_; }

  /// Sets the number of threads that share the loops of this rank, from the next solver on. It may differ between
  /// ranks, because results do not depend on it. Until this is called it is OMP_NUM_THREADS, or 1 if that is not set.
  /// It may exceed the number of cores. Throws InputError for a number below 1 or above 1024.
  static void use_threads(int count);
  static int threads();
  /// The number of threads that the program uses by default: the physical cores that this rank may use, shared fairly
  /// with the other ranks on the same machine that may use them. Changes nothing. Collective.
  int fair_threads() const;

  /// Options that PETSc was given but has not used, probably because they are mistyped; each as "-name".
  std::vector<std::string> unused_options() const;

 private:
  void begin();

  std::optional<Mpi> mpi_;
  MPI_Comm comm_ = MPI_COMM_NULL;
  bool owns_petsc_ = true;
  int rank_ = 0;
  int size_ = 1;
};

int rank_of(MPI_Comm comm);
int size_of(MPI_Comm comm);

/// The text of a file, read by rank 0 and broadcast, so that all ranks see the same bytes. Collective.
/// Throws InputError on all ranks alike if the file cannot be read.
std::string read_file_everywhere(MPI_Comm comm, const std::string& path);

}  // namespace trevi
