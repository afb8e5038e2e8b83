// What the pressure of the cells is at the places of probes: linear between the middles of cells along each axis. Where
// a cell beside is dry or solid, those that are wet count alone, along the vertical hydrostatic from their middle. Not
// collective.
#pragma once

#include "boundary/pressure_probes.hpp"
#include "projection/pressure.hpp"

namespace trevi {

/// `g_dt2`: g dt², m. To be called once a substep, after the solve.
void probe_pressures(const FreeSurface& surface, const Pressure& pressure, Real g_dt2, PressureProbes& probes);

}  // namespace trevi
