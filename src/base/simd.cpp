#include "trevi/base/simd.hpp"

#include <hwy/targets.h>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace trevi {

std::int64_t supported_instruction_sets() { return hwy::SupportedTargets() & HWY_TARGETS; }

void restrict_instruction_sets(std::int64_t allowed) { hwy::DisableTargets(~allowed); }

std::string instruction_set_name() {
  const std::int64_t sets = supported_instruction_sets();
  return hwy::TargetName(sets & -sets);
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
