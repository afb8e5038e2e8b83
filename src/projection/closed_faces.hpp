// How far the water moves into the closed faces of its cells, as the prediction has it: all of the displacements of
// faces that is needed once the equation stands (grid_to_particles.hpp), and far less memory than these. Not
// collective.
#pragma once

#include <cstdint>
#include <vector>

#include "projection/free_surface.hpp"

namespace trevi {

class ClosedFaces {
 public:
  /// Of the wet cells that hold particles, or are beneath a cell that does, in the own rows.
  void find(const FreeSurface& surface);
  /// The displacement of the water at such a face, m.
  Real displacement(const CellFace& face, LocalId k, LocalId r, LocalId c) const;
  std::size_t bytes() const;

 private:
  struct Known {
    std::uint32_t number;  // of the face in its row
    Real displacement;
  };
  static std::uint32_t number_of(const CellFace& face, LocalId c) {
    return static_cast<std::uint32_t>(c) * 6 + static_cast<std::uint32_t>(2 * face.a) + (face.upper ? 1 : 0);
  }
  void find_in_row(const FreeSurface& surface, LocalId k, LocalId r);

  LocalId rows_of_plane_ = 0;
  std::vector<std::vector<Known>> rows_;  // in the order of their numbers
};

}  // namespace trevi
