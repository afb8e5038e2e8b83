// MPI and PETSc for the life of a program that uses Trevi: one Session at a time, constructed before the first solver
// and destroyed after the last. A program that reports an error of the Session itself on one rank only constructs Mpi
// before it. Collective. PETSc reads its own options (-log_view and others) from the command line; its signal handler
// is off, as the solver has its own. Denormal numbers are flushed to zero: they are very slow in the high powers of the
// artificial pressure s_corr. Threads: a solver's loops are shared by threads of OpenMP, whose settings stay those of
// the host; MPI is called by the thread of the Session only.
#pragma once

#include <mpi.h>

#include <optional>
#include <string>
#include <vector>

namespace trevi {

/// Initialises MPI for the life of the object, unless the program has done so already.
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
  /// InputError on all ranks alike for an -options_file that cannot be read, RunError for an MPI that allows no
  /// threads.
  Session(int& argc, char**& argv);
  /// For a program that has called MPI_Init() itself, on the ranks of `comm`, which must outlive the session. Where the
  /// program has initialised PETSc, too, the session uses it as it is.
  explicit Session(MPI_Comm comm);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  MPI_Comm comm() const { return comm_; }
  int rank() const { return rank_; }
  int size() const { return size_; }

  /// Threads that share the loops of this rank, from the next solver on; on each rank as it likes, as results do not
  /// depend on it. Until this is called OMP_NUM_THREADS, or 1 where that is not set. More than there are cores is
  /// allowed. InputError for a number below 1 or above 1024.
  static void use_threads(int count);
  static int threads();
  /// What the program uses when nobody says otherwise: the physical cores that this rank may use, shared fairly with
  /// the ranks on the same machine that may use them, too. Changes nothing. Collective.
  int fair_threads() const;

  /// Options that PETSc was given and has not used, probably mistyped; each as "-name".
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

/// Text of a file, read by rank 0 and broadcast, so that all ranks see the same bytes. Collective.
/// Throws InputError on all ranks alike when the file cannot be read.
std::string read_file_everywhere(MPI_Comm comm, const std::string& path);

}  // namespace trevi
