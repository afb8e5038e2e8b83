// Writes tables of particles to one HDF5 file, all ranks together (MPI-IO, collective transfers).
// Tables are contiguous (checksums.hpp says why not chunked). Invariant: all ranks hold the same file structure; after
// a failure all ranks throw the same RunError. Collective: every member, with the same arguments on all ranks but for
// the rows. The file is whole only after close().
#pragma once

#include <span>
#include <string>
#include <vector>

#include "trevi/output/hdf5_rows.hpp"
#include "trevi/parallel/session.hpp"

namespace trevi {

class Hdf5Writer {
 public:
  Hdf5Writer(MPI_Comm comm, const std::string& path);
  ~Hdf5Writer();
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  /// A dataset of slice.total rows, of which this rank gives rows [first, first + count). Groups in the name are
  /// created.
  template <class T>
  void write(const std::string& name, const std::vector<T>& rows, RowSlice slice) {
    write_rows(name, RowFormatOf<T>::value, slice, rows.data());
  }

  void text(const std::string& name, const std::string& value);  ///< a dataset that is one UTF-8 string
  void attribute(const std::string& name, std::int64_t value);   ///< of the root group
  void attribute(const std::string& name, Real value);
  void attribute(const std::string& name, std::span<const Real> values);
  void attribute(const std::string& name, const std::string& value);

  /// Flushes to the disk and closes.
  void close();

 private:
  void check(bool good, const std::string& object) const;
  void write_rows(const std::string& name, RowFormat format, RowSlice slice, const void* rows);
  void create_groups(const std::string& name) const;
  Hdf5Handle create_dataset(const std::string& name, RowFormat format, std::int64_t total) const;
  void write_attribute(const std::string& name, std::int64_t type, const Hdf5Handle& space, const void* value);

  MPI_Comm comm_;
  std::string path_;
  Hdf5Handle file_;
};

}  // namespace trevi
