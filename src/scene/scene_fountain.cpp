#include "scene/scene_fountain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "fluid/forcings/music_kind.hpp"
#include "scene/scene_place.hpp"
#include "scene/scene_plane.hpp"

namespace trevi {
namespace {

/// m/s; far above any real jet.
constexpr Real highest_speed = 1e4;

void check_music(Section& section, const Scene& scene, const MusicSettings& music) {
  if (!section.fine("music")) return;
  const bool known = kind_of_music(music.source).has_value();
  if (!section.check("music", known, "unknown kind of music; give a file ending in " + endings_of_music())) return;
  const MusicKind kind = music.kind;
  const auto only_for = [&](const char* key, bool right, const std::string& words) {
    section.check(key, right || !section.given(key), "is for " + words + "; leave it out");
  };
  only_for("follow", kind == MusicKind::sound || kind == MusicKind::live, "sound only, as a score has its pitches");
  only_for("track", kind == MusicKind::midi, "MIDI files only");
  only_for("channel", kind == MusicKind::midi, "MIDI files only");
  only_for("rate", kind == MusicKind::live, "raw PCM on standard input only (music = \"-\")");
  section.check("channel", music.channel <= 16, "must be from 1 to 16");
  section.check("rate", music.rate <= 1000000, "must be at most 1000000 Hz");
  section.check("speed", section.given("speed_range") || music.speed_range.second > 0,
                "must be positive where music sets the speed; give speed_range");
  const auto same_input = [&](const PumpSettings& other) {
    section.check(
        "rate",
        kind != MusicKind::live || !other.music || other.music->source != "-" || other.music->rate == music.rate,
        "must be the same for all fountains that follow standard input; there is only one");
  };
  std::for_each(scene.fountains.begin(), scene.fountains.end(), same_input);
  std::for_each(scene.inlets.begin(), scene.inlets.end(), same_input);
}

void read_music(Section& section, const Scene& scene, PumpSettings& fountain) {
  MusicSettings music;
  const bool given =
      section.text({"music",
                    "the music: a score (.txt), MIDI (.mid) or sound file (.wav .flac .ogg) relative to the "
                    "scene's folder, or \"-\" for raw PCM on standard input; the pump is off where it is silent"},
                   music.source);
  Real range[2] = {fountain.speed / 2, fountain.speed};
  if (section.numbers({"speed_range",
                       "the speeds [low, high] in m/s of the lowest and highest note, or of silence and "
                       "the loudest sound; default half the speed and the speed"},
                      range)) {
    section.check("speed_range", range[0] >= 0 && range[0] < range[1] && range[1] <= highest_speed,
                  fmt::format("must increase within 0 to {}; give [low, high]", highest_speed));
  }
  music.speed_range = {range[0], range[1]};
  section.choice<SpeedMapping>({"mapping",
                                "what grows evenly with the note or the loudness: linear is the speed, energy "
                                "its square and with it the height of the jet"},
                               music.mapping, {{"linear", SpeedMapping::linear}, {"energy", SpeedMapping::energy}});
  music.kind = kind_of_music(music.source).value_or(MusicKind::score);
  resolve(music);
  Follow follow = music.follow;
  if (section.choice<Follow>(
          {"follow", "what of a sound sets the speed; default loudness; pitch is for a single voice"}, follow,
          {{"loudness", Follow::loudness}, {"pitch", Follow::pitch}}))
    music.follow = follow;
  section.integer({"track", "the track of a MIDI file, from 1; default all"}, music.track, 1);
  section.integer({"channel", "the channel of a MIDI file, 1 to 16; default all but 10, the drums"}, music.channel, 1);
  section.integer({"rate", "the rate of raw PCM on standard input in Hz (16 bits, little-endian, mono)"}, music.rate,
                  1000);
  if (given && music.source != "-") music.source = beside_scene(scene.path, music.source);
  if (given || !section.fine("music")) check_music(section, scene, music);
  for (const char* key : {"mapping", "follow", "track", "channel", "rate"}) {
    section.check(key, section.given("music") || !section.given(key), "there is no music to use it for; add music");
  }
  if (given) fountain.music = music;
}

}  // namespace

void read_jet(Section& section, const Scene& scene, PumpSettings& pump) {
  section.direction({"direction", "the direction of the jet [x, y, z], of any length"}, pump.direction);
  check_along_plane(section, scene, "direction", pump.direction);
  const Interval speeds{.low = 0, .high = highest_speed};
  section.number({"speed", "the speed of the jet in m/s"}, pump.speed, speeds);
  section.number({"jitter", "the largest random addition to speed in m/s"}, pump.jitter, speeds);
  read_music(section, scene, pump);
}

void read_times(Section& section, PumpSettings& pump) {
  section.number({"start", "the time the pump starts in seconds"}, pump.start, at_least(0));
  section.number({"stop", "the time the pump stops in seconds"}, pump.stop);
  if (section.fine("start")) {
    section.check("stop", pump.stop > pump.start,
                  fmt::format("must be later than start, {} s; give the time the pump stops", pump.start));
  }
}

std::string beside_scene(const std::string& scene_path, const std::string& path) {
  return (std::filesystem::path(scene_path).parent_path() / path).string();
}

void read_fountain(Section& section, Scene& scene, bool box_known) {
  FountainSettings fountain;
  section.numbers({"center", "the middle [x, y] of the fountain on the floor in metres", true}, fountain.center);
  if (scene.fluid.dimensions == 2) fountain.center[1] = 0;
  if (box_known && section.fine("center")) {
    const Eigen::Map<const Eigen::Vector2d> center(fountain.center);
    const auto low = scene.domain.min.head<2>(), high = scene.domain.max.head<2>();
    section.check("center", (center - low).minCoeff() >= 0 && (high - center).minCoeff() >= 0,
                  fmt::format("the fountain is outside the floor, x {} to {} and y {} to {}; move it inside", low.x(),
                              high.x(), low.y(), high.y()));
  }
  section.number({"diameter", "the diameter of the cylinder in metres"}, fountain.diameter, above(0));
  section.number({"height", "the height of the cylinder above the floor in metres"}, fountain.height, above(0));
  read_jet(section, scene, fountain);
  read_times(section, fountain);
  section.reject_unknown();
  scene.fountains.push_back(fountain);
  SceneTable::add(scene, "fountain", section.line());
}

}  // namespace trevi
