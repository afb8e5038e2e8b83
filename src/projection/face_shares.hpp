// The displacement that a face of the projection gives to particles in addition to its own displacement by pressure, so
// that the work of the pressure on the particles equals that on the faces.
//
// A face moves by the mean over the particles in the cells beside it, whose total weight is W (particles_to_grid.hpp).
// In full water W is n̄, and the pressure is computed as if W were n̄ everywhere. Particles that take the displacement
// δ of the face thus get the impulse W δ instead of n̄ δ. The smooth part of δ accelerates the water as a whole, and W
// is n̄ on average over many faces. The rest, δ', responds to the few particles that are there and varies with W. Its
// work Σ (W − n̄) u·δ' does not cancel, and sheared water lost energy by it at any step. The particles therefore share
// the impulse n̄ δ': each takes n̄/W δ', of which δ' comes with the face and (n̄/W − 1) δ' is computed here, with n̄/W
// between min_portion and max_portion.
//
// δ' is the part of δ beyond the mean of the eight surrounding faces in the plane of the face, of which those at
// corners count half; in a layer, beyond the mean of the two on both sides. Faces that are not between full cells count
// as if they moved like the face itself, and have no shares: at tops, in solids, and where water is thin, for which the
// equation contains the mass. A cell is full if it is wet, not a top, not cut, and of mass 1 (FreeSurface::mass()).
// Closed faces have no shares. Not collective.
#pragma once

#include <array>
#include <vector>

#include "projection/pressure.hpp"

namespace trevi {

class FaceShares {
 public:
  /// `spacing` of the initial lattice, m.
  FaceShares(const FreeSurface& surface, Real spacing);

  /// Computes the shares from the final pressure, in memory that is borrowed until give_back().
  void find(const Pressure& pressure);
  void give_back();
  /// Adds the shares of the particles of the owned cell `at`, linear between its faces.
  void add_to(CellDisplacement& by, std::size_t at) const;

 private:
  // The rows of faces around a face in its plane: their offset in memory, and the weight of each of their faces.
  struct RowAround {
    std::ptrdiff_t offset;
    Real weight;
  };
  struct Around {
    std::array<RowAround, 9> rows;
    std::size_t count;
    bool has_columns;  // whether its plane contains the direction of the row, along which a face counts twice
  };
  struct Row {
    std::size_t a;
    LocalId k, r;
  };
  // For the cells of a row, and one at either end: sums of the weights of faces between full cells, and of these
  // weights times the rise of phi.
  struct Sums {
    std::vector<Real> faces, rise;
    void resize(std::size_t count) {
      faces.resize(count);
      rise.resize(count);
    }
  };
  bool is_full(std::size_t at) const;
  void find_full();
  Around around_face(std::size_t a) const;
  void sum_rows(const Real* phi, const Around& around, std::size_t a, std::size_t floor, Sums& sums) const;
  void find_row(const Real* phi, const Around& around, const Row& row);

  const FreeSurface& surface_;
  Real full_particles_;                  // n̄
  Borrowed<Real> full_;                  // 1 in full cells, otherwise 0
  std::array<Borrowed<Real>, 3> share_;  // (n̄/W − 1) δ', m
};

}  // namespace trevi
