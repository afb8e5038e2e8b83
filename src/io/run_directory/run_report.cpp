#include "io/run_directory/run_report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/hash.hpp"
#include "io/run_directory/files.hpp"
#include "parallel/collective.hpp"

namespace trevi {

namespace {

using Json = nlohmann::ordered_json;

Json json_array(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Json phase_json(const PhaseReport& phase) {
  return Json{{"name", phase.name},
              {"seconds", {{"min", phase.seconds_min}, {"mean", phase.seconds_mean}, {"max", phase.seconds_max}}},
              {"calls", phase.calls},
              {"flops", phase.flops},
              {"bytes", phase.bytes}};
}

Json host_json(const HostReport& host) {
  return Json{{"name", host.name},
              {"ranks", host.ranks},
              {"memory_domains", host.memory_domains},
              {"processors", host.processors}};
}

Json inlet_json(const RunReport::Inlet& inlet) {
  return Json{{"asked", inlet.asked},
              {"made", inlet.made},
              {"covered", inlet.covered},
              {"blocked", inlet.blocked},
              {"dry", inlet.dry}};
}

// How the run ended, with which program, and which scene it was.
void add_origin(Json& json, const RunReport& report) {
  json["exit_reason"] = report.exit_reason;
  json["exit_code"] = report.exit_code;
  json["ranks"] = report.ranks;
  json["threads"] = report.threads;
  json["threads_min"] = report.threads_min;
  const RunReport::Versions& v = report.versions;
  json["versions"] = Json{{"trevi", v.trevi}, {"mpi", v.mpi}, {"petsc", v.petsc}, {"hdf5", v.hdf5}, {"vtk", v.vtk}};
  json["scene"] = report.scene;
  json["scene_hash"] = report.scene_hash;
  json["domain"] = Json{{"min", json_array(report.domain.min)}, {"max", json_array(report.domain.max)}};
  json["spacing"] = report.spacing;
  json["rest_density"] = report.rest_density;
  json["warnings"] = report.warnings;
}

Json report_json(const RunReport& report) {
  Json json;
  add_origin(json, report);
  json["instruction_set"] = report.instruction_set;
  json["precision"] = report.precision;
  json["first_step"] = report.first_step;
  json["last_step"] = report.last_step;
  json["steps"] = report.steps;
  json["particles"] = report.particles;
  json["simulated_seconds"] = report.simulated_seconds;
  json["wall_seconds"] = report.wall_seconds;
  json["steps_per_second"] = report.steps_per_second;
  json["particle_steps_per_second"] = report.particle_steps_per_second;
  json["nanoseconds_per_pair"] = report.nanoseconds_per_pair;
  json["energy_gain"] = report.energy_gain;
  json["motion_gain"] = report.motion_gain;
  json["compression_largest"] = report.compression_largest;
  json["crushed_step"] = report.crushed_step;
  json["inlets"] = Json::array();
  for (const RunReport::Inlet& inlet : report.inlets) json["inlets"].push_back(inlet_json(inlet));
  json["unconverged_solves"] = report.unconverged_solves;
  json["halo_bytes_per_step"] = report.halo_bytes_per_step;
  json["halo_messages_per_step"] = report.halo_messages_per_step;
  json["step_seconds"] = report.step_seconds;
  json["waiting_seconds"] = report.waiting_seconds;
  json["halo_wait_seconds"] = report.halo_wait_seconds;
  json["reduction_seconds"] = report.reduction_seconds;
  json["imbalance"] = Json{{"mean", report.imbalance_mean}, {"max", report.imbalance_max}};
  json["cut_moves"] = report.cut_moves;
  json["bytes_per_particle"] = report.bytes_per_particle;
  json["max_resident_bytes"] = report.max_resident_bytes;
  json["energy_joules"] = report.energy_joules;
  json["hosts"] = Json::array();
  for (const HostReport& host : report.hosts) json["hosts"].push_back(host_json(host));
  json["phases"] = Json::array();
  for (const PhaseReport& phase : report.phases) json["phases"].push_back(phase_json(phase));
  return json;
}

}  // namespace

std::string scene_hash(std::string_view text) { return fmt::format("{:016x}", fnv1a(text)); }

void write_run_report(MPI_Comm comm, const std::string& directory, const RunReport& report) {
  on_root(comm, [&] {
    // The version text of a library need not be UTF-8; a report is worth more than a faithful accent.
    const std::string text = report_json(report).dump(2, ' ', false, Json::error_handler_t::replace);
    replace_file(directory + "/run.json", text + "\n");
  });
}

}  // namespace trevi
