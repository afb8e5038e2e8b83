// The cores that this process may use, and the share of each process when several on one machine use them. Not
// collective. A core is identified by its lowest processor, as numbered by Linux, so the same core has the same name in
// all processes of the machine; the processors of a core (hyperthreads) count as one.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace trevi {

/// Cores in the affinity mask of this thread, ascending. If OpenMP has bound this thread to one of its places
/// (OMP_PROC_BIND), the cores of all places.
std::vector<int> usable_cores();

/// The processors of the affinity mask of this thread, ascending.
std::vector<int> usable_processors();

/// Ascending numbers as Linux lists them: "0-3,8".
std::string list_text(std::span<const int> numbers);

/// The number of memory domains (NUMA nodes) that processors are in, according to `folder` (/sys/devices/system/node);
/// 1 if it has no information.
int memory_domains_of(std::span<const int> processors, const std::string& folder);

/// Processor time, in units of processors, that the control groups of this process allow it, as in a container;
/// infinite if there is no such limit.
double allowed_processors();

/// `users_of_cores`: for each core of this process, the number of processes that may use it, including this one.
/// Returns an equal share of each of these cores, rounded down, but at most an equal share of `allowed` for each of
/// `processes`. At least 1.
int threads_for_cores(std::span<const int> users_of_cores, double allowed, int processes);

/// The cores of processors, according to `folder` (/sys/devices/system/cpu); an unknown processor counts as a core.
std::vector<int> cores_of(std::span<const int> processors, const std::string& folder);

/// The smallest limit of the control group `path` below `folder` (/sys/fs/cgroup) and the groups that contain it.
double group_limit(const std::string& folder, std::string path);

}  // namespace trevi
