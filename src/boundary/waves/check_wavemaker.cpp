#include "boundary/waves/check_wavemaker.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "boundary/waves/elementary.hpp"
#include "boundary/waves/paddle_motion.hpp"

namespace trevi {

namespace {

bool is_positive(Real x) { return x > 0 && std::isfinite(x); }

std::optional<WrongMember> in_numbers(const WavemakerSettings& w) {
  constexpr int max_components = 4096;
  if (!is_positive(w.height)) return WrongMember{"height", "must be positive; give the height of the waves in metres"};
  if (!is_positive(w.depth))
    return WrongMember{"depth", "must be positive; give the depth of the still water in metres"};
  if (!is_positive(w.gravity))
    return WrongMember{"wave", "needs gravity along -z alone; add [gravity], or give it acceleration = [0, 0, -9.8]"};
  if (w.wave != WaveKind::solitary && !is_positive(w.period))
    return WrongMember{"period", "must be positive; give the period of the waves in seconds"};
  constexpr Real longest = 1e4;  // rounding spoils the theory of waves some ten thousand times longer still
  if (const Real unit = std::sqrt(w.depth / w.gravity); w.wave != WaveKind::solitary && w.period > longest * unit)
    return WrongMember{"period", fmt::format("is {:.4g} s, a tide for water of {:.4g} m; give at most {:.4g} s",
                                             w.period, w.depth, longest * unit)};
  if (!(w.ramp >= 0 && std::isfinite(w.ramp))) return WrongMember{"ramp", "must not be negative"};
  if (!(w.peak_enhancement >= 1 && std::isfinite(w.peak_enhancement)))
    return WrongMember{"peak_enhancement", "must be at least 1; that of the North Sea is 3.3"};
  if (w.components < 1 || w.components > max_components)
    return WrongMember{"components", fmt::format("must be from 1 to {}", max_components)};
  if (w.absorb && w.wave == WaveKind::solitary) return WrongMember{"absorb", "is not for a solitary wave"};
  const Vec3 d = w.direction.cwiseAbs();
  if (!(d == Vec3::UnitX() || d == Vec3::UnitY()))
    return WrongMember{"direction", "must be along x or y, to either side; give [1, 0, 0] for instance"};
  return std::nullopt;
}

// McCowan's limit for a solitary wave, Miche's for regular waves.
std::optional<WrongMember> in_height(const WavemakerSettings& w) {
  constexpr Real mccowan = 0.78, miche = 0.142;
  Real highest = mccowan * w.depth;
  if (w.wave == WaveKind::regular) {
    const Real k = wave_number(2 * std::numbers::pi / w.period, w.depth, w.gravity);
    highest = miche * 2 * std::numbers::pi / k * elementary::tanh(k * w.depth);
  }
  if (w.height < highest) return std::nullopt;
  return WrongMember{
      "height", fmt::format("is {:.4g} m, and waves break from {:.4g} m on at this depth{}; make it less", w.height,
                            highest, w.wave == WaveKind::regular ? " and period" : "")};
}

}  // namespace

std::optional<WrongMember> what_is_wrong(const WavemakerSettings& w, const Box& domain) {
  if (auto wrong = in_numbers(w)) return wrong;
  if (auto wrong = in_height(w)) return wrong;
  if (!(w.depth <= domain.max.z() - domain.min.z()))
    return WrongMember{
        "depth", fmt::format("is {:.4g} m, and the box is {:.4g} m high; make it less, or the box higher", w.depth,
                             domain.max.z() - domain.min.z())};
  const Eigen::Index axis = w.direction.x() != 0 ? 0 : 1;
  const Real reach = paddle_reach(w), low = domain.min[axis], high = domain.max[axis];
  if (!(w.position - reach > low && w.position + reach < high))
    return WrongMember{
        "position", fmt::format("is {:.4g} m, and the paddle goes {:.4g} m to either side of it, out of the box from "
                                "{:.4g} to {:.4g} m; move it, or make the box longer behind it",
                                w.position, reach, low, high)};
  if (w.kind == PaddleKind::flap && reach > w.depth)
    return WrongMember{"height", fmt::format("needs a flap that leans by more than 45 degrees, {:.4g} m at the surface "
                                             "of {:.4g} m of water; make it less, or take a piston",
                                             reach, w.depth)};
  return std::nullopt;
}

}  // namespace trevi
