#include "trevi/forcing.hpp"

#include <Random123/philox.h>

namespace trevi {

Real uniform(std::uint64_t seed, GlobalId id, const StepInfo& info, int stream) {
  using Generator = r123::Philox4x32;
  const auto low = [](std::uint64_t v) { return static_cast<std::uint32_t>(v); };
  const auto high = [](std::uint64_t v) { return static_cast<std::uint32_t>(v >> 32); };
  const auto particle = static_cast<std::uint64_t>(id), step = static_cast<std::uint64_t>(info.step);
  // 12 bits for the stream and 20 for the substep, of which a step has at most a million. From step 2^32 on the upper
  // bits of the step number would overlap with those of the substep.
  const auto stream_and_substep =
      static_cast<std::uint32_t>(static_cast<unsigned>(info.substep) << 12U | (static_cast<unsigned>(stream) & 0xfffU));
  const Generator::ctr_type counter = {
      {low(particle), high(particle), low(step), stream_and_substep | high(step) << 24U}};
  const Generator::key_type key = {{low(seed), high(seed)}};
  const Generator::ctr_type random = Generator()(counter, key);
  const std::uint64_t bits = (static_cast<std::uint64_t>(random[0]) << 32U | random[1]) >> 11U;
  return static_cast<Real>(bits) * 0x1p-53;
}

}  // namespace trevi
