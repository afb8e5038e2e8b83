// Memory that is there before it is asked for. Linux gives what it does not have and kills who uses it, so what a file
// or a scene asks for is compared with what is free. Not collective.
#pragma once

#include <cstdint>
#include <exception>
#include <string>

namespace trevi {

/// Bytes that this process could still take: of the machine, of its control groups, of its own limit (ulimit -v).
double free_memory();

/// Free bytes in the control group `path` below `folder` (/sys/fs/cgroup) and the groups that it is in, what the kernel
/// would give back of them (files in memory) counted as free; infinite without a limit.
double free_in_group(const std::string& folder, std::string path);

/// "4.2 GB"
std::string bytes_text(double bytes);

/// InputError "<what> need 9.6 GB, and 4.2 GB of memory are free here; <remedy>" when they are not there.
void require_memory(double bytes, const std::string& what, const std::string& remedy);

/// Has the C library take large arrays from the system and give them back when they are freed, as it does by default:
/// `libsuperlu_dist`, which PETSc brings, turns that off for the whole process when it is loaded, so that all arrays
/// lie in one heap that only grows. For programs that Trevi is the owner of, at their start; nothing happens where the
/// C library is not glibc.
void give_freed_memory_back();

/// An error for the user: what() as a rule; of an allocation that failed, how much this process has and what is free.
std::string text_of(const std::exception& error);

}  // namespace trevi
