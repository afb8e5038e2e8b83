// What a run and its viewer say to each other: the run tells its scene, frames and its end; the viewer what it wishes,
// always all of it, so that a wish that is heard twice or late does no harm.
// On the wire a message is a text of JSON, a frame has its particles as bytes behind it (native floats: both ends run
// on machines of one kind). Plain data and its text; no communication. SI units.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "io/frames/viewed_frame.hpp"

namespace trevi {

/// Both ends must have the same.
inline constexpr int viewer_protocol = 1;

struct ViewerWishes {
  bool paused = false;
  std::int64_t single_steps = 0;  ///< asked for since the viewer has found the run
  std::int64_t seen = -1;         ///< step of the last frame that arrived; the next is sent only then
  std::int64_t budget = 0;        ///< particles a frame should have at most, about
  bool density = false;
  bool stop = false;
};

/// "HOST:PORT", or "PORT" on this machine (127.0.0.1), as "tcp://HOST:PORT". InputError naming `option`.
std::string viewer_endpoint(const std::string& option, const std::string& address);

std::string text_of(const ViewedScene& scene);
std::string text_of(const ViewedFrame& frame);  ///< without the particles
std::string text_of(const ViewerWishes& wishes);
std::string text_of_end(const std::string& reason);

/// Each gives nothing for a text that is of another kind, of another protocol, or damaged.
std::optional<ViewedScene> read_scene(const std::string& text);
std::optional<ViewedFrame> read_frame(const std::string& text, const std::string& particles);
std::optional<ViewerWishes> read_wishes(const std::string& text);
std::optional<std::string> read_end(const std::string& text);

}  // namespace trevi
