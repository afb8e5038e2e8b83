// Numbers of the cells of the projection's grid, several of each cell, laid out for loops over the cells of a row: first
// the first number of all cells of the row and of its ring, then the second of all. Planes and rings are those of
// ProjectionGrid. What lies beyond a row's own columns is 0: whoever writes a row writes all of its cells, and clears those
// that it no longer has. Not collective.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "projection/affine.hpp"
#include "projection/grid.hpp"

namespace trevi {

class CellFields {
 public:
  /// Numbers past the end of a row that may be read, as whole vectors are.
  static constexpr std::size_t padding = 8;

  /// `numbers` of each cell.
  explicit CellFields(std::size_t numbers) : numbers_(numbers) {}

  /// Memory for the grid as it is now, all of it 0.
  void resize(const ProjectionGrid& grid) {
    plane_ = grid.step(0);
    width_ = grid.step(1);
    cells_ = grid.cells();
    values_.assign(cells_ * numbers_ + padding, 0.0);
  }

  /// The first number of the lowest cell of row (k, r); −1 and rows() are the rows of the ring.
  Real* row(LocalId k, LocalId r) { return &values_[place(k, r)]; }
  const Real* row(LocalId k, LocalId r) const { return &values_[place(k, r)]; }
  /// From a number of a cell to its next one; neighbours in a row are beside one another.
  std::size_t width() const { return width_; }
  /// Clears the cells [columns) of a row; there may be none.
  void clear(LocalId k, LocalId r, Range columns) {
    if (columns.size() <= 0) return;
    Real* first = row(k, r) + columns.begin;
    for (std::size_t q = 0; q < numbers_; ++q, first += width_) std::fill_n(first, columns.size(), 0.0);
  }
  /// Fills the ring at the ends of a row where columns repeat.
  void repeat(const ProjectionGrid& grid, LocalId k, LocalId r) {
    if (!grid.repeats()[2]) return;
    for (Real* first = row(k, r); first < row(k, r) + numbers_ * width_; first += width_) {
      first[-1] = first[grid.columns() - 1];
      first[grid.columns()] = first[0];
    }
  }
  /// The first numbers of one cell as those of a T; for few cells only.
  template <class T>
  T cell(std::size_t at) const {
    T value;
    const Real* from = &values_[at / width_ * width_ * numbers_ + at % width_];
    for (std::size_t q = 0; q < sizeof(T) / sizeof(Real); ++q) reinterpret_cast<Real*>(&value)[q] = from[q * width_];
    return value;
  }

  /// Sets the first numbers of a cell to those of a T.
  template <class T>
  void set(LocalId k, LocalId r, LocalId c, const T& value) {
    Real* const to = row(k, r) + c;
    for (std::size_t q = 0; q < sizeof(T) / sizeof(Real); ++q) to[q * width_] = reinterpret_cast<const Real*>(&value)[q];
  }

  /// To exchange planes.
  std::span<Real> planes() { return std::span(values_).first(cells_ * numbers_); }
  std::size_t per_plane() const { return plane_ * numbers_; }
  std::size_t bytes() const { return values_.capacity() * sizeof(Real); }

 private:
  std::size_t place(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k) * plane_ * numbers_ + (static_cast<std::size_t>(r + 1) * numbers_) * width_ + 1;
  }

  std::size_t numbers_, plane_ = 0, width_ = 0, cells_ = 0;
  std::vector<Real> values_;
};

}  // namespace trevi
