// The predicted displacements of the water into the closed faces of its cells. Once the equation is assembled, these
// are the only displacements of faces that are still needed (grid_to_particles.hpp), and they take far less memory than
// all of them. Not collective.
#pragma once

#include <cstdint>
#include <vector>

#include "projection/free_surface.hpp"
#include "projection/sparse_rows.hpp"

namespace trevi {

class ClosedFaces {
 public:
  /// Finds them for the wet cells in the owned rows that hold particles or are below a cell that does.
  void find(const FreeSurface& surface);
  /// The displacement of the water at such a face, m.
  Real displacement(const CellFace& face, LocalId k, LocalId r, LocalId c) const;
  std::size_t bytes() const { return rows_.bytes(); }

 private:
  static std::uint32_t number_of(const CellFace& face, LocalId c) {
    return static_cast<std::uint32_t>(c) * 6 + static_cast<std::uint32_t>(2 * face.a) + (face.upper ? 1 : 0);
  }
  void find_in_row(const FreeSurface& surface, LocalId k, LocalId r);

  SparseRows rows_;
};

}  // namespace trevi
