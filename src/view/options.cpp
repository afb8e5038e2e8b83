#include "view/options.hpp"

#include <CLI/CLI.hpp>

#include "trevi/error.hpp"
#include "view/status.hpp"

namespace trevi {

namespace {

constexpr const char* summary =
    "Looks at a run: trevi-view DIR plays what a run has written or is writing,\n"
    "trevi-view SCENE.toml [-np N] [arguments of trevi] starts a run and shows it live,\n"
    "trevi-view --listen HOST:PORT DIR waits for the one that writes into DIR, started with trevi ... --view "
    "HOST:PORT.";

constexpr const char* notes =
    "Only particles that can be seen are drawn: not those whose cell (two spacings; live: the kernel radius) and all "
    "26\n"
    "around it hold water. What is left is thinned to --budget: every 2nd, 4th, ... by a hash of the id, the same "
    "ones\n"
    "in each frame.\n"
    "Without a screen: xvfb-run -a trevi-view ...\n";

template <std::size_t N>
std::map<std::string, int> numbered(const std::array<const char*, N>& names) {
  std::map<std::string, int> numbers;
  for (std::size_t k = 0; k < N; ++k) numbers[names[k]] = static_cast<int>(k);
  return numbers;
}

std::map<std::string, int> viewer_colours() {
  std::map<std::string, int> numbers;
  for (const ColourEntry& entry : colour_list) {
    if (entry.in_viewer) numbers[entry.name] = static_cast<int>(entry.colour);
  }
  return numbers;
}

// -np is the usual way to give mpirun the number of ranks; CLI11 allows one letter after a single dash.
std::vector<std::string> words_of(int argc, const char* const* argv) {
  std::vector<std::string> words;
  for (int k = argc - 1; k > 0; --k) words.emplace_back(std::string(argv[k]) == "-np" ? "--np" : argv[k]);
  return words;
}

struct Raw {
  int style = 0, colour = static_cast<int>(Colour::rainbow);
  std::vector<int> size;
  std::vector<double> camera;
};

void add_looks(CLI::App& app, ViewOptions& options, Raw& raw) {
  app.add_option("--style", raw.style, "points, spheres or fluid")
      ->transform(CLI::CheckedTransformer(numbered(style_names)));
  app.add_option("--colour", raw.colour, "rainbow, speed, density or rank; the scene's own without it")
      ->transform(CLI::CheckedTransformer(viewer_colours()));
  app.add_option("--size", raw.size, "width and height in pixels (1280 720)")
      ->expected(2)
      ->check(CLI::Range(64, 16384));
  app.add_option("--camera", raw.camera, "degrees around, degrees above, zoom (30 20 1)")->expected(3);
  app.add_option("--budget", options.budget, "particles to draw at most, about (a quarter of the pixels)")
      ->check(CLI::PositiveNumber);
  app.add_flag("--all", options.all, "of a directory, draw what cannot be seen, too, without a budget");
}

void add_playing(CLI::App& app, ViewOptions& options) {
  app.add_option("--speed", options.speed, "simulated seconds a second")->check(CLI::PositiveNumber);
  app.add_flag("--loop", options.loop, "begin again at the end");
  app.add_flag("--paused", options.paused, "begin paused");
  app.add_option("--at", options.at, "step to show first");
  app.add_option("--scene", options.scene, "scene of a directory that does not tell (box, music)");
  app.add_flag("--mute", options.mute, "no music");
}

void add_unattended(CLI::App& app, ViewOptions& options) {
  app.add_option("--screenshot", options.screenshot, "write this PNG of the last frame, or of --at, and end");
  app.add_option("--frames", options.frames, "write a PNG of each frame into this directory, and end");
  app.add_option("--benchmark", options.benchmark, "turn the camera for so many seconds, print pictures a second, end")
      ->check(CLI::PositiveNumber);
}

}  // namespace

ViewOptions parse_view_options(int argc, const char* const* argv) {
  ViewOptions options;
  Raw raw;
  CLI::App app(summary, "trevi-view");
  app.footer("Keys when playing:\n" + key_help(false) + "\nKeys on a live run, where they differ:\n" + key_help(true) +
             "\n" + notes);
  app.add_option("target", options.target, "directory of a run, particles.pvd, particles.hdf.series, or scene (.toml)");
  app.add_option("--listen", options.listen, "HOST:PORT, or PORT on 127.0.0.1, that the run of a directory calls");
  app.add_option("-n,--np", options.ranks, "ranks of the run to start")->check(CLI::PositiveNumber);
  add_looks(app, options, raw);
  add_playing(app, options);
  add_unattended(app, options);
  app.allow_extras();
  try {
    app.parse(words_of(argc, argv));
  } catch (const CLI::CallForHelp&) {
    options.help = app.help();
    return options;
  } catch (const CLI::ParseError& error) {
    throw InputError(std::string(error.what()) + "; trevi-view --help lists all options");
  }
  options.run_arguments = app.remaining();
  options.style = static_cast<Style>(raw.style);
  options.colour = static_cast<Colour>(raw.colour);
  options.colour_given = app.count("--colour") > 0;
  if (!raw.size.empty()) options.width = raw.size[0], options.height = raw.size[1];
  if (!raw.camera.empty()) options.camera = {raw.camera[0], raw.camera[1], raw.camera[2]};
  if (options.budget == 0) options.budget = std::int64_t{options.width} * options.height / 4;
  if (options.target.empty() && !options.listen.empty() && std::getenv("TREVI_VIEW_KEY") == nullptr)
    throw InputError(
        "--listen: give the folder of the run, too (--listen HOST:PORT DIR), whose key keeps strangers out");
  if (options.target.empty() && options.listen.empty())
    throw InputError("give a directory, a scene, or --listen HOST:PORT DIR; trevi-view --help tells more");
  if (!options.run_arguments.empty() && !options.target.ends_with(".toml"))
    throw InputError(options.run_arguments.front() + ": unknown; trevi-view --help lists all options");
  return options;
}

}  // namespace trevi
