// The predicted displacements of the water into the closed faces of its cells. Once the equation is assembled, these
// are the only displacements of faces that are still needed (grid_to_particles.hpp), and they take far less memory than
// all of them. Not collective.
#pragma once

#include <cstdint>
#include <vector>

#include "projection/free_surface.hpp"

namespace trevi {

class ClosedFaces {
 public:
  /// Finds them for the wet cells in the owned rows that hold particles or are below a cell that does.
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
  std::size_t row_index(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k - 1) * static_cast<std::size_t>(rows_of_plane_) + static_cast<std::size_t>(r);
  }
  void find_in_row(const FreeSurface& surface, LocalId k, LocalId r);

  LocalId rows_of_plane_ = 0;
  std::vector<std::vector<Known>> rows_;  // in the order of their numbers
};

}  // namespace trevi
