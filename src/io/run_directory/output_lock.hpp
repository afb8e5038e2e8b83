// Ensures one run at a time in a folder: a second one would set aside or remove what the first has written. The lock is
// that of the system (fcntl) on DIR/run.lock. It ends with the process of rank 0, however that ends, so a killed run
// never blocks its own restart, on this host or another; the file, which only says who holds the lock, may then remain.
// Network file systems: NFS and Lustre mounted with flock lock between hosts; mounted with nolock or localflock, within
// one host only; where there are no locks at all, nothing is guarded. NFS 4 keeps the lock of a host that died for its
// lease (usually 90 s). Collective: all but the destructor.
#pragma once

#include <string>

#include "trevi/session.hpp"

namespace trevi {

class OutputLock {
 public:
  OutputLock(MPI_Comm comm, const std::string& directory);  ///< takes the lock, if the folder is there already
  ~OutputLock();
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;

  /// Does nothing if the lock is held. InputError that names host and process if another run has it.
  void take();

  /// Whether the folder was removed, or replaced by another, since the lock was taken.
  bool lost() const;

 private:
  MPI_Comm comm_;
  std::string directory_, path_;
  int descriptor_ = -1;  ///< rank 0
};

}  // namespace trevi
