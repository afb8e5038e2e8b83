#include <fmt/format.h>

#include "io/tables/gauge_readings.hpp"
#include "solver.hpp"

namespace trevi::python {

namespace {

class Recorder : public Observer {
 public:
  Recorder(MPI_Comm comm, const Settings& settings, const Schedule& schedule, std::shared_ptr<Record> record)
      : schedule_(schedule), readings_(comm, settings), record_(std::move(record)) {
    obstacles_ = settings.obstacles.size();
    wants_forces_ = has_solids(settings);
    has_gauges_ = !settings.gauges.empty();
  }
  bool due(const Clock& clock) const override { return schedule_.due(clock); }
  bool wants_diagnostics() const override { return true; }
  bool wants_forces() const override { return wants_forces_; }
  bool wants_pressures() const override { return readings_.wants_pressures(); }

  void observe(const Frame& frame) override {
    note_series(frame);
    if (obstacles_ > 0) note_forces(frame);
    if (!frame.bodies.empty()) note_bodies(frame);
    if (has_gauges_) note_gauges(frame);
  }

 private:
  static void note_time(const Frame& frame, Table& table) {
    table["step"].push_back(static_cast<Real>(frame.clock.step));
    table["time"].push_back(frame.clock.time());
  }
  static void note(const std::string& name, const Vec3& value, Table& table) {
    for (Eigen::Index a = 0; a < 3; ++a) table[fmt::format(fmt::runtime(name), "xyz"[a])].push_back(value[a]);
  }

  static void note_force(const BodyForce& force, std::size_t number, Table& table) {
    note(fmt::format("force_{{}}_{}", number), force.force, table);
    note(fmt::format("torque_{{}}_{}", number), force.torque, table);
  }

  void note_series(const Frame& frame) {
    Table& table = record_->series;
    const Diagnostics& row = *frame.diagnostics;
    note_time(frame, table);
    table["dt"].push_back(frame.clock.dt);
    const std::pair<const char*, Real> values[] = {{"substeps", frame.clock.substeps},
                                                   {"particles", static_cast<Real>(row.particles)},
                                                   {"iterations", static_cast<Real>(row.iterations)},
                                                   {"density_mean", row.density_mean},
                                                   {"density_max", row.density_max},
                                                   {"density_interior", row.density_interior},
                                                   {"compression_mean", row.compression_mean},
                                                   {"compression_max", row.compression_max},
                                                   {"compression_rms", row.compression_rms},
                                                   {"kinetic_energy", row.kinetic_energy},
                                                   {"potential_energy", row.potential_energy},
                                                   {"speed_max", row.speed_max},
                                                   {"top", row.top},
                                                   {"front", row.front},
                                                   {"front_q99", row.front_q99},
                                                   {"drift_max", row.drift_max},
                                                   {"imbalance", row.imbalance},
                                                   {"wall_seconds", row.wall_seconds}};
    for (const auto& [name, value] : values) table[name].push_back(value);
    note("momentum_{}", row.momentum, table);
    note("com_{}", row.com, table);
    table["supplied_energy"].push_back(frame.supplied_energy);
    for (std::size_t k = 0; k < frame.fountains.size(); ++k) {
      table[fmt::format("note_{}", k)].push_back(frame.fountains[k].note);
      table[fmt::format("speed_{}", k)].push_back(frame.fountains[k].speed);
    }
    if (frame.flow == nullptr) return;
    table["inflow"].push_back(static_cast<Real>(frame.flow->inflow));
    table["outflow"].push_back(static_cast<Real>(frame.flow->outflow));
    table["waiting"].push_back(static_cast<Real>(frame.flow->waiting));
  }

  void note_forces(const Frame& frame) {
    Table& table = record_->obstacles;
    note_time(frame, table);
    for (std::size_t k = 0; k < obstacles_; ++k) note_force(frame.forces[k], k, table);
    note("box_force_{}", frame.forces.back().force, table);
  }

  void note_bodies(const Frame& frame) {
    Table& table = record_->bodies;
    note_time(frame, table);
    for (std::size_t k = 0; k < frame.bodies.size(); ++k) {
      const BodyState& body = frame.bodies[k];
      note(fmt::format("{{}}_{}", k), body.position, table);
      for (std::size_t part = 0; part < 4; ++part)
        table[fmt::format("q{}_{}", "wxyz"[part], k)].push_back(body.orientation[part]);
      note(fmt::format("v{{}}_{}", k), body.velocity, table);
      note(fmt::format("w{{}}_{}", k), body.angular_velocity, table);
      note_force(frame.forces[obstacles_ + k], k, table);
    }
  }

  void note_gauges(const Frame& frame) {
    note_time(frame, record_->gauges);
    const std::vector<std::string> names = readings_.columns();
    const std::vector<Real> values = readings_.read(frame);
    for (std::size_t k = 0; k < names.size(); ++k) record_->gauges[names[k]].push_back(values[k]);
  }

  Schedule schedule_;
  GaugeReadings readings_;
  std::shared_ptr<Record> record_;
  std::size_t obstacles_ = 0;
  bool wants_forces_ = false, has_gauges_ = false;
};

}  // namespace

std::unique_ptr<Observer> make_recorder(MPI_Comm comm, const Settings& settings, const Schedule& schedule,
                                        std::shared_ptr<Record> record) {
  return std::make_unique<Recorder>(comm, settings, schedule, std::move(record));
}

}  // namespace trevi::python
