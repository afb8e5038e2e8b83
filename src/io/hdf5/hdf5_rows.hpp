// What the HDF5 reader and writer share: tables of rows, one row per particle, and handles that close themselves.
// HDF5's own header stays inside the .cpp files; its hid_t is the std::int64_t seen here (asserted there).
// Rank-local. Library: parallel HDF5 >= 1.10.7.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "trevi/types.hpp"

namespace trevi {

enum class Scalar { uint8, int32, int64, float32, float64 };

/// Type and width of a row; 1 component is a dataset of shape (N), more are (N, components).
struct RowFormat {
  Scalar scalar;
  int components;
};

constexpr std::int64_t bytes_of(RowFormat format) {
  constexpr std::int64_t scalar_bytes[] = {1, 4, 8, 4, 8};
  return scalar_bytes[static_cast<std::size_t>(format.scalar)] * format.components;
}

template <class T>
struct RowFormatOf;
template <>
struct RowFormatOf<GlobalId> {
  static constexpr RowFormat value{Scalar::int64, 1};
};
template <>
struct RowFormatOf<float> {
  static constexpr RowFormat value{Scalar::float32, 1};
};
template <>
struct RowFormatOf<Real> {
  static constexpr RowFormat value{Scalar::float64, 1};
};
template <>
struct RowFormatOf<std::int32_t> {
  static constexpr RowFormat value{Scalar::int32, 1};
};
template <>
struct RowFormatOf<std::uint8_t> {
  static constexpr RowFormat value{Scalar::uint8, 1};
};
template <class T>
struct RowFormatOf<std::array<T, 3>> {
  static constexpr RowFormat value{RowFormatOf<T>::value.scalar, 3};
};
template <>
struct RowFormatOf<Vec3> {
  static constexpr RowFormat value{Scalar::float64, 3};
};

/// Rows [first, first + count) of `total`.
struct RowSlice {
  std::int64_t first = 0, count = 0, total = 0;
};

/// Slice `rank` of `size` slices that differ by at most one block; they begin at multiples of `block`.
inline RowSlice equal_slice(std::int64_t total, int rank, int size, std::int64_t block = 1) {
  const std::int64_t blocks = (total + block - 1) / block, blocks_each = blocks / size, rest = blocks % size;
  const auto start = [&](std::int64_t k) { return std::min(total, block * (blocks_each * k + std::min(k, rest))); };
  return {start(rank), start(rank + 1) - start(rank), total};
}

class Hdf5Handle {
 public:
  using Close = int (*)(std::int64_t);
  Hdf5Handle() = default;
  Hdf5Handle(std::int64_t id, Close closer) : id_(id), close_(closer) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Hdf5Handle() { close(); }

  std::int64_t id() const { return id_; }
  bool valid() const { return id_ >= 0; }
  bool close() { return !valid() || close_(std::exchange(id_, -1)) >= 0; }  ///< false when HDF5 reports a failure

 private:
  std::int64_t id_ = -1;
  Close close_ = nullptr;
};

/// From here on HDF5 prints no error stack of its own: every return value is checked and reported in one line.
void silence_hdf5();

/// The innermost reason on HDF5's error stack, e.g. "truncated file: eof = ...". To be called before any other handle
/// closes: each successful HDF5 call clears the stack.
std::string hdf5_reason();

/// HDF5's native type for a scalar (an hid_t that must not be closed).
std::int64_t native_type(Scalar scalar);

std::string hdf5_version();

}  // namespace trevi
