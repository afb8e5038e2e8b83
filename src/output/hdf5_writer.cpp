#include "trevi/output/hdf5_writer.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>

#include "trevi/base/error.hpp"
#include "trevi/output/collective.hpp"
#include "trevi/output/files.hpp"

namespace trevi {

namespace {

Hdf5Handle string_type(std::size_t length) {
  Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.id(), std::max<std::size_t>(1, length));
  H5Tset_strpad(type.id(), H5T_STR_NULLPAD);
  H5Tset_cset(type.id(), H5T_CSET_UTF8);
  return type;
}

Hdf5Handle collective_transfer() {
  Hdf5Handle transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
  H5Pset_dxpl_mpio(transfer.id(), H5FD_MPIO_COLLECTIVE);
  return transfer;
}

/// Without the time of day, which would make two equal checkpoints differ. `kind`: H5P_DATASET_CREATE and the like.
Hdf5Handle timeless(hid_t kind) {
  Hdf5Handle creation(H5Pcreate(kind), H5Pclose);
  H5Pset_obj_track_times(creation.id(), false);
  return creation;
}

Hdf5Handle dataset_creation() {
  Hdf5Handle creation = timeless(H5P_DATASET_CREATE);
  H5Pset_fill_time(creation.id(), H5D_FILL_TIME_NEVER);  // every row is written
  return creation;
}

}  // namespace

Hdf5Writer::Hdf5Writer(MPI_Comm comm, const std::string& path) : comm_(comm), path_(path) {
  silence_hdf5();
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_mpio(access.id(), comm, MPI_INFO_NULL);
  H5Pset_file_locking(access.id(), false, true);
  // Since 1.8 HDF5 can put checksums on its own records (names, shapes, attributes); the default is the older format.
  H5Pset_libver_bounds(access.id(), H5F_LIBVER_V18, H5F_LIBVER_LATEST);
  const Hdf5Handle creation = timeless(H5P_FILE_CREATE);
  file_ = Hdf5Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.id(), access.id()), H5Fclose);
  check(file_.valid(), "file");
}

Hdf5Writer::~Hdf5Writer() = default;

void Hdf5Writer::check(bool good, const std::string& object) const {
  all_or_none(comm_, [&] {
    if (!good)
      throw RunError(fmt::format("{}: cannot write {}: {} ({})", path_, object, hdf5_reason(), free_space(path_)));
  });
}

void Hdf5Writer::create_groups(const std::string& name) const {
  // By hand, as the groups that HDF5 makes on the way to a dataset carry the time of day.
  const Hdf5Handle creation = timeless(H5P_GROUP_CREATE);
  for (std::size_t slash = name.find('/', 1); slash != std::string::npos; slash = name.find('/', slash + 1)) {
    const std::string group_name = name.substr(0, slash);
    if (H5Lexists(file_.id(), group_name.c_str(), H5P_DEFAULT) > 0) continue;
    const Hdf5Handle group(H5Gcreate2(file_.id(), group_name.c_str(), H5P_DEFAULT, creation.id(), H5P_DEFAULT),
                           H5Gclose);
    check(group.valid(), group_name);
  }
}

Hdf5Handle Hdf5Writer::create_dataset(const std::string& name, RowFormat format, std::int64_t total) const {
  create_groups(name);
  const int rank = format.components == 1 ? 1 : 2;
  const hsize_t shape[2] = {static_cast<hsize_t>(total), static_cast<hsize_t>(format.components)};
  const Hdf5Handle creation = dataset_creation();
  const Hdf5Handle space(H5Screate_simple(rank, shape, nullptr), H5Sclose);
  Hdf5Handle dataset(H5Dcreate2(file_.id(), name.c_str(), native_type(format.scalar), space.id(), H5P_DEFAULT,
                                creation.id(), H5P_DEFAULT),
                     H5Dclose);
  check(dataset.valid(), name);
  return dataset;
}

void Hdf5Writer::write_rows(const std::string& name, RowFormat format, RowSlice slice, const void* rows) {
  Hdf5Handle dataset = create_dataset(name, format, slice.total);
  const int rank = format.components == 1 ? 1 : 2;
  const hsize_t start[2] = {static_cast<hsize_t>(slice.first), 0};
  const hsize_t count[2] = {static_cast<hsize_t>(slice.count), static_cast<hsize_t>(format.components)};
  const Hdf5Handle there(H5Dget_space(dataset.id()), H5Sclose);
  const Hdf5Handle here(H5Screate_simple(rank, count, nullptr), H5Sclose);
  if (slice.count > 0) {
    H5Sselect_hyperslab(there.id(), H5S_SELECT_SET, start, nullptr, count, nullptr);
  } else {  // takes part in the collective write with nothing
    H5Sselect_none(there.id());
    H5Sselect_none(here.id());
  }
  const Hdf5Handle transfer = collective_transfer();
  const bool good = slice.total == 0 ||
                    H5Dwrite(dataset.id(), native_type(format.scalar), here.id(), there.id(), transfer.id(), rows) >= 0;
  check(good && dataset.close(), name);
}

void Hdf5Writer::text(const std::string& name, const std::string& value) {
  const Hdf5Handle type = string_type(value.size()), space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle creation = dataset_creation(), transfer = collective_transfer();
  Hdf5Handle dataset(
      H5Dcreate2(file_.id(), name.c_str(), type.id(), space.id(), H5P_DEFAULT, creation.id(), H5P_DEFAULT), H5Dclose);
  check(dataset.valid(), name);
  const Hdf5Handle selection(H5Screate(H5S_SCALAR), H5Sclose);
  if (rank_of(comm_) != 0) H5Sselect_none(selection.id());
  const bool good =
      H5Dwrite(dataset.id(), type.id(), selection.id(), selection.id(), transfer.id(), value.c_str()) >= 0;
  check(good && dataset.close(), name);
}

void Hdf5Writer::write_attribute(const std::string& name, std::int64_t type, const Hdf5Handle& space,
                                 const void* value) {
  Hdf5Handle attribute(H5Acreate2(file_.id(), name.c_str(), type, space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const bool good = attribute.valid() && H5Awrite(attribute.id(), type, value) >= 0;
  check(good && attribute.close(), "attribute " + name);
}

void Hdf5Writer::attribute(const std::string& name, std::int64_t value) {
  write_attribute(name, native_type(Scalar::int64), Hdf5Handle(H5Screate(H5S_SCALAR), H5Sclose), &value);
}

void Hdf5Writer::attribute(const std::string& name, Real value) {
  write_attribute(name, native_type(Scalar::float64), Hdf5Handle(H5Screate(H5S_SCALAR), H5Sclose), &value);
}

void Hdf5Writer::attribute(const std::string& name, std::span<const Real> values) {
  const hsize_t count = values.size();
  write_attribute(name, native_type(Scalar::float64), Hdf5Handle(H5Screate_simple(1, &count, nullptr), H5Sclose),
                  values.data());
}

void Hdf5Writer::attribute(const std::string& name, const std::string& value) {
  const Hdf5Handle type = string_type(value.size());
  write_attribute(name, type.id(), Hdf5Handle(H5Screate(H5S_SCALAR), H5Sclose), value.c_str());
}

void Hdf5Writer::close() {
  check(H5Fflush(file_.id(), H5F_SCOPE_GLOBAL) >= 0, "to the disk");
  check(file_.close(), "to the end");
}

}  // namespace trevi
