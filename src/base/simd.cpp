#include "base/simd.hpp"

#include <hwy/targets.h>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace trevi {

namespace {

// Highway calls AVX-512 "AVX3".
std::string name_of(std::int64_t set) {
  std::string name = hwy::TargetName(set);
  if (name.starts_with("AVX3")) name.replace(0, 4, "AVX-512");
  return name;
}

// That set and all lower ones, 0 if there is none of that name.
std::int64_t sets_from(const std::string& name) {
  for (std::int64_t rest = supported_instruction_sets(); rest != 0; rest &= rest - 1) {
    if (name == name_of(rest & -rest) || name == hwy::TargetName(rest & -rest)) return rest;
  }
  return 0;
}

// The register that controls, among other things, the treatment of denormal numbers, and its bits for zero.
#if defined(__SSE__)
constexpr std::uint64_t denormals_are_zero = 0x8040;  // results, and operands
std::uint64_t floating_point_control() { return _mm_getcsr(); }
void set_floating_point_control(std::uint64_t value) { _mm_setcsr(static_cast<unsigned>(value)); }
#elif defined(__aarch64__)
constexpr std::uint64_t denormals_are_zero = 1ULL << 24;
std::uint64_t floating_point_control() {
  std::uint64_t fpcr = 0;
  asm volatile("mrs %0, fpcr" : "=r"(fpcr));
  return fpcr;
}
void set_floating_point_control(std::uint64_t value) { asm volatile("msr fpcr, %0" : : "r"(value)); }
#else
constexpr std::uint64_t denormals_are_zero = 0;
std::uint64_t floating_point_control() { return 0; }
void set_floating_point_control(std::uint64_t) {}
#endif

}  // namespace

std::int64_t supported_instruction_sets() {
  const std::int64_t sets = hwy::SupportedTargets() & HWY_TARGETS;
  hwy::GetChosenTarget().Update(sets);  // Highway 1.0 forgets here which sets are ruled out
  return sets;
}

void restrict_instruction_sets(std::int64_t allowed) { hwy::DisableTargets(~allowed); }

std::string instruction_set_name() {
  const std::int64_t sets = supported_instruction_sets();
  return name_of(sets & -sets);
}

bool has_fused_multiply_add() {
  const std::string name = instruction_set_name();
  return name.find("SSE") == std::string::npos && name != "EMU128" && name != "SCALAR";
}

std::vector<std::string> instruction_set_names() {
  std::vector<std::string> names;
  for (std::int64_t rest = supported_instruction_sets(); rest != 0; rest &= rest - 1) {
    names.push_back(name_of(rest & -rest));
  }
  return names;
}

bool is_instruction_set(const std::string& name) { return sets_from(name) != 0; }

bool use_instruction_set(const std::string& name) {
  const std::int64_t sets = sets_from(name);
  if (sets != 0) restrict_instruction_sets(sets);
  return sets != 0;
}

void flush_denormals() { set_floating_point_control(floating_point_control() | denormals_are_zero); }

Denormals::Denormals(bool are_zero) : before_(floating_point_control()) {
  set_floating_point_control(are_zero ? before_ | denormals_are_zero : before_ & ~denormals_are_zero);
}

Denormals::~Denormals() { set_floating_point_control(before_); }

}  // namespace trevi
