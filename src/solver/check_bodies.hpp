// Whether bodies that move freely can be as the settings have them. Not collective.
#pragma once

#include <string>

#include "trevi/settings.hpp"

namespace trevi {

/// What is wrong with body k and the remedy; empty where it is fine. Its shape has been checked, its mesh read.
std::string why_no_body(const Settings& settings, std::size_t k);

}  // namespace trevi
