#include "io/hdf5/hdf5_rows.hpp"

#include <hdf5.h>

#include <type_traits>

namespace trevi {

static_assert(std::is_same_v<hid_t, std::int64_t> && std::is_same_v<herr_t, int>);
static_assert(sizeof(Vec3) == 3 * sizeof(Real), "rows of Vec3 are written as they lie in memory");

namespace {

herr_t keep_first(unsigned index, const H5E_error2_t* error, void* reason) {
  if (index == 0 && error->desc != nullptr) *static_cast<std::string*>(reason) = error->desc;
  return 0;
}

}  // namespace

void silence_hdf5() {
  // At the end of the program HDF5 would close what is open. Nothing is, but a damaged file can leave it a handle on
  // which it then crashes.
  H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

std::string hdf5_reason() {
  std::string reason = "no reason given";
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, &reason);
  return reason;
}

std::int64_t native_type(Scalar scalar) {
  switch (scalar) {
    case Scalar::uint8:
      return H5T_NATIVE_UINT8;
    case Scalar::int32:
      return H5T_NATIVE_INT32;
    case Scalar::int64:
      return H5T_NATIVE_INT64;
    case Scalar::float32:
      return H5T_NATIVE_FLOAT;
    case Scalar::float64:
      return H5T_NATIVE_DOUBLE;
  }
  return -1;
}

std::string hdf5_version() {
  unsigned major = 0, minor = 0, release = 0;
  H5get_libversion(&major, &minor, &release);
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(release);
}

}  // namespace trevi
