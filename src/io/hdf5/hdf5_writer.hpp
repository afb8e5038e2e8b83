// Writes tables of particles to one HDF5 file, all ranks together. HDF5 lays out the same file in the memory of every
// rank (a few kilobytes, the rows are holes), so that each knows without communication where the tables are and writes
// its own rows there, with plain writes; rank 0 writes everything other than rows. HDF5 never writes to the disk
// itself, because of what it does when the disk is full: the ranks of its parallel driver wait for each other for ever,
// and its serial driver crashes at the end of the program. The file is the same. Collective: every member, with the
// same arguments on all ranks except for the rows. Errors on a rank before close() are kept until then, which saves a
// message for each table; close() throws them as the same RunError on all ranks. The file is complete, and on the disk,
// only after close().
#pragma once

#include <array>
#include <exception>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/hdf5/hdf5_rows.hpp"
#include "io/run_directory/files.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// Bytes [begin, end) of a file.
struct Extent {
  std::int64_t begin = 0, end = 0;
};

/// This rank's rows of a grid of z, y, x cells.
struct GridRows {
  std::array<std::int64_t, 3> shape{};
  RowSlice slice;
  const void* rows = nullptr;
};

class Hdf5Writer {
 public:
  Hdf5Writer(MPI_Comm comm, const std::string& path);
  ~Hdf5Writer();
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  /// A dataset of slice.total rows, of which this rank provides rows [first, first + count). Groups in the name are
  /// created.
  template <class T>
  void write(const std::string& name, const std::vector<T>& rows, RowSlice slice) {
    write(name, RowFormatOf<T>::value, slice, rows.data());
  }
  void write(const std::string& name, RowFormat format, RowSlice slice, const void* rows);

  /// The same with shape (z, y, x), or (z, y, x, components), rows with x fastest: slice.total is their product.
  void write_grid(const std::string& name, RowFormat format, const GridRows& rows);

  /// A dataset whose rows all have one value, which is all that the file stores: readers see all rows.
  void write_constant(const std::string& name, std::uint8_t value, std::int64_t total);

  void text(const std::string& name, const std::string& value);  ///< a dataset that is one string, UTF-8

  /// An attribute of the root group, or "/group/name" for an attribute of another group, which is created.
  void attribute(const std::string& name, std::int64_t value);
  void attribute(const std::string& name, Real value);
  void attribute(const std::string& name, std::span<const std::int64_t> values);
  void attribute(const std::string& name, std::span<const Real> values);
  void attribute(const std::string& name, const std::string& value);

  /// A second name for a dataset.
  void link(const std::string& name, const std::string& second_name);

  /// Flushes to the disk and closes.
  void close();

 private:
  /// Does the work, unless an error has occurred on this rank before.
  void attempt(const std::function<void()>& work);

  // Rank-local; these throw.
  void create_layout();
  void copy_layout();
  void check(bool good, const std::string& object) const;
  void create_groups(const std::string& name) const;
  void check_limit(const std::string& name, std::int64_t bytes) const;
  std::int64_t create_dataset(const std::string& name, RowFormat format, const std::vector<std::int64_t>& shape);
  void write_rows(const std::string& name, RowFormat format, const std::vector<std::int64_t>& shape,
                  const GridRows& rows);
  void create_text(const std::string& name, const std::string& value) const;

  void write_attribute(const std::string& name, std::int64_t type, const Hdf5Handle& space, const void* value);

  MPI_Comm comm_;
  std::string path_;
  std::optional<MemoryFile> layout_;
  Hdf5Handle file_;             ///< in `layout_`
  std::vector<Extent> tables_;  ///< where the rows lie
  std::optional<RandomAccessFile> disk_;
  std::exception_ptr failure_;
};

}  // namespace trevi
