#include "io/hdf5/hdf5_reader.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "base/damaged_file.hpp"
#include "base/memory.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

/// Ensures that nothing but its content can make the file unreadable. Does not wait, as opening a pipe would.
void check_access(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_NONBLOCK);
  if (descriptor < 0) throw InputError(fmt::format("{}: cannot read: {}; check the path", path, std::strerror(errno)));
  ::close(descriptor);
  if (!std::filesystem::is_regular_file(path))
    throw InputError(path + ": not an HDF5 file, nor any other with data; check the path");
}

Hdf5Handle open_file(const std::string& path) {
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // A file that is only read needs no lock, and some cluster file systems provide none.
  H5Pset_file_locking(access.id(), false, true);
  Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.id()), H5Fclose);
  if (file.valid()) return file;
  throw DamagedFile(
      fmt::format("{}: damaged or cut short ({}); use another copy or an older checkpoint", path, hdf5_reason()));
}

std::string shape_text(const std::vector<hsize_t>& shape) { return fmt::format("({})", fmt::join(shape, ", ")); }

std::string wanted_text(RowFormat format) {
  const bool real = format.scalar == Scalar::float32 || format.scalar == Scalar::float64;
  return fmt::format("{} of shape {}", real ? "floating-point numbers" : "integers",
                     format.components == 1 ? "(N)" : fmt::format("(N, {})", format.components));
}

bool kind_fits(hid_t dataset, Scalar scalar) {
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  const bool real = scalar == Scalar::float32 || scalar == Scalar::float64;
  return H5Tget_class(type.id()) == (real ? H5T_FLOAT : H5T_INTEGER);
}

std::vector<hsize_t> shape_of(hid_t dataset) {
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  std::vector<hsize_t> shape(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space.id()))));
  H5Sget_simple_extent_dims(space.id(), shape.data(), nullptr);
  return shape;
}

/// Whether the rows are in other files, as HDF5 allows.
bool is_elsewhere(hid_t dataset) {
  const Hdf5Handle creation(H5Dget_create_plist(dataset), H5Pclose);
  return H5Pget_layout(creation.id()) == H5D_VIRTUAL || H5Pget_external_count(creation.id()) > 0;
}

// Deflate compresses zeros to a thousandth at best; data that claim to be smaller were never written, and read as
// zeros.
constexpr double max_compression = 1100, smallest_table = 1e4;

/// The value of a fixed-length string type, whatever reads it.
template <class Read>
std::string read_fixed_string(const Hdf5Handle& type, const Read& read) {
  std::string value(H5Tget_size(type.id()), '\0');
  if (!read(value.data())) return {};
  value.resize(std::strlen(value.c_str()));
  return value;
}

bool is_fixed_string(const Hdf5Handle& type) {
  return H5Tget_class(type.id()) == H5T_STRING && H5Tis_variable_str(type.id()) == 0;
}

}  // namespace

Hdf5Reader::Hdf5Reader(const std::string& path, int readers) : path_(path), readers_(readers) {
  silence_hdf5();
  check_access(path);
  if (H5Fis_hdf5(path.c_str()) <= 0) throw DamagedFile(path + ": not an HDF5 file; check the path");
  file_ = open_file(path);
  file_size_ = static_cast<std::int64_t>(std::filesystem::file_size(path));
}

void Hdf5Reader::fail(const std::string& object, const std::string& problem) const {
  throw DamagedFile(fmt::format("{}: {}: {}", path_, object, problem));
}

bool Hdf5Reader::has(const std::string& name) const {
  // H5Lexists fails rather than answering no if a group on the way is missing.
  for (std::size_t slash = name.find('/', 1);; slash = name.find('/', slash + 1)) {
    if (H5Lexists(file_.id(), name.substr(0, slash).c_str(), H5P_DEFAULT) <= 0) return false;
    if (slash == std::string::npos) return true;
  }
}

Hdf5Handle Hdf5Reader::open_dataset(const std::string& name) const {
  if (!has(name)) fail(name, "missing; write this dataset, or use another file");
  Hdf5Handle dataset(H5Dopen2(file_.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset.valid()) fail(name, "cannot be opened as a dataset (" + hdf5_reason() + "); use another file");
  return dataset;
}

Hdf5Handle Hdf5Reader::open_attribute(const std::string& name) const {
  Hdf5Handle attribute(H5Aopen(file_.id(), name.c_str(), H5P_DEFAULT), H5Aclose);
  if (!attribute.valid()) fail("attribute " + name, "missing; is this a checkpoint of trevi?");
  return attribute;
}

std::int64_t Hdf5Reader::checked_rows(const std::string& name, RowFormat format) const {
  const Hdf5Handle dataset = open_dataset(name);
  const std::vector<hsize_t> shape = shape_of(dataset.id());
  const bool fits = format.components == 1 ? shape.size() == 1
                                           : shape.size() == 2 && shape[1] == static_cast<hsize_t>(format.components);
  if (!fits) fail(name, fmt::format("has shape {}; write {}", shape_text(shape), wanted_text(format)));
  if (!kind_fits(dataset.id(), format.scalar)) fail(name, "wrong type of number; write " + wanted_text(format));
  return static_cast<std::int64_t>(shape[0]);
}

void Hdf5Reader::check_room(const std::string& name, RowFormat format, RowSlice slice) const {
  const Hdf5Handle dataset = open_dataset(name);
  const double there =
      std::min(static_cast<double>(H5Dget_storage_size(dataset.id())), static_cast<double>(file_size_));
  const double claimed = static_cast<double>(slice.total) * static_cast<double>(bytes_of(format));
  if (claimed > max_compression * (there + smallest_table) && !is_elsewhere(dataset.id())) {
    fail(name, fmt::format("claims {} rows, {}, of which the file holds {}; it is damaged or was never filled, use "
                           "another copy",
                           slice.total, bytes_text(claimed), bytes_text(there)));
  }
  require_memory(static_cast<double>(slice.count) * static_cast<double>(bytes_of(format)) * readers_,
                 fmt::format("{}: {}: {} rows", path_, name, slice.count * readers_),
                 "use more machines, or a file with fewer rows");
}

void Hdf5Reader::check_text_size(const std::string& object, std::int64_t type) const {
  const std::size_t size = H5Tget_size(type);
  if (size > static_cast<std::size_t>(file_size_)) {
    fail(object, fmt::format("claims {} characters, more than the file has; it is damaged, use another copy", size));
  }
}

void Hdf5Reader::read_rows(const std::string& name, RowFormat format, RowSlice slice, void* rows) const {
  const std::int64_t present = checked_rows(name, format);
  if (present != slice.total) {
    fail(name, fmt::format("has {} rows where the file's other columns have {}; write one row per particle", present,
                           slice.total));
  }
  if (slice.count == 0) return;
  const Hdf5Handle dataset = open_dataset(name);
  const int rank = format.components == 1 ? 1 : 2;
  const hsize_t start[2] = {static_cast<hsize_t>(slice.first), 0};
  const hsize_t count[2] = {static_cast<hsize_t>(slice.count), static_cast<hsize_t>(format.components)};
  const Hdf5Handle there(H5Dget_space(dataset.id()), H5Sclose);
  const Hdf5Handle here(H5Screate_simple(rank, count, nullptr), H5Sclose);
  H5Sselect_hyperslab(there.id(), H5S_SELECT_SET, start, nullptr, count, nullptr);
  if (H5Dread(dataset.id(), native_type(format.scalar), here.id(), there.id(), H5P_DEFAULT, rows) < 0) {
    fail(name, fmt::format("rows {} to {} cannot be read ({}); the file is damaged, use another copy or an older one",
                           slice.first, slice.first + slice.count - 1, hdf5_reason()));
  }
}

void Hdf5Reader::read_number(const std::string& name, Scalar scalar, void* value) const {
  const Hdf5Handle attribute = open_attribute(name);
  const Hdf5Handle space(H5Aget_space(attribute.id()), H5Sclose);
  const bool single = H5Sget_simple_extent_npoints(space.id()) == 1;
  if (!single || H5Aread(attribute.id(), native_type(scalar), value) < 0) {
    fail("attribute " + name, "is not a single number; is this a checkpoint of trevi?");
  }
}

std::int64_t Hdf5Reader::integer_attribute(const std::string& name) const {
  std::int64_t value = 0;
  read_number(name, Scalar::int64, &value);
  return value;
}

Real Hdf5Reader::real_attribute(const std::string& name) const {
  Real value = 0;
  read_number(name, Scalar::float64, &value);
  return value;
}

std::string Hdf5Reader::text_attribute(const std::string& name) const {
  const Hdf5Handle attribute = open_attribute(name);
  const Hdf5Handle type(H5Aget_type(attribute.id()), H5Tclose);
  if (!is_fixed_string(type))
    fail("attribute " + name, "is not a text of fixed length; is this a checkpoint of trevi?");
  check_text_size("attribute " + name, type.id());
  return read_fixed_string(type, [&](char* value) { return H5Aread(attribute.id(), type.id(), value) >= 0; });
}

std::string Hdf5Reader::text(const std::string& name) const {
  const Hdf5Handle dataset = open_dataset(name);
  const Hdf5Handle type(H5Dget_type(dataset.id()), H5Tclose);
  if (!is_fixed_string(type)) fail(name, "is not a text of fixed length; is this a checkpoint of trevi?");
  check_text_size(name, type.id());
  return read_fixed_string(
      type, [&](char* value) { return H5Dread(dataset.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, value) >= 0; });
}

}  // namespace trevi
