// Fountains, inlets, drains and output of a program's settings, as make_solver() looks at them. Not collective.
#pragma once

#include "trevi/settings.hpp"

namespace trevi {

/// InputError that names the member and its rule.
void check_flow(const Settings& all);
void check_output(const Settings& all);

/// Directions get the length 1, and an inlet with a flow the speed that it means; a scene's keep their bits. The
/// settings are those that check_flow() has found good.
void resolve_flow(Settings& all);

}  // namespace trevi
