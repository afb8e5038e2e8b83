// Wall time of the simulation itself: it counts only while a Lap exists, so that output is not included. Also the part
// of this time that the rank waits for others. Not collective.
#pragma once

#include <mpi.h>

#include "parallel/log.hpp"

namespace trevi {

class Stopwatch {
 public:
  struct Times {
    double all = 0, waiting = 0, reductions = 0;  ///< s; the third is part of the second, and that of the first
  };

  double seconds() const { return running_ ? total_.all + MPI_Wtime() - since_.all : total_.all; }
  /// Times of the laps that have ended.
  const Times& total() const { return total_; }

  /// The watch runs as long as this object exists.
  class Lap {
   public:
    explicit Lap(Stopwatch& watch) : watch_(watch) {
      watch_.since_ = now();
      watch_.running_ = true;
    }
    ~Lap() {
      const Times end = now(), &begin = watch_.since_;
      Times& total = watch_.total_;
      total.all += end.all - begin.all;
      total.waiting += end.waiting - begin.waiting;
      total.reductions += end.reductions - begin.reductions;
      watch_.running_ = false;
    }
    Lap(const Lap&) = delete;
    Lap& operator=(const Lap&) = delete;

   private:
    static Times now() { return {MPI_Wtime(), event_seconds("Waiting"), event_seconds("Reductions")}; }

    Stopwatch& watch_;
  };

 private:
  Times total_, since_;
  bool running_ = false;
};

}  // namespace trevi
