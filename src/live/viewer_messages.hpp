// The messages between a run and its viewer: the run sends its scene, frames and its end; the viewer sends its
// requests, always all of them, so that a request that is received twice or late does no harm. In transmission a
// message is a JSON text, and a frame is followed by its particles as bytes (native floats: both ends run on machines
// of the same kind). Plain data and its text; no communication. SI units.
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
  std::int64_t single_steps = 0;  ///< requested since the viewer has found the run
  std::int64_t seen = -1;         ///< step of the last frame that arrived; the next is sent only then
  std::int64_t budget = 0;        ///< approximate limit of the number of particles in a frame
  bool density = false;
  bool stop = false;
};

/// "HOST:PORT", or "PORT" on this machine (127.0.0.1), as "tcp://HOST:PORT". InputError naming `option`.
std::string viewer_endpoint(const std::string& option, const std::string& address);

std::string text_of(const ViewedScene& scene);
std::string text_of(const ViewedFrame& frame);  ///< without the particles
std::string text_of(const ViewerWishes& wishes);
std::string text_of_end(const std::string& reason);

/// Each returns nothing for a text of another kind, of another protocol version, or damaged.
std::optional<ViewedScene> read_scene(const std::string& text);
std::optional<ViewedFrame> read_frame(const std::string& text, const std::string& particles);
std::optional<ViewerWishes> read_wishes(const std::string& text);
std::optional<std::string> read_end(const std::string& text);

}  // namespace trevi
