// trevi-view: a viewer for runs. What each part does is described in the headers beside this file.
#include <fmt/format.h>
#include <sys/resource.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "base/memory.hpp"
#include "io/run_directory/files.hpp"
#include "trevi/error.hpp"
#include "view/live_source.hpp"
#include "view/playback.hpp"
#include "view/window.hpp"

namespace trevi {

namespace {

constexpr int lowest_priority = 19;
constexpr auto nap = std::chrono::milliseconds(10);

bool unattended(const ViewOptions& options) {
  return !options.screenshot.empty() || !options.frames.empty() || options.benchmark;
}

void print_benchmark(Window& window, const ViewOptions& options, const FrameSource& source) {
  const double fps = window.benchmark(*options.benchmark);
  const auto style = static_cast<std::size_t>(options.style);
  fmt::print("{:.1f} pictures a second: {} of {} particles drawn as {}, {} x {}\n", fps, source.frame()->shown.size(),
             source.frame()->particles, style_names[style], options.width, options.height);
}

std::string frame_path(const ViewOptions& options, std::int64_t step) {
  return options.frames + "/frame_" + step_digits(step) + ".png";
}

/// Problems with music must not prevent anybody from viewing.
Pcm music_if_possible(const std::optional<Scene>& scene) {
  try {
    if (scene) return music_of(*scene);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "trevi-view: no music: %s\n", error.what());
  }
  return {};
}

std::size_t index_at(const FrameList& list, std::optional<std::int64_t> step, std::size_t otherwise) {
  if (!step) return otherwise;
  std::size_t index = 0;
  while (index + 1 < list.entries().size() && list.entries()[index].step < *step) ++index;
  return index;
}

ExitCode play_unattended(const ViewOptions& options, Playback& playback, Window& window, std::size_t index) {
  if (!options.frames.empty()) {
    std::filesystem::create_directories(options.frames);
    for (std::size_t k = 0; k < playback.count(); ++k) {
      playback.show(k);
      window.save(frame_path(options, playback.frame()->step));
    }
  }
  playback.show(index);
  if (!options.screenshot.empty()) window.save(options.screenshot);
  if (options.benchmark) print_benchmark(window, options, playback);
  return ExitCode::done;
}

ExitCode play(ViewOptions options) {
  FrameList list(options.target);
  const auto scene = find_scene(list.directory(), options.scene);
  // Its other colours are in the frames' rgb, or can be replaced by the id.
  if (!options.colour_given && scene && scene->colour == Colour::speed) options.colour = Colour::speed;
  const ViewedScene viewed = describe_run(list, scene);
  const std::size_t last = list.entries().size() - 1;
  const std::size_t index = index_at(list, options.at, unattended(options) ? last : 0);
  Playback playback(std::move(list), viewed,
                    {options.speed, options.loop, options.paused, options.budget, options.all});
  Window window(playback, options);
  if (unattended(options)) return play_unattended(options, playback, window, index);
  playback.show(index);
  MusicPlayer music(options.mute ? Pcm() : music_if_possible(scene));
  window.run(music);
  return ExitCode::done;
}

/// Waits until the run has called, or has ended without doing so.
void wait_for_call(LiveSource& source) {
  while (!source.frame() && !source.exit_code()) {
    source.advance(0);
    std::this_thread::sleep_for(nap);
  }
}

ExitCode watch_unattended(const ViewOptions& options, LiveSource& source, Window& window) {
  wait_for_call(source);
  if (options.benchmark && source.frame()) print_benchmark(window, options, source);
  if (!options.frames.empty()) std::filesystem::create_directories(options.frames);
  std::int64_t saved = -1;
  const auto save_new = [&] {
    const auto frame = source.frame();
    if (options.frames.empty() || !frame || frame->step == saved) return;
    window.save(frame_path(options, frame->step));
    saved = frame->step;
  };
  const auto reached = [&] { return options.at && source.frame() && source.frame()->step >= *options.at; };
  while (!source.at_end() && !reached() && !options.benchmark) {
    save_new();
    if (!source.advance(0)) std::this_thread::sleep_for(nap);
  }
  save_new();
  if (!options.screenshot.empty() && source.frame()) window.save(options.screenshot);
  return ExitCode::done;
}

std::optional<Scene> scene_of_run(const ViewOptions& options) {
  try {
    if (!options.target.empty()) return parse_scene(options.target, read_text(options.target), {});
  } catch (const Error&) {  // the run itself will report what is wrong
  }
  return std::nullopt;
}

// Drawing in software takes a core, which the run needs more. To be called after the run was started, because a child
// inherits the priority.
void lower_priority() { std::ignore = setpriority(PRIO_PROCESS, 0, lowest_priority); }

ExitCode watch(const ViewOptions& options) {
  const LiveOptions live{options.budget, options.paused};
  const bool starts = options.listen.empty();
  const auto source = starts ? start_run({options.target, options.ranks, options.run_arguments}, live)
                             : listen_for_run(options.listen, options.target, live);
  lower_priority();
  if (starts) wait_for_call(*source);
  // A run that could not even start has reported why.
  if (!source->frame() && source->exit_code()) return static_cast<ExitCode>(*source->exit_code());
  Window window(*source, options);
  if (unattended(options)) return watch_unattended(options, *source, window);
  MusicPlayer music(options.mute ? Pcm() : music_if_possible(scene_of_run(options)));
  window.run(music);
  if (starts && !source->at_end()) std::fprintf(stderr, "trevi-view: the run goes on\n");
  return ExitCode::done;
}

ExitCode view(int argc, const char* const* argv) {
  const ViewOptions options = parse_view_options(argc, argv);
  if (!options.help.empty()) {
    std::fputs(options.help.c_str(), stdout);
    return ExitCode::done;
  }
  if (!options.live()) return play(options);
  require_screen();  // before a run is started
  return watch(options);
}

}  // namespace

}  // namespace trevi

int main(int argc, char** argv) {
  try {
    return static_cast<int>(trevi::view(argc, argv));
  } catch (const trevi::Error& error) {
    std::fprintf(stderr, "trevi-view: %s\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "trevi-view: %s\n", trevi::text_of(error).c_str());
    return static_cast<int>(trevi::ExitCode::run_failed);
  }
}
