// Fifth stage of the projection: it transfers the solution on the grid to the particles.
//
// *Pressure.* A particle takes the displacement of the faces of its cell, linear in between in each direction
// (lowest-order Raviart–Thomas). Under gravity this is found in the middle of its path, and all but what bears the
// weight acts at the beginning (pull_back()): a force that acts there has no torque about a centre to which it points.
// Without gravity it is found where the path begins. Above the surface it fades out, so that water thrown up falls
// back.
//
// *Walls.* A closed face of the box absorbs the motion into it. In a cell that a solid cuts, closed faces continue the
// displacement δ that the pressure causes at the open ones, extrapolated to the surface, or along a direction without
// open faces the displacement that bears the weight. They stop only the motion into the solid. With n the mean normal
// of the surface in the cell, by Gauss's theorem from the areas of its faces, they are displaced by δ − n (n · u_s +
// n · δ), where u_s is the motion of the water at the surface relative to the solid, from the flux through the open
// faces. Water thus slips along walls of any direction. Horizontally the displacement of a closed face is extrapolated
// linearly from the opposite open face through that displacement at the surface: the path of a particle goes through
// cells whose walls have different directions, and constant displacements beside them slow down rotating water.
//
// *Noise.* Smooth motion is kept, and differences between particles decay within noise_time. With the filter
// F u = Σ_c w_c (fit_c u − u)/Σ_c w_c over the cells around a particle, and the fits of what F leaves, the damping is F
// applied twice. It does not affect affine motion, and damps a wave of wavelength L in proportion to (h/L)^4. Each fit
// pulls all the particles from which it was made, with the weights with which it was made, so its normal equations
// conserve linear and angular momentum. In cut cells, where noise is generated, the motion relaxes to the fit itself,
// the more slowly the smoother it is; at solids that move in the water only near the surface.
//
// Collective: prepare().
#pragma once

#include <optional>

#include "projection/closed_faces.hpp"
#include "projection/pressure.hpp"

namespace trevi {

/// phi is found at y, where the motion is evaluated, and acts at x, where paths begin. The gradient of phi(y(x)) is
/// (I + Bᵀ/2) times that at y, with the slope B of the motion, whose y is in cells (README.md). `held`, m: the upward
/// part that stays as it is.
void pull_back(const AffineMap& motion, const ByAxis& per_length, Real held, CellDisplacement& by);

/// The smaller of two displacements into a wall, by the linear mean and by the mean of the particles; 0 if these differ
/// in sign.
Real bounded(Real by_slope, Real by_mean);

class GridToParticles {
 public:
  /// `spacing` of the initial lattice and `h`, m. Fits of the noise overwrite `spreads`, those of the fits of the
  /// motion.
  GridToParticles(const FreeSurface& surface, CellFields& spreads, Real spacing, Real h)
      : surface_(surface), spacing_(spacing), h_(h), noise_fit_(spreads) {}

  /// Data of a step: the displacement by gravity, g dt², m, and dt in units of sqrt(h/g); both 0 without gravity.
  struct Step {
    Real g_dt2, time;
  };
  /// Finds the motion of the water into closed faces, so that the displacements of faces are needed only until the
  /// equation is assembled. With gravity it also finds the noise and its fits, in memory that is borrowed until
  /// give_back(); without gravity nothing generates noise.
  void prepare(Halo& halo, const Step& step);
  /// Among obstacles, once the pressure is known: finds the change of its displacement across the cells beside them, in
  /// memory that is borrowed until give_back(). Collective.
  void find_rises(const Pressure& pressure, Halo& halo);
  /// Once the pressure is known: finds the mean upward displacement in each cell, in memory that is borrowed until
  /// give_back().
  void find_mean_rises(const Pressure& pressure);
  /// The damping in a row of cells: maps whose `weight` is the share that a particle loses of its own motion. There is
  /// one for each part of a loop that threads share, in which the rows come in their order.
  struct Damping {
    std::vector<FourCells> row;
    std::array<TentMemory, 3> memories;  // of the fits of noise, of the motion, and of that in cut cells
  };
  void find_damping(Damping& damping, LocalId k, LocalId r) const;
  /// The displacement of the particles of cell (k, r, c).
  CellDisplacement displacement_of(const Pressure& pressure, const Damping& damping, LocalId k, LocalId r,
                                   LocalId c) const;
  /// Whether particles of a cell are displaced. Without gravity those of dry cells are, too, by those of their faces
  /// that are known.
  bool displaces(std::size_t at) const { return !surface_.upright() || surface_.is_wet(at) || follows(at); }
  /// The displacement of a cell, linear between the faces of each direction, as found. Needs the pressure so far alone,
  /// and no other result of this class but those of prepare() and, at obstacles, find_rises().
  CellDisplacement between_faces(const Pressure& pressure, LocalId k, LocalId r, LocalId c) const;
  /// The same where it acts (README.md), after find_mean_rises(), without damping and without the fade at the surface.
  CellDisplacement displacement_by_faces(const Pressure& pressure, LocalId k, LocalId r, LocalId c) const;
  /// To be called when all particles have been displaced.
  void give_back() {
    cut_fit_.give_back();
    for (Borrowed<Real>& of : rise_) of.give_back();
    mean_rise_.give_back();
  }
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
  // The surface of a solid in a cell: its mean normal, by directions of the grid, and the motion into it, m.
  struct SolidSurface {
    Vec3 normal;
    Real into;
  };
  Real rise_across(const Pressure& pressure, std::size_t a, LocalId k, LocalId r, LocalId c) const;
  Real at_surface(std::size_t a, std::size_t at, const FacePair& faces) const;
  Vec3 at_surface(std::size_t at, std::size_t own, const Faces& faces) const;
  std::optional<SolidSurface> solid_surface(std::size_t at, std::size_t own, const Faces& faces,
                                            const Vec3& pushed) const;
  void slip(std::size_t at, std::size_t own, Faces& faces) const;
  static void let_in(Real share, Faces& faces);
  void pull_back_beyond_weight(std::size_t cell, CellDisplacement& by) const;
  bool is_water(std::size_t at) const { return surface_.is_wet(at) && !surface_.is_solid(at); }
  std::array<Real, 3> mean_path(std::size_t at) const;
  bool mirrors(const CellFace& face, LocalId k, LocalId r, LocalId c) const;
  Real mean_rise(const Pressure& pressure, LocalId k, LocalId r, LocalId c) const;
  Real change_of_rise(std::size_t a, LocalId k, LocalId r, LocalId c) const;
  Real mixed_difference(const Pressure& pressure, LocalId k, LocalId r, LocalId c) const;
  void move_back_across(const Pressure& pressure, LocalId k, LocalId r, LocalId c, CellDisplacement& by) const;
  Real moved(std::size_t a, std::size_t face) const;
  Real through_open(const Pressure& pressure, std::size_t a, std::size_t face, std::size_t at) const;
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
  CellFields noise_{numbers::flow};   // the result of the first pass of the filter
  CellFields& noise_fit_;             // its fit, times the rate of the cell
  CellFields cut_fit_{numbers::map};  // in cut cells the fit of the motion itself, times its rate
  // Along planes and along rows the difference of the pressure's displacement between the upper and the lower face of a
  // cell, m, where both are open and in the water, else 0; for cells beside solids.
  std::array<Borrowed<Real>, 2> rise_;
  Borrowed<Real> mean_rise_;  // upwards, of cells in the water, m; otherwise not a number
};

}  // namespace trevi
