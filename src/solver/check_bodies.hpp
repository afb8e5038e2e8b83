// Checks of the settings of freely moving bodies. Not collective.
#pragma once

#include <string>

#include "trevi/settings.hpp"

namespace trevi {

/// What is wrong with body k, and the remedy; empty if it is valid. Its shape must have been checked and its mesh read.
std::string why_no_body(const Settings& settings, std::size_t k);

}  // namespace trevi
