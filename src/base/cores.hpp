// The cores that this process may use, and what several processes of one machine get of them each. Not collective.
// A core is named by its lowest processor, as Linux numbers them, so the same core has the same name in all processes
// of the machine; the processors of a core (hyperthreads) count as one.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace trevi {

/// Those of the affinity mask of this thread, ascending. Where OpenMP has bound this thread to one of its places
/// (OMP_PROC_BIND), those of all places.
std::vector<int> usable_cores();

/// The processors of the affinity mask of this thread, ascending.
std::vector<int> usable_processors();

/// Ascending numbers as Linux lists them: "0-3,8".
std::string list_text(std::span<const int> numbers);

/// How many memory domains (NUMA nodes) processors are in, by what `folder` (/sys/devices/system/node) says; 1 where it
/// says nothing.
int memory_domains_of(std::span<const int> processors, const std::string& folder);

/// Processors' worth of time that the control groups of this process allow it, as a container has it; infinite where
/// there is no such limit.
double allowed_processors();

/// For each core of this process the number of processes that may use it, itself included: an equal share of each of
/// them, rounded down, and no more than an equal share of `allowed` for each of `processes`. At least 1.
int threads_for_cores(std::span<const int> users_of_cores, double allowed, int processes);

/// The cores of processors, by what `folder` (/sys/devices/system/cpu) says; a processor it does not know is a core.
std::vector<int> cores_of(std::span<const int> processors, const std::string& folder);

/// The least limit of the control group `path` below `folder` (/sys/fs/cgroup) and the groups that it is in.
double group_limit(const std::string& folder, std::string path);

}  // namespace trevi
