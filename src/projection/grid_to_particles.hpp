// Fifth stage of the projection: what the grid's solution does to the particles.
//
// *Pressure.* A particle takes the displacement of the faces of its cell, linear in between in each direction
// (lowest-order Raviart and Thomas), at the beginning of its path: a force that acts there has no torque about a centre
// it points to. What exceeds the weight by half, and all beyond it in cells that solids cut, but bodies, acts by its
// gradient there (pull_back()). Above the surface it fades out, so that water thrown up falls back.
//
// *Walls.* A closed face of the box takes what goes into it. In a cell that a solid cuts, closed faces carry on what
// pressure does at its open ones, δ in the mean, or what bears the weight along a direction that has none, and stop
// only what goes into the solid: with n the mean normal of the surface in the cell, by Gauss's theorem from the areas
// of its faces, they are displaced by δ − n (n · u_s + n · δ), u_s being the motion of the water at the surface past
// the solid, from the flux through the open faces. Water so slips along walls of any direction. Horizontally a closed
// face takes what continues linearly from the opposite open face to that displacement where the surface is: a
// particle's path goes through cells whose walls have different directions, and constant displacements beside them
// brake water that turns.
//
// *Noise.* What is smooth is kept, what differs from particle to particle dies away in noise_time. With the filter
// F u = Σ_c w_c (fit_c u − u)/Σ_c w_c over the cells around a particle, and the fits of what F leaves, the damping is F
// applied twice: affine motion is not touched, a wave of wavelength L with (h/L)^4. As each fit pulls all the particles
// that it was made of, with the weights it was made with, its normal equations keep linear and angular momentum. In cut
// cells, where noise is made, the motion relaxes to the fit itself, the slower the smoother it is; at solids that move
// in the water near the surface only.
//
// Collective: prepare().
#pragma once

#include <optional>

#include "projection/closed_faces.hpp"
#include "projection/pressure.hpp"

namespace trevi {

/// phi is found where the motion is seen, y, and acts where paths begin, x: of phi(y(x)) the gradient is (I + Bᵀ/2)
/// times that at y, with the slope B of the motion, whose y is in cells (README.md). `by` takes a share of that, and
/// the rest at x as if it were found there, as what bears weight is: volumes are those at x. `held`, m: its upward
/// part.
void pull_back(const AffineMap& motion, const ByAxis& per_length, Real held, Real share, CellDisplacement& by);

class GridToParticles {
 public:
  /// `spacing` of the start lattice, `h`, m. Fits of noise take the place of the `spreads` of the motion's.
  GridToParticles(const FreeSurface& surface, CellFields& spreads, Real spacing, Real h)
      : surface_(surface), spacing_(spacing), h_(h), noise_fit_(spreads) {}

  /// Of a step: how far gravity moves a particle down, g dt², m, and dt in units of sqrt(h/g); 0 without gravity.
  struct Step {
    Real g_dt2, time;
  };
  /// Finds how the water moves into closed faces, of which displacements are not needed any more, and noise and its
  /// fits, in memory that is borrowed until give_back(), but without gravity: nothing makes noise there.
  void prepare(Halo& halo, const Step& step);
  /// The damping in a row of cells: maps of which `weight` is what a particle loses of its own motion. One for each
  /// part of a loop of threads, in which rows come in their order.
  struct Damping {
    std::vector<FourCells> row;
    std::array<TentMemory, 3> memories;  // of the fits of noise, of the motion, and of that in cut cells
  };
  void find_damping(Damping& damping, LocalId k, LocalId r) const;
  /// How the particles of cell (k, r, c) are displaced.
  CellDisplacement displacement_of(const Pressure& pressure, const Damping& damping, LocalId k, LocalId r,
                                   LocalId c) const;
  /// Whether particles of a cell are displaced: without gravity those of dry cells are, by what of their faces is
  /// known.
  bool displaces(std::size_t at) const { return !surface_.upright() || surface_.is_wet(at) || follows(at); }
  /// The same by the faces alone, without damping and the fade at the surface.
  CellDisplacement displacement_by_faces(const Pressure& pressure, LocalId k, LocalId r, LocalId c) const;
  /// To be called when all particles are displaced.
  void give_back() { cut_fit_.give_back(); }
  std::size_t bytes() const { return closed_.bytes(); }

 private:
  // The lower and the upper displacement in each direction, and whether the face is closed.
  struct FacePair {
    Real low = 0, high = 0;
    bool low_closed = false, high_closed = false, low_wall = false, high_wall = false;
  };
  using Faces = std::array<FacePair, 3>;
  FacePair faces_of(const Pressure& pressure, std::size_t a, LocalId k, LocalId r, LocalId c) const;
  bool follows(std::size_t at) const;
  // Of a solid in a cell: its mean normal, by directions of the grid, and what goes into it, m.
  struct SolidSurface {
    Vec3 normal;
    Real into;
  };
  Vec3 by_open_faces(std::size_t at, const Faces& faces) const;
  std::optional<SolidSurface> solid_surface(std::size_t at, std::size_t own, const Faces& faces,
                                            const Vec3& pushed) const;
  void slip(std::size_t at, std::size_t own, Faces& faces) const;
  void pull_back_beyond_weight(std::size_t cell, CellDisplacement& by) const;
  Real moved(std::size_t a, std::size_t face) const;
  Real through_closed(const CellFace& face, LocalId k, LocalId r, LocalId c) const;
  Real rate(Real rest2) const;
  Real part_of_noise(LocalId k, LocalId r, LocalId c, Real rest2) const;
  bool is_near_surface(std::size_t floor, LocalId c) const;
  void find_noise(TentMemory& memory, LocalId k, LocalId r);
  void fit_noise(TentMemory& memory, LocalId k, LocalId r);
  void fit_cut_cells(LocalId k, LocalId r, std::span<const Real> rates);

  const FreeSurface& surface_;
  Real spacing_, h_;
  Step step_{};
  ClosedFaces closed_;
  CellFields noise_{numbers::flow};   // what the filter's first pass leaves
  CellFields& noise_fit_;             // the fit of that, times the rate of its cell
  CellFields cut_fit_{numbers::map};  // in cut cells that of the motion itself, times its rate
};

}  // namespace trevi
