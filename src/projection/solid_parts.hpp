// The parts of faces and cells that belong to each of several solids, beside freely moving bodies.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <span>
#include <tuple>
#include <vector>

#include "base/threads.hpp"
#include "boundary/obstacles/obstacles.hpp"

namespace trevi {

/// What one solid closes of face (a, at). Solids that do not float count as one, namely the nearest of them.
struct PartOfFace {
  std::size_t at, a, solid;
  Real share;      // of the closed part of the face
  Vec3 middle;     // centroid, m
  Real given = 0;  // displacement of a solid that does not float, m
};

/// What one solid fills of a cell that is near several.
struct PartOfCell {
  std::size_t at, solid;
  Real volume;                  // in cells
  std::array<float, 3> middle;  // centroid by direction, in cells from the corner of the cell
};

/// The parts of all faces near a freely moving body, and of all cells that it shares with other solids, in the order of
/// cells.
class SolidParts {
 public:
  /// At a face or in a cell: that many bodies, and other solids as one.
  static constexpr std::size_t max_bodies = 4, max_solids = max_bodies + 1;

  struct Found {
    std::vector<PartOfFace> of_faces;
    std::vector<PartOfCell> of_cells;
  };
  void collect(PerThread<Found>& found) {
    of_faces_.clear();
    of_cells_.clear();
    found.for_each([&](Found& some) {
      of_faces_.insert(of_faces_.end(), some.of_faces.begin(), some.of_faces.end());
      of_cells_.insert(of_cells_.end(), some.of_cells.begin(), some.of_cells.end());
    });
    std::sort(of_faces_.begin(), of_faces_.end(), [](const PartOfFace& f, const PartOfFace& g) {
      return std::tuple(f.at, f.a, f.solid) < std::tuple(g.at, g.a, g.solid);
    });
    std::sort(of_cells_.begin(), of_cells_.end(), [](const PartOfCell& f, const PartOfCell& g) {
      return std::pair(f.at, f.solid) < std::pair(g.at, g.solid);
    });
  }

  const std::vector<PartOfFace>& of_faces() const { return of_faces_; }
  /// The parts of face (a, at); `first`: number of the first part of the lower faces of the cell.
  std::span<const PartOfFace> of_face(std::size_t a, std::size_t at, std::size_t first) const {
    const auto is_of = [&](std::size_t n) { return n < of_faces_.size() && of_faces_[n].at == at; };
    while (is_of(first) && of_faces_[first].a < a) ++first;
    std::size_t end = first;
    while (is_of(end) && of_faces_[end].a == a) ++end;
    assert(end <= of_faces_.size());
    return std::span(of_faces_).subspan(first, end - first);
  }
  /// None if at most one solid is near the cell.
  std::span<const PartOfCell> of_cell(std::size_t at) const {
    const auto begin = std::lower_bound(of_cells_.begin(), of_cells_.end(), at,
                                        [](const PartOfCell& part, std::size_t of) { return part.at < of; });
    auto end = begin;
    while (end != of_cells_.end() && end->at == at) ++end;
    return {begin, end};
  }

 private:
  std::vector<PartOfFace> of_faces_;
  std::vector<PartOfCell> of_cells_;
};

/// The impulses that the pressure of a cell gives to its water at solids, m.
struct Pushes {
  static constexpr std::size_t max = 6 * 2 * SolidParts::max_solids + SolidParts::max_solids;
  std::array<Impulse, max> all;
  std::array<std::size_t, max> solid;  // on which each of them acts
  std::size_t count = 0;
  void add(std::size_t on, const Vec3& shift, const Vec3& place) {
    assert(count < max);
    solid[count] = on;
    all[count++] = {shift, place};
  }
};

}  // namespace trevi
