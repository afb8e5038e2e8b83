#include "trevi/scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "base/simd.hpp"
#include "base/threads.hpp"
#include "scene/obstacle_files.hpp"
#include "scene/scene_body.hpp"
#include "scene/scene_frames.hpp"
#include "scene/scene_gauge.hpp"
#include "scene/scene_inlet.hpp"
#include "scene/scene_overrides.hpp"
#include "scene/scene_periodic.hpp"
#include "scene/scene_physics.hpp"
#include "scene/scene_reader.hpp"

namespace trevi {
namespace {

/// Seconds of "1h30m", "90m" or "45s": each unit at most once, the larger first.
std::optional<Real> seconds_of(std::string_view text) {
  constexpr std::string_view units = "hms";
  constexpr Real seconds[] = {3600, 60, 1};
  Real total = 0;
  std::size_t next = 0;
  while (!text.empty()) {
    Real amount = 0;
    const auto [end, problem] =
        std::from_chars(text.data(), text.data() + text.size(), amount, std::chars_format::fixed);
    if (problem != std::errc() || end == text.data() + text.size()) return std::nullopt;
    const std::size_t unit = units.find(*end, next);
    if (unit == std::string_view::npos) return std::nullopt;
    total += amount * seconds[unit];
    next = unit + 1;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()) + 1);
  }
  return total;
}

void read_wall_limit(Section& run, Scene& scene) {
  const Key key{"wall_limit", "the wall-clock time to stop at: \"3h\", \"90m\", \"45s\", \"1h30m\" or seconds"};
  if (const toml::node* node = run.find(key, "text or number")) {
    const auto* text = node->as_string();
    const auto seconds = text ? seconds_of(text->get()) : node->is_number() ? node->value<Real>() : std::nullopt;
    if (seconds && std::isfinite(*seconds) && *seconds > 0) {
      scene.wall_limit = *seconds;
    } else {
      run.refuse(key, seconds ? "must be positive and finite" : "must be a time");
    }
  }
}

void read_instruction_set(Section& run, Scene& scene) {
  const Key key{"instruction_set",
                "the instruction set of all loops as run.json names it, \"SSE4\", \"AVX2\" or \"AVX-512\" for "
                "instance, or leave it out for the best"};
  std::string name;
  if (!run.text(key, name)) return;
  if (!is_instruction_set(name)) {
    run.refuse(key, fmt::format("must be one that every machine of this run has ({})",
                                fmt::join(instruction_set_names(), ", ")));
  } else {
    scene.instruction_set = name;
  }
}

void read_threads(Section& run, Scene& scene) {
  int threads = 0;
  if (!run.integer({"threads", "the number of threads of each rank; default OMP_NUM_THREADS, or as the cores allow"},
                   threads, 1))
    return;
  run.check("threads", threads <= max_threads,
            fmt::format("must be at most {}; leave it out for as many as there are cores", max_threads));
  scene.threads = threads;
}

void read_run(Section run, Scene& scene) {
  read_wall_limit(run, scene);
  read_threads(run, scene);
  read_instruction_set(run, scene);
  run.reject_unknown();
}

void read_colour(Section colour, Scene& scene) {
  if (colour.present()) {
    std::vector<std::pair<const char*, Colour>> choices;
    for (const ColourEntry& entry : colour_list) {
      if (entry.in_scenes) choices.emplace_back(entry.name, entry.colour);
    }
    Colour by = Colour::speed;
    colour.choice<Colour>({"by", "what a particle's colour shows", true}, by, choices);
    scene.colour = by;
  }
  colour.reject_unknown();
}

// A row for every step unless the table specifies otherwise.
std::optional<Schedule> read_rows(Section rows) {
  if (!rows.present()) return std::nullopt;
  Schedule schedule = read_schedule(rows);
  if (!rows.given("every") && !rows.given("every_steps")) schedule.every_steps = 1;
  rows.reject_unknown();
  return schedule;
}

void read_output(Section output, Scene& scene, bool has_colour) {
  OutputSettings& settings = scene.output;
  output.text({"directory", "the folder for all outputs, relative to the working directory"}, settings.directory);
  settings.vtu = read_frames(output.child("vtu"), has_colour);
  settings.vtkhdf = read_frames(output.child("vtkhdf"), has_colour);
  read_frame_sets(output, scene, has_colour);
  if (Section checkpoint = output.child("checkpoint"); checkpoint.present()) {
    settings.checkpoint.emplace().schedule = read_schedule(checkpoint);
    checkpoint.integer({"keep", "the number of checkpoints to keep"}, settings.checkpoint->keep, 1);
    checkpoint.reject_unknown();
  }
  settings.series = read_rows(output.child("series"));
  settings.gauges = read_rows(output.child("gauges"));
  output.reject_unknown();
}

void read_random(Section random, Scene& scene) {
  random.integer({"seed", "the seed of all random numbers"}, scene.seed, 0);
  random.reject_unknown();
}

void read_tables(const toml::table& document, Findings& findings, Scene& scene) {
  Section root(document, findings);
  read_physics(root, scene);
  Section colour = root.child("colour");
  const bool has_colour = colour.present();
  read_colour(std::move(colour), scene);
  read_output(root.child("output"), scene, has_colour);
  check_gauges(root, scene);
  read_random(root.child("random"), scene);
  read_run(root.child("run"), scene);
  root.reject_unknown();
}

}  // namespace

std::string Scene::directory() const { return output.directory.empty() ? "out/" + name : output.directory; }

std::int64_t Scene::steps() const { return dt > 0 ? std::llround(end / dt) : 0; }

Scene parse_scene(const std::string& path, const std::string& text, const std::vector<std::string>& overrides) {
  Findings findings(path);
  Scene scene;
  scene.path = path;
  scene.name = std::filesystem::path(path).stem().string();
  scene.text = text;
  scene.overrides = std::ssize(overrides);
  for (const std::string& assignment : overrides) {
    if (!scene.text.empty() && scene.text.back() != '\n') scene.text += '\n';
    scene.text += "# --set " + assignment + '\n';
  }
  const toml::table document = read_document(path, text, overrides, findings);
  read_tables(document, findings, scene);
  findings.throw_if_any();
  return scene;
}

Scene read_scene(MPI_Comm comm, const std::string& path, const std::vector<std::string>& overrides) {
  Scene scene = parse_scene(path, read_file_everywhere(comm, path), overrides);
  read_obstacle_files(comm, scene);
  check_no_images(scene);
  check_body_places(scene);
  if (!scene.inlets.empty() || !scene.drains.empty() || !scene.gauges.empty()) {
    const FreePlaces places(scene);
    check_openings(scene, places);
    check_drains(scene, places);
    check_gauge_places(scene, places);
  }
  return scene;
}

std::string scene_reference() {
  // The reader itself lists the keys that it asks for, so the reference cannot drift from it. All tables are present,
  // but empty; it does not matter here what is missing from them.
  const std::string every_table =
      "particles = [{type = 'block'}, {type = 'file'}]\nfountain = [{}]\ninlet = [{}]\ndrain = [{}]\n"
      "obstacle = [{type = 'basin'}, {type = 'box'}, {type = 'cylinder'}, {type = 'torus'}, {type = 'mesh', motion = "
      "{}}]\n"
      "gauge = [{type = 'pressure'}]\nwavemaker = [{}]\ndamping = [{}]\n"
      "body = [{type = 'basin', mooring = {}}, {type = 'box'}, {type = 'cylinder'}, {type = 'torus'}, {type = "
      "'mesh'}]\n"
      "[domain]\n[fluid]\n[time]\n[gravity]\n[density]\n[walls]\n[tensile]\n[vorticity]\n[viscosity]\n[colour]\n"
      "[output.vtu]\n[output.vtkhdf]\n[[output.frames]]\n[output.checkpoint]\n[output.series]\n[output.gauges]\n["
      "random]\n[run]\n";
  Findings findings("reference");
  Scene scene;
  read_tables(read_document("reference", every_table, {}, findings), findings, scene);
  return fmt::format("{}\n", fmt::join(findings.descriptions(), "\n"));
}

}  // namespace trevi
