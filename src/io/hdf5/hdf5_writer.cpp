#include "io/hdf5/hdf5_writer.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <functional>
#include <numeric>

#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

/// ASCII if possible, because ParaView 5.11 accepts the Type of a VTKHDF file in no other character set.
Hdf5Handle string_type(const std::string& value) {
  const bool ascii = std::all_of(value.begin(), value.end(), [](unsigned char c) { return c < 128; });
  Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.id(), std::max<std::size_t>(1, value.size()));
  H5Tset_strpad(type.id(), H5T_STR_NULLPAD);
  H5Tset_cset(type.id(), ascii ? H5T_CSET_ASCII : H5T_CSET_UTF8);
  return type;
}

/// Without the time of day, which would make two equal checkpoints differ. `kind`: H5P_DATASET_CREATE and the like.
Hdf5Handle timeless(hid_t kind) {
  Hdf5Handle creation(H5Pcreate(kind), H5Pclose);
  H5Pset_obj_track_times(creation.id(), false);
  return creation;
}

}  // namespace

Hdf5Writer::Hdf5Writer(MPI_Comm comm, const std::string& path) : comm_(comm), path_(path) {
  silence_hdf5();
  on_root(comm_, [&] { create_empty_file(path_); });
  all_or_none(comm_, [&] {
    disk_.emplace(path_);
    create_layout();
  });
}

Hdf5Writer::~Hdf5Writer() = default;

void Hdf5Writer::attempt(const std::function<void()>& work) {
  if (failure_) return;
  try {
    work();
  } catch (const std::exception&) {
    failure_ = std::current_exception();
  }
}

void Hdf5Writer::create_layout() {
  layout_.emplace();
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_file_locking(access.id(), false, true);
  // Since 1.8 HDF5 can put checksums on its own records (names, shapes, attributes); the default is the older format.
  H5Pset_libver_bounds(access.id(), H5F_LIBVER_V18, H5F_LIBVER_LATEST);
  const Hdf5Handle creation = timeless(H5P_FILE_CREATE);
  file_ = Hdf5Handle(H5Fcreate(layout_->path().c_str(), H5F_ACC_TRUNC, creation.id(), access.id()), H5Fclose);
  check(file_.valid(), "file");
  layout_->forget_name();
}

void Hdf5Writer::check(bool good, const std::string& object) const {
  if (good) return;
  throw RunError(fmt::format("{}: cannot write {}: {} ({})", path_, object, hdf5_reason(), free_space(path_)));
}

void Hdf5Writer::create_groups(const std::string& name) const {
  // Created explicitly, because groups that HDF5 creates on the way to a dataset carry the time of day.
  const Hdf5Handle creation = timeless(H5P_GROUP_CREATE);
  for (std::size_t slash = name.find('/', 1); slash != std::string::npos; slash = name.find('/', slash + 1)) {
    const std::string group_name = name.substr(0, slash);
    if (H5Lexists(file_.id(), group_name.c_str(), H5P_DEFAULT) > 0) continue;
    const Hdf5Handle group(H5Gcreate2(file_.id(), group_name.c_str(), H5P_DEFAULT, creation.id(), H5P_DEFAULT),
                           H5Gclose);
    check(group.valid(), group_name);
  }
}

// HDF5 does not survive a file that it could not close, and ends the program by a signal when MPI ends.
void Hdf5Writer::check_limit(const std::string& name, std::int64_t bytes) const {
  const std::optional<std::int64_t> limit = file_size_limit();
  hsize_t size = 0;
  check(H5Fget_filesize(file_.id(), &size) >= 0, name);
  if (!limit || static_cast<std::int64_t>(size) + bytes <= *limit) return;
  throw RunError(
      fmt::format("{}: cannot write {}: no file may be larger than {} bytes here; raise the limit (ulimit -f)", path_,
                  name, *limit));
}

// Returns the offset in the file at which the rows begin.
std::int64_t Hdf5Writer::create_dataset(const std::string& name, RowFormat format,
                                        const std::vector<std::int64_t>& shape) {
  const std::int64_t total = std::accumulate(shape.begin(), shape.end(), std::int64_t{1}, std::multiplies<>());
  create_groups(name);
  check_limit(name, total * bytes_of(format));
  std::vector<hsize_t> extent(shape.begin(), shape.end());
  if (format.components > 1) extent.push_back(static_cast<hsize_t>(format.components));
  const Hdf5Handle creation = timeless(H5P_DATASET_CREATE);
  H5Pset_fill_time(creation.id(), H5D_FILL_TIME_NEVER);  // every row is written
  H5Pset_alloc_time(creation.id(), H5D_ALLOC_TIME_EARLY);
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose);
  Hdf5Handle dataset(H5Dcreate2(file_.id(), name.c_str(), native_type(format.scalar), space.id(), H5P_DEFAULT,
                                creation.id(), H5P_DEFAULT),
                     H5Dclose);
  check(dataset.valid(), name);
  const haddr_t offset = H5Dget_offset(dataset.id());
  check(total == 0 || offset != HADDR_UNDEF, name);
  const auto size = static_cast<std::int64_t>(H5Dget_storage_size(dataset.id()));
  check(dataset.close(), name);
  if (total == 0) return 0;
  const auto begin = static_cast<std::int64_t>(offset);
  tables_.push_back({begin, begin + size});
  return begin;
}

void Hdf5Writer::write_rows(const std::string& name, RowFormat format, const std::vector<std::int64_t>& shape,
                            const GridRows& rows) {
  attempt([&] {
    const std::int64_t begin = create_dataset(name, format, shape), row = bytes_of(format);
    disk_->write(begin + rows.slice.first * row,
                 {static_cast<const char*>(rows.rows), static_cast<std::size_t>(rows.slice.count * row)});
  });
}

void Hdf5Writer::write(const std::string& name, RowFormat format, RowSlice slice, const void* rows) {
  write_rows(name, format, {slice.total}, {{}, slice, rows});
}

void Hdf5Writer::write_grid(const std::string& name, RowFormat format, const GridRows& rows) {
  write_rows(name, format, {rows.shape.begin(), rows.shape.end()}, rows);
}

void Hdf5Writer::write_constant(const std::string& name, std::uint8_t value, std::int64_t total) {
  attempt([&] {
    create_groups(name);
    const hsize_t rows = static_cast<hsize_t>(total);
    const Hdf5Handle creation = timeless(H5P_DATASET_CREATE);
    H5Pset_fill_value(creation.id(), native_type(Scalar::uint8), &value);
    H5Pset_alloc_time(creation.id(), H5D_ALLOC_TIME_LATE);
    const Hdf5Handle space(H5Screate_simple(1, &rows, nullptr), H5Sclose);
    Hdf5Handle dataset(H5Dcreate2(file_.id(), name.c_str(), native_type(Scalar::uint8), space.id(), H5P_DEFAULT,
                                  creation.id(), H5P_DEFAULT),
                       H5Dclose);
    check(dataset.valid() && dataset.close(), name);
  });
}

void Hdf5Writer::create_text(const std::string& name, const std::string& value) const {
  const Hdf5Handle type = string_type(value), space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle creation = timeless(H5P_DATASET_CREATE);
  create_groups(name);
  Hdf5Handle dataset(
      H5Dcreate2(file_.id(), name.c_str(), type.id(), space.id(), H5P_DEFAULT, creation.id(), H5P_DEFAULT), H5Dclose);
  check(dataset.valid(), name);
  check(H5Dwrite(dataset.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, value.c_str()) >= 0, name);
  check(dataset.close(), name);
}

void Hdf5Writer::text(const std::string& name, const std::string& value) {
  attempt([&] { create_text(name, value); });
}

void Hdf5Writer::write_attribute(const std::string& name, std::int64_t type, const Hdf5Handle& space,
                                 const void* value) {
  attempt([&] {
    create_groups(name);
    const std::size_t slash = name.rfind('/');
    const std::string group = slash == std::string::npos ? "/" : name.substr(0, slash + 1);
    const std::string own_name = slash == std::string::npos ? name : name.substr(slash + 1);
    const Hdf5Handle parent(H5Gopen2(file_.id(), group.c_str(), H5P_DEFAULT), H5Gclose);
    Hdf5Handle attribute(H5Acreate2(parent.id(), own_name.c_str(), type, space.id(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
    const bool good = attribute.valid() && H5Awrite(attribute.id(), type, value) >= 0;
    check(good && attribute.close(), "attribute " + name);
  });
}

void Hdf5Writer::attribute(const std::string& name, std::int64_t value) {
  write_attribute(name, native_type(Scalar::int64), Hdf5Handle(H5Screate(H5S_SCALAR), H5Sclose), &value);
}

void Hdf5Writer::attribute(const std::string& name, Real value) {
  write_attribute(name, native_type(Scalar::float64), Hdf5Handle(H5Screate(H5S_SCALAR), H5Sclose), &value);
}

void Hdf5Writer::attribute(const std::string& name, std::span<const std::int64_t> values) {
  const hsize_t count = values.size();
  write_attribute(name, native_type(Scalar::int64), Hdf5Handle(H5Screate_simple(1, &count, nullptr), H5Sclose),
                  values.data());
}

void Hdf5Writer::attribute(const std::string& name, std::span<const Real> values) {
  const hsize_t count = values.size();
  write_attribute(name, native_type(Scalar::float64), Hdf5Handle(H5Screate_simple(1, &count, nullptr), H5Sclose),
                  values.data());
}

void Hdf5Writer::attribute(const std::string& name, const std::string& value) {
  const Hdf5Handle type = string_type(value);
  write_attribute(name, type.id(), Hdf5Handle(H5Screate(H5S_SCALAR), H5Sclose), value.c_str());
}

void Hdf5Writer::link(const std::string& name, const std::string& second_name) {
  attempt([&] {
    create_groups(second_name);
    check(H5Lcreate_hard(file_.id(), name.c_str(), file_.id(), second_name.c_str(), H5P_DEFAULT, H5P_DEFAULT) >= 0,
          second_name);
  });
}

// Everything other than rows.
void Hdf5Writer::copy_layout() {
  std::sort(tables_.begin(), tables_.end(), [](const Extent& a, const Extent& b) { return a.begin < b.begin; });
  const std::int64_t size = layout_->size();
  tables_.push_back({size, size});
  std::int64_t begin = 0;
  for (const Extent& table : tables_) {
    disk_->write(begin, layout_->read(begin, table.begin));
    begin = table.end;
  }
}

void Hdf5Writer::close() {
  attempt([&] {
    check(file_.close(), "to the end");
    if (rank_of(comm_) == 0) copy_layout();
    disk_->sync();
  });
  all_or_none(comm_, [&] {
    if (failure_) std::rethrow_exception(failure_);
  });
}

}  // namespace trevi
