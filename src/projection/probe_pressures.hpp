// The pressure of the cells at the positions of probes, interpolated linearly between the centres of cells along each
// axis. Where a neighbouring cell is dry or solid, only the wet ones count; along the vertical their pressure is
// extrapolated hydrostatically from their centre. Not collective.
#pragma once

#include "boundary/pressure_probes.hpp"
#include "projection/pressure.hpp"

namespace trevi {

/// `g_dt2`: g dt², m. To be called once per substep, after the solve.
void probe_pressures(const FreeSurface& surface, const Pressure& pressure, Real g_dt2, PressureProbes& probes);

}  // namespace trevi
