// Third and fourth stages of the projection: assembly and solution of the Poisson equation for displacements u = ∇phi
// that, added to the predicted displacements d of the faces, leave no divergence,
//   div(u + d) = r  in wet cells,   phi = 0 at the free surface,   u + d = 0 through walls,
// where r slowly returns each cell to its volume.
//
// Under gravity the surface lies where the water ends, not at the edge of a cell (the ghost-fluid method: Gibou et al.,
// J. Comput. Phys. 176, 2002; Enright et al. 2003). A face between a wet cell and a dry one has the weight 1/theta,
// where theta is the part of the distance between their centres that lies in water. Above a top cell this is the height
// of the surface above its centre; at its side, where the surface steps down by a cell, it follows from the levels of
// the two columns. Faces count as far as they are open, under water or not. A linear pressure is thus exact below an
// inclined surface, and water that moves as a whole has no divergence, whatever the fill of its cells, so that no
// pressure acts in flight. Without gravity phi is 0 at the centre of the first dry cell. Where cells are thinly filled,
// as at the sides of jets, u is ∇phi divided by the mass there (Gerszewski & Bargteil, ACM Trans. Graph. 32, 2013), so
// that the momentum and energy that a pressure takes from one side of a face are given to the other. (With the mass of
// the particles at every face, the noise of eight particles per cell costs energy: a vortex without viscosity then
// keeps 0.92 of it after 1 s, and 1.00 with uniform links.)
//
// The equation is solved by V-cycles of a multigrid (multigrid.hpp) that start from the hydrostatic pressure of each
// column, which is the exact solution for water at rest. Their number is fixed and there are no dot products, hence the
// same bits on any rank count. Where water separates, phi would pull it together, so it is limited to values ≤ 0. In
// water without a surface phi has no origin; it is set to 0 at the upper face of the cell where it is largest
// (enclosed_water.hpp). Collective.
#pragma once

#include "multigrid/multigrid.hpp"
#include "projection/free_surface.hpp"
#include "projection/sparse_rows.hpp"

namespace trevi {

class Pressure {
 public:
  Pressure(MPI_Comm comm, const Repeats& repeats, std::shared_ptr<Scratch> scratch = std::make_shared<Scratch>())
      : multigrid_(comm, repeats, Multigrid::few_cells, std::move(scratch)) {}

  /// Data of a step: the displacement by gravity g dt², m; the fraction of a cell's deviation from its volume that is
  /// removed in the step, which without gravity depends on the distance that the water travels; and the largest depth
  /// of the water, in cells.
  struct Step {
    Real g_dt2, return_fraction;
    int depth;
  };
  /// Assembles the equation, after which fills of cells are no longer needed; runs the first cycles; runs more cycles;
  /// and completes the pressure.
  void assemble(const FreeSurface& surface, Halo& halo, const Step& step);
  void begin(Halo& halo);
  void improve(Halo& halo, int more) { multigrid_.improve(halo, more); }
  /// To be called before these two where bodies have moved: see EnclosedWater::balance().
  void balance(const FreeSurface& surface, Halo& halo);
  /// Exchanges what displacement() needs before finish().
  void show(const FreeSurface& surface, Halo& halo);
  void finish(const FreeSurface& surface, Halo& halo);
  /// Gives back the memory of the pressure.
  void give_back() { multigrid_.give_back(); }
  /// Before begin() or between cycles: the displacement of the solid through the closed part of face (a, at) grows by
  /// `change`, m.
  void move_face(const FreeSurface& surface, std::size_t a, std::size_t at, Real change);
  /// The same: the room for the water of a cell grows by `change`, as a share of the cell.
  void make_room(const FreeSurface& surface, std::size_t at, Real change) {
    if (surface.is_wet(at)) multigrid_.finest().rhs[at] += change;
  }

  /// Displacement through face (a, at) between two cells at least one of which is wet, m.
  Real displacement(const FreeSurface& surface, std::size_t a, std::size_t at) const {
    const std::size_t below = at - surface.grid().step(a);
    return (phi_so_far(at) - phi_so_far(below)) / surface.grid().size()[static_cast<Eigen::Index>(a)] /
           surface.resistance(a, at);
  }

  /// The share, from 0 to 1, of what arrives in a cell that an obstacle cuts for which it has room.
  Real taken_in(LocalId k, LocalId r, LocalId c) const {
    const Real* const share = taken_in_.find(k, r, static_cast<std::uint32_t>(c));
    return share != nullptr ? *share : 0;
  }

  /// phi of a cell, m².
  Real phi(std::size_t at) const { return multigrid_.finest().phi[at]; }
  const Real* all_phi() const { return multigrid_.finest().phi.data(); }
  /// Inflow of a cell from inlets, as a share of the cell.
  struct Inflow {
    std::size_t cell;
    Real share;
    Real path;                          ///< of the water, in cells, as if the wall behind let it through
    const Openings::Gain* out_of_wall;  ///< if it does; otherwise null
  };
  const std::vector<Inflow>& inflow() const { return inflow_; }
  /// phi as finish() will limit it: to at most 0, but not in water without a surface, which nothing can part.
  Real phi_so_far(std::size_t at) const { return enclosed_->holds(at) ? phi(at) : std::min(phi(at), 0.0); }

  std::size_t bytes() const { return multigrid_.bytes() + taken_in_.bytes(); }

 private:
  void weigh_row(const FreeSurface& surface, LocalId k, LocalId r);
  void find_sources(const FreeSurface& surface, const Step& step, LocalId k, LocalId r);
  void find_flow_through_walls(const FreeSurface& surface);
  void find_inflow(const FreeSurface& surface);
  void fit_inflow(MPI_Comm comm);
  static bool stands_on_floor(const FreeSurface& surface, const Openings::Gain& gain);
  void drop_air_links(const FreeSurface& surface, LocalId k, LocalId r);
  Real divergence(const FreeSurface& surface, std::size_t at, bool moved) const;
  struct Filling {
    Real flow, share;  // what the cell resists; the share of what arrives that it takes in
  };
  static Filling without_filling(const FreeSurface& surface, const Step& step, std::size_t at, Real flow);
  Real returned(const FreeSurface& surface, const Step& step, LocalId k, LocalId r, LocalId c) const;
  bool may_swell(const FreeSurface& surface, LocalId k, LocalId r, LocalId c) const;
  void guess_below(const FreeSurface& surface, Real step, std::size_t begin, std::size_t end);
  void set_hydrostatic_guess(const FreeSurface& surface, Real g_dt2, LocalId k, LocalId r);

  const EnclosedWater* enclosed_ = nullptr;  // that of the surface, since assemble()
  // The largest phi of each piece of water without a surface, m²: the pressure is 0 at the upper face of that cell.
  // Beside a floating body it is the mean phi, that of water at rest.
  std::vector<Real> origins_;
  bool among_solids_ = false;
  SparseRows taken_in_;
  std::vector<Inflow> inflow_;
  std::vector<EnclosedWater::Flow> through_walls_;  // into water without a surface
  // Its links first hold the weight of each face: the open fraction of its area, divided by the mass of the water there
  // and by the distance between the points on its two sides where phi is given, in cells; 0 where nothing passes.
  Multigrid multigrid_;
};

}  // namespace trevi
