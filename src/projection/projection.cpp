#include "projection/projection.hpp"

#include <cmath>

#include "projection/cell_shifts.hpp"
#include "projection/probe_pressures.hpp"
#include "projection/record_beside.hpp"

namespace trevi {

namespace {

ActiveRows::Least min_particles(const ProjectionGrid& grid, Real spacing, bool solids) {
  const Real particles = grid.size().prod() / (spacing * spacing * spacing);
  const auto number = [&](Real fill) { return static_cast<LocalId>(std::ceil(fill * particles)); };
  return {number(projection::deep_fill), number(solids ? projection::deep_fill : projection::surface_fill)};
}

// Particles of a row in its cells from `column` on are not displaced.
template <class T>
void leave_from(const CellOrder& order, LocalId k, LocalId r, LocalId column, std::span<Vec4<T>> out) {
  const LocalId columns = order.grid().columns();
  const LocalId first = order.start(k, r * columns + column), end = order.start(k, (r + 1) * columns);
  std::fill_n(out.begin() + (first - order.low_ghosts()), end - first, Vec4<T>{});
}

}  // namespace

Projection::Projection(MPI_Comm comm, const CellGrid& grid, const Box& box, const Model& model, Obstacles* obstacles,
                       const std::shared_ptr<Scratch>& scratch)
    : comm_(comm),
      model_(model),
      box_(box),
      grid_(grid, box, scratch),
      rows_(comm, min_particles(grid_, model.spacing, obstacles != nullptr)),
      cuts_(obstacles != nullptr ? std::make_unique<CutCells>(*obstacles) : nullptr),
      particles_to_grid_(grid_, model.spacing),
      surface_({grid_, rows_, particles_to_grid_, cuts_.get(), model.gravity > 0}),
      pressure_(comm, grid_.repeats(), scratch),
      shares_(surface_, model.spacing),
      grid_to_particles_(surface_, particles_to_grid_.free_spreads(), model.spacing, model.h),
      shift_filter_(surface_),
      obstacles_(obstacles),
      coupling_(obstacles != nullptr && obstacles->floating() != nullptr
                    ? std::make_unique<BodyCoupling>(comm, *cuts_, *obstacles, model.h)
                    : nullptr) {}

void Projection::solve(const CellOrder& order, Halo& halo, const Pressure::Step& step) {
  pressure_.assemble(surface_, halo, step);
  surface_.give_back_fill();
  particles_to_grid_.give_back_displacements();
  if (!coupling_) {
    pressure_.begin(halo);
    return pressure_.finish(surface_, halo);
  }
  const RecordForces forces(surface_, pressure_, *obstacles_, model_.spacing, step.g_dt2);
  const RecordBeside beside({surface_, pressure_, grid_to_particles_, forces, particles_to_grid_.frame()}, *obstacles_,
                            model_.spacing, step.g_dt2);
  coupling_->solve(pressure_, halo, {surface_, forces, beside, order, model_.spacing});
}

void Projection::find(const CellOrder& order, Halo& halo, Real dt, const Motion& motion) {
  const ScopedEvent timed(event_);
  const Real g_dt2 = model_.gravity * dt * dt, time = dt * std::sqrt(model_.gravity / model_.h);
  measure_rows(order, halo);
  if (openings_ != nullptr) openings_->measure(grid_, cuts_.get());
  particles_to_grid_.gather(order, halo, motion, g_dt2, cuts_.get());
  surface_.classify(halo);
  particles_to_grid_.find_empty_faces(cuts_.get(), [&](std::size_t at) { return surface_.is_wet(at); });
  particles_to_grid_.give_back_volumes();
  grid_to_particles_.prepare(halo, {g_dt2, time});
  particles_to_grid_.keep_means();
  solve(order, halo, {g_dt2, std::min(1.0, time / projection::return_time), rows_.depth()});
  grid_to_particles_.find_rises(pressure_, halo);
  grid_to_particles_.find_mean_rises(pressure_);
  if (openings_ != nullptr) {
    const Real particles = grid_.size().prod() / (model_.spacing * model_.spacing * model_.spacing);
    for (const Pressure::Inflow& one : pressure_.inflow()) {
      openings_->add_work(-particles * pressure_.phi(one.cell) * one.share, dt);
      if (one.out_of_wall != nullptr) openings_->come_through(grid_, *one.out_of_wall, one.path);
    }
  }
  if (probes_ != nullptr) probe_pressures(surface_, pressure_, g_dt2, *probes_);
}

template <class T>
void Projection::displacements(const CellOrder& order, Real dt, const Motion& motion, std::span<Vec4<T>> out) {
  const ScopedEvent timed(event_);
  shares_.find(pressure_);
  for_each_row_with<GridToParticles::Damping>(own_rows(), [&](GridToParticles::Damping& damping, LocalId k, LocalId r) {
    grid_to_particles_.find_damping(damping, k, r);
    particles_to_grid_.for_each_cell(order, k, r, [&](LocalId c, const CellParticles& cell) {
      CellDisplacement by = grid_to_particles_.displacement_of(pressure_, damping, k, r, c);
      shares_.add_to(by, grid_.index(k, r, c));
      displace_cell(particles_to_grid_.frame(), motion, cell, by, &out[cell.begin]);
    });
    leave_from<T>(order, k, r, grid_.columns(k, r), out);  // particles above these are in flight
  });
  if (obstacles_ != nullptr) record_forces<T>(order, model_.gravity * dt * dt, motion, out);
  particles_to_grid_.keep_fits();
  grid_to_particles_.give_back();
  shares_.give_back();
  surface_.keep_wet();
  pressure_.give_back();
}

template <class T>
void Projection::record_forces(const CellOrder& order, Real g_dt2, const Motion& motion, std::span<Vec4<T>> out) const {
  const LocalId rows = grid_.rows();
  const RecordForces record(surface_, pressure_, *obstacles_, model_.spacing, g_dt2);
  const RecordBeside beside({surface_, pressure_, grid_to_particles_, record, particles_to_grid_.frame()}, *obstacles_,
                            model_.spacing, g_dt2);
  for_each_part(order.planes() * rows, [&](LocalId row) {
    const LocalId k = row / rows + 1, r = row % rows, columns = order.grid().columns();
    const auto begin = static_cast<std::size_t>(order.start(k, r * columns) - order.low_ghosts());
    const auto end = static_cast<std::size_t>(order.start(k, (r + 1) * columns) - order.low_ghosts());
    record.of_row<T>(k, r, out.subspan(begin, end - begin), motion.x.subspan(begin, end - begin));
    beside.of_row(k, r, order, motion);
  });
  if (coupling_) coupling_->record_films();
  record.of_gauges(box_);
}

void Projection::measure_rows(const CellOrder& order, Halo& halo) {
  constexpr LocalId step = 4;
  rows_.measure(order, halo);
  const LocalId highest =
      grid_.repeats()[2] ? grid_.count(2) : std::min((rows_.max_columns() + step - 1) / step * step, grid_.count(2));
  grid_.resize(order.window(), highest);
  // Ghost cells included: beyond the ends of the box nothing is received.
  for_each_row(grid_.rows_and_ghosts_of({0, order.planes() + 2}), [&](LocalId k, LocalId r) {
    grid_.set_columns(k, r, cuts_ || grid_.repeats()[2] ? grid_.columns() : rows_.columns(k, r));
  });
  grid_.store_rows(order);
  surface_.borrow();
  particles_to_grid_.borrow();
  if (cuts_) cuts_->measure(comm_, grid_, box_, particles_to_grid_.frame());
}

void Projection::give_back() {
  particles_to_grid_.give_back();
  surface_.give_back();
}

template <class T>
void Projection::filter_shifts(const CellOrder& order, Halo& halo, const Swept<T>& swept, std::span<Vec4<T>> out) {
  const ScopedEvent timed(event_);
  shift_filter_.for_each_plane(halo, {order, swept.shifts, swept.densities, swept.near}, [&](Range planes) {
    for_each_row_of_few<ShiftFilter::Smooth>(grid_, planes, [&](ShiftFilter::Smooth& smooth, LocalId k, LocalId r) {
      if (!swept.near.has(k, r)) return leave_from<T>(order, k, r, 0, out);
      shift_filter_.find_smooth(smooth, k, r);
      particles_to_grid_.for_each_cell(order, k, r, [&](LocalId c, const CellParticles& cell) {
        remove_smooth(particles_to_grid_.frame(), swept, cell, smooth.at(c), &out[cell.begin]);
      });
      leave_from<T>(order, k, r, grid_.columns(k, r), out);  // particles above these are in flight
    });
  });
}

template <class T>
void Projection::carry_velocities(const CellOrder& order, const Swept<T>& swept, Real dt,
                                  std::span<Vec3> velocity) const {
  const ScopedEvent timed(event_);
  const ByAxis& per_length = particles_to_grid_.frame().per_length;
  for_each_row(own_rows(), [&](LocalId k, LocalId r) {
    if (!swept.near.has(k, r)) return;
    particles_to_grid_.for_each_cell(order, k, r, [&](LocalId c, const CellParticles& cell) {
      std::array<ByAxis, 3> slope = particles_to_grid_.fits().cell<AffineMap>(k, r, c).b;
      for (ByAxis& of_axis : slope) {
        for (std::size_t b = 0; b < 3; ++b) of_axis[b] *= per_length[b] / dt;
      }
      carry_cell(swept.shifts, cell, slope, swept.act, velocity);
    });
  });
}

std::size_t Projection::bytes() const {
  return rows_.bytes() + grid_.bytes() + (openings_ != nullptr ? openings_->bytes() : 0) +
         (cuts_ ? cuts_->bytes() : 0) + particles_to_grid_.bytes() + pressure_.bytes() + grid_to_particles_.bytes();
}

template void Projection::displacements(const CellOrder&, Real, const Motion&, std::span<Vec4<float>>);
template void Projection::displacements(const CellOrder&, Real, const Motion&, std::span<Vec4<double>>);
template void Projection::filter_shifts(const CellOrder&, Halo&, const Swept<float>&, std::span<Vec4<float>>);
template void Projection::filter_shifts(const CellOrder&, Halo&, const Swept<double>&, std::span<Vec4<double>>);
template void Projection::carry_velocities(const CellOrder&, const Swept<float>&, Real, std::span<Vec3>) const;
template void Projection::carry_velocities(const CellOrder&, const Swept<double>&, Real, std::span<Vec3>) const;

}  // namespace trevi
