// The machines on which a run executes, for run.json. Collective.
#pragma once

#include <vector>

#include "base/energy.hpp"
#include "io/run_directory/run_report.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// The machines in the order of their ranks; on rank 0 alone. Machines whose ranks are not consecutive are listed
/// several times.
std::vector<HostReport> hosts_of(const Session& session);

/// Sum of the meters, one per machine; nan if one of them gives no value.
double joules_of_hosts(const Session& session, const EnergyMeter& meter);

}  // namespace trevi
