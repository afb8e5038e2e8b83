#include "base/simd.hpp"

#include <hwy/targets.h>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace trevi {

std::int64_t supported_instruction_sets() {
  const std::int64_t sets = hwy::SupportedTargets() & HWY_TARGETS;
  hwy::GetChosenTarget().Update(sets);  // Highway 1.0 forgets here which sets are ruled out
  return sets;
}

void restrict_instruction_sets(std::int64_t allowed) { hwy::DisableTargets(~allowed); }

std::string instruction_set_name() {
  const std::int64_t sets = supported_instruction_sets();
  return hwy::TargetName(sets & -sets);
}

bool has_fused_multiply_add() {
  const std::string name = instruction_set_name();
  return name.find("SSE") == std::string::npos && name != "EMU128" && name != "SCALAR";
}

std::vector<std::string> instruction_set_names() {
  std::vector<std::string> names;
  for (std::int64_t rest = supported_instruction_sets(); rest != 0; rest &= rest - 1) {
    names.emplace_back(hwy::TargetName(rest & -rest));
  }
  return names;
}

bool use_instruction_set(const std::string& name) {
  for (std::int64_t rest = supported_instruction_sets(); rest != 0; rest &= rest - 1) {
    if (name != hwy::TargetName(rest & -rest)) continue;
    restrict_instruction_sets(rest);
    return true;
  }
  return false;
}

void flush_denormals() {
#if defined(__SSE__)
  _mm_setcsr(_mm_getcsr() | 0x8040);  // flush to zero, denormals are zero
#elif defined(__aarch64__)
  std::uint64_t fpcr = 0;
  asm volatile("mrs %0, fpcr" : "=r"(fpcr));
  asm volatile("msr fpcr, %0" : : "r"(fpcr | (1ULL << 24)));
#endif
}

}  // namespace trevi
