// What a face of the projection gives to particles besides its displacement by pressure, so that the work of the
// pressure on them is that on the faces.
//
// A face moves by the mean over the particles in the cells beside it, of the weight W in all (particles_to_grid.hpp),
// which is n̄ in full water, and the pressure is found as if W were n̄. Particles that take the displacement δ of the
// face get W δ of impulse in place of n̄ δ. What of δ is smooth accelerates the water as a whole, and W is n̄ in the mean
// of many faces. The rest, δ', answers to the few particles that are there, and varies with W: its work
// Σ (W − n̄) u·δ' does not add up to nothing, and water that sheared lost energy by it at any step. So particles share
// the impulse n̄ δ': each takes n̄/W δ', of which δ' comes with the face, and (n̄/W − 1) δ' is found here, with n̄/W
// between min_portion and max_portion.
//
// δ' is what δ has beyond the mean of the eight faces around in the plane of the face, of which those at corners count
// half; in a layer, of the two on both sides. Faces between other than full cells count as if they moved like the face
// itself, and have no shares: at tops, in solids, and where water is thin, which has its mass in the equation. A cell
// is full that is wet and no top, of the mass 1 (FreeSurface::mass()), and not cut; closed faces have no shares.
// Not collective.
#pragma once

#include <array>
#include <vector>

#include "projection/pressure.hpp"

namespace trevi {

class FaceShares {
 public:
  /// `spacing` of the start lattice, m.
  FaceShares(const FreeSurface& surface, Real spacing);

  /// From the final pressure, in memory that is borrowed until give_back().
  void find(const Pressure& pressure);
  void give_back();
  /// Adds what the particles of the own cell `at` take, linear between its faces.
  void add_to(CellDisplacement& by, std::size_t at) const;

 private:
  // Rows of faces around one in its plane: how far on they are stored, and how often each face of them counts.
  struct RowAround {
    std::ptrdiff_t offset;
    Real weight;
  };
  struct Around {
    std::array<RowAround, 9> rows;
    std::size_t count;
    bool has_columns;  // whether its plane has the direction of the row, along which one counts twice
  };
  struct Row {
    std::size_t a;
    LocalId k, r;
  };
  // Of the cells of a row, and one at either end: weights of faces between full cells, and of these times the rise of
  // phi.
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
  Borrowed<Real> full_;                  // 1 in full cells; else 0
  std::array<Borrowed<Real>, 3> share_;  // (n̄/W − 1) δ', m
};

}  // namespace trevi
