// On which machines a run is, for run.json. Collective.
#pragma once

#include <vector>

#include "base/energy.hpp"
#include "io/run_directory/run_report.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// The machines in the order of their ranks; on rank 0 alone. Machines whose ranks are not one after the other stand
/// there several times.
std::vector<HostReport> hosts_of(const Session& session);

/// Sum of what the meters tell, one of each machine; nan where one of them does not.
double joules_of_hosts(const Session& session, const EnergyMeter& meter);

}  // namespace trevi
