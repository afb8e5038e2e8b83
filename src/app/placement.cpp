#include "app/placement.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "base/cores.hpp"

namespace trevi {

namespace {

// Texts that do not fit are truncated.
struct ProcessPlace {
  std::array<char, 64> host{};
  std::array<char, 188> processors{};
  int memory_domains = 1;
};

ProcessPlace own_place() {
  ProcessPlace place;
  gethostname(place.host.data(), place.host.size() - 1);
  const std::vector<int> processors = usable_processors();
  std::snprintf(place.processors.data(), place.processors.size(), "%s", list_text(processors).c_str());
  place.memory_domains = memory_domains_of(processors, "/sys/devices/system/node");
  return place;
}

}  // namespace

std::vector<HostReport> hosts_of(const Session& session) {
  const MPI_Comm comm = session.comm();
  const ProcessPlace mine = own_place();
  std::vector<ProcessPlace> all(rank_of(comm) == 0 ? static_cast<std::size_t>(size_of(comm)) : 0);
  MPI_Gather(&mine, sizeof(ProcessPlace), MPI_BYTE, all.data(), sizeof(ProcessPlace), MPI_BYTE, 0, comm);
  std::vector<HostReport> hosts;
  for (const ProcessPlace& place : all) {
    if (hosts.empty() || hosts.back().name != place.host.data()) hosts.push_back({place.host.data(), 0, 0, {}});
    HostReport& host = hosts.back();
    ++host.ranks;
    host.memory_domains = std::max(host.memory_domains, place.memory_domains);
    host.processors.emplace_back(place.processors.data());
  }
  return hosts;
}

double joules_of_hosts(const Session& session, const EnergyMeter& meter) {
  const MPI_Comm comm = session.comm();
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  double joules = rank_of(machine) == 0 ? meter.joules() : 0;
  MPI_Comm_free(&machine);
  MPI_Allreduce(MPI_IN_PLACE, &joules, 1, MPI_DOUBLE, MPI_SUM, comm);
  return joules;
}

}  // namespace trevi
