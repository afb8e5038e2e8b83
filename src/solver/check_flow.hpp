// Checks by make_solver() of the fountains, inlets, drains and output in the settings of a program. Not collective.
#pragma once

#include "trevi/settings.hpp"

namespace trevi {

/// Throw an InputError that names the member and its rule.
void check_flow(const Settings& all);
void check_output(const Settings& all);

/// Gives directions the length 1, and an inlet with a flow the corresponding speed; those of a scene keep their bits.
/// The settings must have passed check_flow().
void resolve_flow(Settings& all);

}  // namespace trevi
