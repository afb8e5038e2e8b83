// Wall time of the simulation itself: counts while a Lap lives, so that output is not included. Not collective.
#pragma once

#include <mpi.h>

namespace trevi {

class Stopwatch {
 public:
  double seconds() const { return running_ ? total_ + MPI_Wtime() - since_ : total_; }

  /// The watch runs as long as this lives.
  class Lap {
   public:
    explicit Lap(Stopwatch& watch) : watch_(watch) {
      watch_.since_ = MPI_Wtime();
      watch_.running_ = true;
    }
    ~Lap() {
      watch_.total_ = watch_.seconds();
      watch_.running_ = false;
    }
    Lap(const Lap&) = delete;
    Lap& operator=(const Lap&) = delete;

   private:
    Stopwatch& watch_;
  };

 private:
  double total_ = 0, since_ = 0;
  bool running_ = false;
};

}  // namespace trevi
