#include "projection/pressure.hpp"

namespace trevi {

using namespace projection;

void Pressure::assemble(const FreeSurface& surface, Halo& halo, const Step& step) {
  const ProjectionGrid& grid = surface.grid();
  const LocalId planes = grid.planes();
  enclosed_ = &surface.enclosed();
  among_solids_ = surface.cuts() != nullptr;
  const Range own{1, planes + 1}, own_and_above{1, planes + 2}, all{0, planes + 2};
  if (among_solids_) taken_in_.resize(grid);
  multigrid_.resize(halo.cuts(), grid.count(1), grid.columns(), step.depth);
  for_each_row(grid.rows_of(all), [&](LocalId k, LocalId r) {
    multigrid_.finest().use_columns(k, r, static_cast<std::size_t>(grid.columns(k, r)));
  });
  for_each_row(grid.rows_of(own_and_above), [&](LocalId k, LocalId r) { weigh_row(surface, k, r); });
  grid.complete(halo, multigrid_.finest().link[1]);
  if (grid.repeats()[2]) grid.repeat(multigrid_.finest().link[2]);
  for_each_row(grid.rows_of(own), [&](LocalId k, LocalId r) { find_sources(surface, step, k, r); });
  if (surface.openings() != nullptr) {
    find_flow_through_walls(surface);
    find_inflow(surface);
    if (enclosed_->any() && surface.openings()->has_sources()) fit_inflow(halo.comm());
    for (const Inflow& one : inflow_) multigrid_.finest().rhs[one.cell] -= one.share;
  }
  for_each_row(grid.rows_of(own_and_above), [&](LocalId k, LocalId r) { drop_air_links(surface, k, r); });
  for_each_row(grid.rows_of(all), [&](LocalId k, LocalId r) { set_hydrostatic_guess(surface, step.g_dt2, k, r); });
  if (enclosed_->any())
    origins_ = enclosed_->origins(surface, halo.comm(), multigrid_.finest().phi, -step.g_dt2 * grid.size()[2] / 2);
}

void Pressure::begin(Halo& halo) { multigrid_.solve(halo, enclosed_->any() ? closed_cycles : cycles, among_solids_); }

void Pressure::balance(const FreeSurface& surface, Halo& halo) {
  enclosed_->balance(surface, halo.comm(), multigrid_.finest().rhs);
}

void Pressure::move_face(const FreeSurface& surface, std::size_t a, std::size_t at, Real change) {
  const Real size = surface.grid().size()[static_cast<Eigen::Index>(a)];
  const std::size_t step = surface.grid().step(a);
  if (at < step) return;  // the face is in the lowest ghost plane
  make_room(surface, at, -surface.cuts()->closed(a, at, false) * change / size);
  make_room(surface, at - step, surface.cuts()->closed(a, at - step, true) * change / size);
}

void Pressure::show(const FreeSurface& surface, Halo& halo) {
  if (enclosed_->any()) enclosed_->set_origins(surface, halo, multigrid_.finest().phi, origins_);
  surface.grid().complete(halo, multigrid_.finest().phi);
}

void Pressure::finish(const FreeSurface& surface, Halo& halo) {
  const ProjectionGrid& grid = surface.grid();
  multigrid_.give_back_all_but_phi();
  if (enclosed_->any()) enclosed_->set_origins(surface, halo, multigrid_.finest().phi, origins_);
  for_each_row(grid.rows_of({0, grid.planes() + 2}), [&](LocalId k, LocalId r) {
    for (LocalId c = 0; c < grid.columns(k, r); ++c) {
      const std::size_t at = grid.index(k, r, c);
      multigrid_.finest().phi[at] = phi_so_far(at);
    }
  });
  grid.complete(halo, multigrid_.finest().phi);
}

// Where rows do not repeat, the row beyond the last one has no water; its lower faces are walls and keep the weight
// zero.
void Pressure::weigh_row(const FreeSurface& surface, LocalId k, LocalId r) {
  const ProjectionGrid& grid = surface.grid();
  auto& weight = multigrid_.finest().link;
  for (LocalId c = 0; c <= grid.columns(k, r); ++c) {
    const std::size_t at = grid.index(k, r, c);
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t below = at - grid.step(a);
      const bool low = surface.is_wet(below), high = surface.is_wet(at);
      weight[a][at] = 0;
      const Real open = surface.face(a, at);
      if (grid.is_wall(a, k, r, c) || (!low && !high) || open == 0) continue;
      weight[a][at] = open / surface.resistance(a, at);
    }
  }
}

namespace {

bool is_anything_moved(const FreeSurface& surface) { return surface.cuts() != nullptr && surface.cuts()->moves(); }

}  // namespace

void Pressure::find_sources(const FreeSurface& surface, const Step& step, LocalId k, LocalId r) {
  const ProjectionGrid& grid = surface.grid();
  MultigridLevel& cells = multigrid_.finest();
  const Vec3 stiffness = grid.size().cwiseProduct(grid.size()).cwiseInverse();
  const Range moved = is_anything_moved(surface) ? surface.cuts()->cut_columns(k, r) : Range{0, 0};
  std::vector<SparseRows::Entry>* const taken_in = among_solids_ ? &taken_in_.begin_row(k, r) : nullptr;
  for (LocalId c = 0; c < grid.columns(k, r); ++c) {
    const std::size_t at = grid.index(k, r, c);
    cells.rhs[at] = cells.dirichlet[at] = 0;
    if (!surface.is_wet(at)) continue;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t face = grid.step(a);
      const Real low = surface.is_wet(at - face) ? 0 : cells.link[a][at];
      const Real high = surface.is_wet(at + face) ? 0 : cells.link[a][at + face];
      cells.dirichlet[at] += stiffness[static_cast<Eigen::Index>(a)] * (low + high);
    }
    Filling filling{divergence(surface, at, c >= moved.begin && c < moved.end), 0};
    if (surface.fill(at) < full_enough && !enclosed_->holds(at) && (surface.is_cut(at) || may_swell(surface, k, r, c)))
      filling = without_filling(surface, step, at, filling.flow);
    if (filling.share > 0) taken_in->push_back({static_cast<std::uint32_t>(c), filling.share});
    cells.rhs[at] = filling.flow - returned(surface, step, k, r, c);
  }
}

// The cell in front of an opening contains what flows through it and does not return to its volume. Water that leaves
// takes with it the whole height of the water in the cell; water that enters takes the part that the opening covers,
// divided by that height.
void Pressure::find_flow_through_walls(const FreeSurface& surface) {
  Borrowed<Real>& rhs = multigrid_.finest().rhs;
  const std::vector<Openings::Face>& faces = surface.openings()->faces();
  through_walls_.clear();
  for (const Openings::Face& face : faces) {
    if (surface.is_wet(face.cell)) rhs[face.cell] = divergence(surface, face.cell, is_anything_moved(surface));
  }
  for (const Openings::Face& face : faces) {
    if (!surface.is_wet(face.cell)) continue;
    const Real height = std::min(surface.height(face.cell), 1.0);
    const Real share = (face.takes_all ? std::min(face.covered, height) : face.covered) / height;
    const Real flow = share * surface.openings()->displacement(face.a, face.at) /
                      surface.grid().size()[static_cast<Eigen::Index>(face.a)];
    rhs[face.cell] += face.at_max ? flow : -flow;
    if (enclosed_->holds(face.cell)) through_walls_.push_back({face.cell, 0, face.at_max ? flow : -flow});
  }
}

// Water from an inlet under water needs room in cells with water behind the opening, or with a wall behind it and water
// down to the floor. Beside air it needs no more than what the moving water vacates: out of a wall in the air, the
// water moves on as if the wall let it through, because the wall would otherwise hold it back.
void Pressure::find_inflow(const FreeSurface& surface) {
  inflow_.clear();
  const auto is_full = [&](std::size_t at) { return surface.is_wet(at) && surface.fill(at) >= wet_fill; };
  for (const Openings::Gain& gain : surface.openings()->gains()) {
    if (!surface.is_wet(gain.cell) || surface.is_solid(gain.cell)) continue;
    const bool wall = gain.wall_behind || surface.is_solid(gain.behind);
    if (!wall && !is_full(gain.behind) && !enclosed_->holds(gain.behind)) continue;
    const bool swells = may_swell(surface, gain.k, gain.r, gain.c);
    const bool in_air = wall && !enclosed_->holds(gain.cell) && (swells || !stands_on_floor(surface, gain));
    Real share = in_air && !surface.is_cut(gain.cell) ? std::abs(gain.path) : gain.share;
    if (in_air || swells) share = std::clamp(divergence(surface, gain.cell, is_anything_moved(surface)), 0.0, share);
    const bool through_wall = wall && gain.path != 0 && enclosed_->holds(gain.cell);
    inflow_.push_back({gain.cell, share, in_air ? gain.path : 0, in_air || through_wall ? &gain : nullptr});
  }
}

// In water without a surface there is room only for what leaves through walls.
void Pressure::fit_inflow(MPI_Comm comm) {
  std::vector<EnclosedWater::Flow> flows;
  for (const Inflow& one : inflow_) {
    if (enclosed_->holds(one.cell)) flows.push_back({one.cell, one.share, 0});
  }
  flows.insert(flows.end(), through_walls_.begin(), through_walls_.end());
  const std::vector<EnclosedWater::Flow> sums = enclosed_->sums_over_pieces(comm, flows);
  auto sum = sums.begin();
  for (Inflow& one : inflow_) {
    if (!enclosed_->holds(one.cell)) continue;
    one.share *= sum->brought > 0 ? std::clamp(sum->leaving / sum->brought, 0.0, 1.0) : 0;
    if (one.out_of_wall != nullptr) one.path = std::copysign(one.share, one.out_of_wall->path);
    ++sum;
  }
}

bool Pressure::stands_on_floor(const FreeSurface& surface, const Openings::Gain& gain) {
  if (!surface.upright()) return false;
  std::size_t at = gain.cell;
  for (LocalId c = gain.c; c > 0; --c) {
    --at;
    if (!surface.is_wet(at)) return surface.is_solid(at);
  }
  return true;
}

// The divergence of a wet cell beside air, or of one that a solid cuts, less the inflow that it has room for. The
// divergence counts the cell as if it were full, and water that flew towards a solid was stopped a cell in front of it:
// a fixed ball of 2.4 spacings got up to 2.4 times the impulse of one that moves into the same water. What the weight
// alone brings in a step is not left out, so that water at rest keeps its pressure. Nor is it in the top cells of open
// water, whose divergence tells how their level changes. What an obstacle's cell takes in meets the obstacle itself.
Pressure::Filling Pressure::without_filling(const FreeSurface& surface, const Step& step, std::size_t at, Real flow) {
  const bool cut = surface.is_cut(at), of_obstacle = cut && !surface.cuts()->floats(at);
  const Real slow = -(of_obstacle ? by_weight_at_rest : by_weight) * step.g_dt2 / surface.grid().size()[2];
  if (flow >= slow || (surface.is_top(at) && !cut)) return {flow, 0};
  const Real room = surface.open(at) * (full_enough - surface.fill(at));
  return {std::min(flow + room, slow), of_obstacle ? std::min(room / (slow - flow), 1.0) : 0};
}

// A top cell returns to its volume only as far as there is water above it that could fill it, and cells at any other
// surface do so only if they hold too much: nothing pulls there. A cut cell that holds hardly anything does not return
// either: it may be that no particle fits into a wedge between a slope and the neighbouring cells. Nor does a gap,
// which a single particle overfills: when a body had closed it, the particle left it at 17 m/s. Water without a surface
// keeps its volume as a whole.
Real Pressure::returned(const FreeSurface& surface, const Step& step, LocalId k, LocalId r, LocalId c) const {
  const ProjectionGrid& grid = surface.grid();
  const std::size_t at = grid.index(k, r, c);
  Real less = surface.fill(at) - 1;
  if (enclosed_->holds(at) || surface.is_solid(at) || (less < 0 && may_swell(surface, k, r, c))) return 0;
  if (surface.is_cut(at) && (surface.fill(at) < submerged_fill || surface.cuts()->is_gap(at))) return 0;
  Real fraction = step.return_fraction;
  if (surface.upright()) {
    if (surface.is_top(at)) {
      const Real above = std::max(surface.fill(at + 1), 0.0), height = surface.water().height_of(above);
      fraction *= std::clamp(2 * height, 0.0, 1.0);
      if (less < 0) less = std::min(less + (above - height), 0.0);  // its own particles extend up into that cell
    }
  } else {
    const ParticlesToGrid::Means m = surface.water().means(at);
    Real displacement = 0;
    for (std::size_t a = 0; a < 3; ++a) displacement += std::pow(m.u[a] * grid.per_length()[a], 2);
    fraction = m.n > 0 ? std::min(std::sqrt(displacement) / m.n / return_time, 1.0) : 0;
  }
  return fraction * (surface.is_cut(at) ? cut_return : 1) * surface.open(at) * less;
}

// Whether there is air beside the cell or below it, or without gravity anywhere around it.
bool Pressure::may_swell(const FreeSurface& surface, LocalId k, LocalId r, LocalId c) const {
  const ProjectionGrid& grid = surface.grid();
  const std::size_t at = grid.index(k, r, c);
  const auto& weight = multigrid_.finest().link;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t step = grid.step(a);
    if (weight[a][at] > 0 && !surface.is_wet(at - step)) return true;
    if ((a < 2 || !surface.upright()) && weight[a][at + step] > 0 && !surface.is_wet(at + step)) return true;
  }
  return false;
}

// Links between two wet cells, 1/m²; those to dry cells are part of the Dirichlet diagonal.
void Pressure::drop_air_links(const FreeSurface& surface, LocalId k, LocalId r) {
  const ProjectionGrid& grid = surface.grid();
  auto& link = multigrid_.finest().link;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto b = static_cast<Eigen::Index>(a);
    const Real stiffness = 1 / (grid.size()[b] * grid.size()[b]);
    for (LocalId c = 0; c < grid.columns(k, r); ++c) {
      const std::size_t at = grid.index(k, r, c);
      link[a][at] *= surface.is_wet(at) && surface.is_wet(at - grid.step(a)) ? stiffness : 0;
    }
  }
}

// Divergence of the displacements of the faces, as if the cell were full of water: faces count as far as they are open,
// and nothing passes a wall. A moving solid displaces the rest of a face. `moved`: whether there may be one.
Real Pressure::divergence(const FreeSurface& surface, std::size_t at, bool moved) const {
  const ProjectionGrid& grid = surface.grid();
  const auto& weight = multigrid_.finest().link;
  const CutCells* cuts = surface.cuts();
  Real sum = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t above = at + grid.step(a);
    const Real low = weight[a][at] > 0 ? surface.face(a, at) : 0;
    const Real high = weight[a][above] > 0 ? surface.face(a, above) : 0;
    sum += (high * surface.water().displacement(a, above) - low * surface.water().displacement(a, at)) /
           grid.size()[static_cast<Eigen::Index>(a)];
    if (moved) {
      sum += (cuts->closed(a, at, true) * cuts->moved(a, above) - cuts->closed(a, at, false) * cuts->moved(a, at)) /
             grid.size()[static_cast<Eigen::Index>(a)];
    }
  }
  return sum;
}

// In water that stands on the floor or on a solid: the hydrostatic phi below the surface of the column, as if solids
// were water.
void Pressure::set_hydrostatic_guess(const FreeSurface& surface, Real g_dt2, LocalId k, LocalId r) {
  const ProjectionGrid& grid = surface.grid();
  const Real step = g_dt2 * grid.size()[2];
  const std::size_t floor = grid.index(k, r, 0), ceiling = floor + static_cast<std::size_t>(grid.columns(k, r));
  if (!surface.upright()) return;
  bool stands = true;  // on the floor, or on the drains in it
  for (std::size_t begin = floor; begin < ceiling;) {
    std::size_t end = begin;
    while (end < ceiling && (surface.is_wet(end) || surface.is_solid(end))) ++end;
    if (end > begin && (stands || surface.is_solid(begin))) guess_below(surface, step, begin, end);
    stands = stands && end == begin && surface.is_drained(begin);
    begin = end + 1;
  }
}

// In the cells of a column from `begin` to `end`; `step`: from cell to cell.
void Pressure::guess_below(const FreeSurface& surface, Real step, std::size_t begin, std::size_t end) {
  const bool top = surface.is_top(end - 1);
  std::size_t highest = end - 1;  // of the water
  while (highest > begin && surface.is_solid(highest)) --highest;
  if (!top && !enclosed_->holds(highest)) return;
  Real phi = -step * (top ? surface.above_middle(end - 1) : 0.5);
  for (std::size_t at = end; at-- > begin; phi -= step) multigrid_.finest().phi[at] = phi;
}

}  // namespace trevi
