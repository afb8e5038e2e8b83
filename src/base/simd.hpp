// Which instruction set the pair loops use. One binary contains them for SSE2/SSE4, AVX2, AVX-512 (NEON on Arm) and
// selects one at run time. Sums have the same structure on all of them (fluid/pairs/pair_traversal-inl.hpp), so that
// all sets with a fused multiply-add give the same bits. All ranks use the same instruction set, because the others
// agree only to rounding.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace trevi {

/// Bit mask of the instruction sets that both this machine and this binary support; a higher set is a lower bit.
std::int64_t supported_instruction_sets();

/// Keeps only the sets in `allowed`. To be called before the first pair loop, with the same mask on all ranks.
void restrict_instruction_sets(std::int64_t allowed);

/// Name of the instruction set in use, "AVX-512" for instance.
std::string instruction_set_name();

/// Whether it has a fused multiply-add. All sets that do give the same bits; the others agree to rounding.
bool has_fused_multiply_add();

/// Names of all that are supported and not ruled out, the one in use first.
std::vector<std::string> instruction_set_names();

/// Whether there is a set of that name, or of Highway's own name ("AVX3").
bool is_instruction_set(const std::string& name);

/// Rules out all sets higher than the named one; returns false, and changes nothing, if there is none of that name.
bool use_instruction_set(const std::string& name);

/// Denormal numbers become zero in this thread: they slow the high powers of s_corr by a factor of ten and add nothing.
void flush_denormals();

/// Denormal numbers are treated as zero in this thread during the life of the object; then the previous setting is
/// restored. For a thread that is not the solver's alone.
class Denormals {
 public:
  explicit Denormals(bool are_zero = true);
  ~Denormals();
  Denormals(const Denormals&) = delete;
  Denormals& operator=(const Denormals&) = delete;

 private:
  std::uint64_t before_;
};

}  // namespace trevi
