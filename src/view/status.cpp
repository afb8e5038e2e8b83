#include "view/status.hpp"

#include <fmt/format.h>

#include <cmath>

namespace trevi {

namespace {

std::string fountain_text(const std::vector<FountainState>& fountains) {
  for (const FountainState& fountain : fountains) {  // the first that is on represents all
    if (!(fountain.speed > 0)) continue;
    const std::string note = std::isnan(fountain.note) ? "" : note_name(fountain.note) + " ";
    return fmt::format("  fountain {}{:.1f} m/s", note, fountain.speed);
  }
  return fountains.empty() ? "" : "  fountain off";
}

}  // namespace

std::string note_name(double number) {
  static constexpr std::array<const char*, 12> names = {"C",  "C#", "D",  "D#", "E",  "F",
                                                        "F#", "G",  "G#", "A",  "A#", "B"};
  const auto rounded = static_cast<int>(std::lround(number));
  return fmt::format("{}{}", names[static_cast<std::size_t>(((rounded % 12) + 12) % 12)],
                     static_cast<int>(std::floor(rounded / 12.0)) - 1);
}

std::string with_commas(std::int64_t number) {
  std::string text = fmt::format("{}", number);
  for (auto k = static_cast<std::ptrdiff_t>(text.size()) - 3; k > (number < 0 ? 1 : 0); k -= 3)
    text.insert(static_cast<std::size_t>(k), ",");
  return text;
}

std::string status_of(const ViewedFrame& frame) {
  return fmt::format("t = {:.3f} s  step {}  {} particles ({} drawn){}", frame.time, frame.step,
                     with_commas(frame.particles), with_commas(static_cast<std::int64_t>(frame.shown.size())),
                     fountain_text(frame.fountains));
}

std::string key_help(bool live) {
  const std::string common =
      "c           colour: rainbow, speed, density, rank\n"
      "p           points, spheres, fluid\n"
      "r           reset the view\n"
      "s           save a PNG\n"
      "h           these lines\n"
      "mouse       left: rotate, middle or shift: pan, right or wheel: zoom\n";
  if (live) {
    return "space       pause or resume the run\n"
           "n, right    exactly one step\n" +
           common +
           "q           stop the run after a checkpoint\n"
           "escape      close the window; the run goes on\n";
  }
  return "space       pause or resume\n"
         "right left  one frame on or back (n: on)\n"
         "home end    first, last frame\n"
         "+ -         faster, slower\n"
         "l           loop\n" +
         common + "q, escape   close the window\n";
}

}  // namespace trevi
