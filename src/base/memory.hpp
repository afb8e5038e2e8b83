// Checks whether memory is available before it is requested. Linux grants memory that it does not have and kills the
// process that uses it, so what a file or a scene requires is compared with what is free. Not collective.
#pragma once

#include <cstdint>
#include <exception>
#include <string>

namespace trevi {

/// Bytes that this process could still use: limited by the machine, its control groups and its own limit (ulimit -v).
double free_memory();

/// Free bytes in the control group `path` below `folder` (/sys/fs/cgroup) and the groups that contain it; what the
/// kernel would give back of them (files in memory) counts as free. Infinite without a limit.
double free_in_group(const std::string& folder, std::string path);

/// "4.2 GB"
std::string bytes_text(double bytes);

/// InputError "<what> need 9.6 GB, and 4.2 GB of memory are free here; <remedy>" if they are not available.
void require_memory(double bytes, const std::string& what, const std::string& remedy);

/// Makes the C library take large arrays from the system and return them when they are freed, as it does by default.
/// `libsuperlu_dist`, which PETSc loads, turns that off for the whole process, so that all arrays are in one heap that
/// only grows. For programs owned by Trevi, at their start; does nothing if the C library is not glibc.
void give_freed_memory_back();

/// An error message for the user: usually what(); for a failed allocation, how much this process has and what is free.
std::string text_of(const std::exception& error);

}  // namespace trevi
