// What a face of the projection gives to particles beside its displacement by pressure, so that the work of the
// pressure on them is that on the faces.
//
// A face moves by the mean over W particles by weight (particles_to_grid.hpp), n̄ in full water, and the pressure is
// found for n̄. If all particles take the displacement δ of the face they get W δ for n̄ δ of impulse. What of δ is
// smooth accelerates water as a whole, and is right in the mean of faces. The rest δ' comes from the few particles
// themselves, with W, and does work of its own, Σ (W − n̄) u·δ', by which water that shears lost energy at any step. So
// particles take the impulse n̄ δ' of that together: each of them n̄/W δ'.
//
// δ' is what δ has beyond the mean of the faces around in the plane of the face, with half of the weight at corners;
// faces that are not in full water count as the face itself. Beside surfaces and solids particles take δ alone: what
// they are fewer by there is air or solid, and thin water has its mass in the equation (FreeSurface::resistance()).
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

  /// Of the pressure when it is final, in memory that is borrowed until give_back().
  void find(const Pressure& pressure);
  void give_back();
  /// Beyond the displacement of face (a, at), m; nothing before find().
  Real beyond(std::size_t a, std::size_t at) const { return beyond_[a].empty() ? 0 : beyond_[a][at]; }

 private:
  // Rows of faces around one in its plane, by their distance in cells, and how often each of them counts.
  struct RowAround {
    std::ptrdiff_t offset;
    Real weight;
  };
  struct Around {
    std::vector<RowAround> rows;
    Real others;       // the weight of all faces around, without the one
    bool has_columns;  // whether its plane has the direction of the row, along which one counts twice
  };
  struct FaceRow {
    std::size_t a;
    LocalId k, r;
  };
  // Of the cells of a row, and one at either end: weights of faces in full water, and of these times the rise of phi.
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
  void sum_rows(const Pressure& pressure, const Around& around, std::size_t a, std::size_t floor, Sums& sums) const;
  void find_row(const Pressure& pressure, const Around& around, const FaceRow& row);

  const FreeSurface& surface_;
  Real full_particles_;
  Borrowed<Real> full_;  // 1 in cells of full water; else 0
  std::array<Borrowed<Real>, 3> beyond_;
};

}  // namespace trevi
