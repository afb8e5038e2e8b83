// The texts in the window: the status line, messages, the list of keys; and the window's title, a short status.
#pragma once

#include <string>

#include "view/frame_source.hpp"

namespace trevi {

/// Time, step, particles, note, pump speed.
std::string status_of(const ViewedFrame& frame);

/// A note by name, with the cents of a voice left out: "E4".
std::string note_name(double number);

/// "1,234,567": with commas between thousands.
std::string with_commas(std::int64_t number);

/// The keys and what they do, one per line.
std::string key_help(bool live);

}  // namespace trevi
