// Reads tables of particles from an HDF5 file; every rank opens the file for itself and reads its own slice. Rank-local
// on purpose: a checksum error in one rank's slice must not leave the others inside a collective read. Every failure is
// an InputError that names the file, the object, what is wrong and what to do: a DamagedFile if the cause is in the
// file, and not in the path, in permissions or in the memory of this machine.
#pragma once

#include <string>
#include <vector>

#include "io/hdf5/hdf5_rows.hpp"

namespace trevi {

class Hdf5Reader {
 public:
  /// `readers` processes of this machine read their slices at the same time, and share its memory.
  explicit Hdf5Reader(const std::string& path, int readers = 1);

  bool has(const std::string& name) const;

  /// Rows of a dataset, after checking that its shape and kind of number fit T.
  template <class T>
  std::int64_t rows(const std::string& name) const {
    return checked_rows(name, RowFormatOf<T>::value);
  }

  /// Rows [first, first + count), converted to T; fails unless the dataset has slice.total rows.
  template <class T>
  std::vector<T> read(const std::string& name, RowSlice slice) const {
    check_room(name, RowFormatOf<T>::value, slice);
    std::vector<T> rows(static_cast<std::size_t>(slice.count));
    read_rows(name, RowFormatOf<T>::value, slice, rows.data());
    return rows;
  }

  std::int64_t integer_attribute(const std::string& name) const;  ///< of the root group
  Real real_attribute(const std::string& name) const;
  std::string text_attribute(const std::string& name) const;
  std::string text(const std::string& name) const;  ///< a dataset that is one string of fixed length

 private:
  [[noreturn]] void fail(const std::string& object, const std::string& problem) const;
  Hdf5Handle open_dataset(const std::string& name) const;
  Hdf5Handle open_attribute(const std::string& name) const;
  std::int64_t checked_rows(const std::string& name, RowFormat format) const;
  /// Fails for more rows than a file of this size can hold, or than fit into this machine's memory.
  void check_room(const std::string& name, RowFormat format, RowSlice slice) const;
  void check_text_size(const std::string& object, std::int64_t type) const;
  void read_rows(const std::string& name, RowFormat format, RowSlice slice, void* rows) const;
  void read_number(const std::string& name, Scalar scalar, void* value) const;

  std::string path_;
  int readers_;
  std::int64_t file_size_ = 0;
  Hdf5Handle file_;
};

}  // namespace trevi
