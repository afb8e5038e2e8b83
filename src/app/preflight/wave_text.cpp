#include "app/preflight/wave_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "boundary/waves/paddle_motion.hpp"
#include "scene/scene_place.hpp"
#include "scene/scene_waves.hpp"

namespace trevi {

namespace {

// The waves of a wavemaker according to theory; for irregular ones the wave of the peak. Lengths in m.
struct Expected {
  Real k = 0, length = 0, celerity = 0, stroke = 0;
};

// From end to end, m. A second harmonic is small when the first is at its ends, so amplitudes do not add up.
Real stroke_of(WavemakerSettings w) {
  if (w.wave == WaveKind::irregular) return 2 * paddle_reach(w);
  constexpr int samples = 1000;
  w.ramp = 0;
  const PaddleMotion paddle(w);
  Real reach = 0;
  for (int n = 0; n < samples; ++n) reach = std::max(reach, std::abs(paddle.displacement(w.period * n / samples)));
  return 2 * reach;
}

Expected expected_of(const WavemakerSettings& w) {
  constexpr Real two_pi = 2 * std::numbers::pi;
  if (w.wave == WaveKind::solitary) {
    const SolitaryWave wave(w.height, w.depth, w.gravity);
    const Real length = two_pi / wave.kappa;  // 99.6 % of its volume
    return {wave.kappa, length, wave.celerity, wave.stroke()};
  }
  const Real k = wave_number(two_pi / w.period, w.depth, w.gravity);
  return {k, two_pi / k, two_pi / k / w.period, stroke_of(w)};
}

// The steepness from which on potential flow gives 2 % lower waves for a piston than Biésel's transfer function, which
// is for small motions (postprocess/results/waves.md, at kd = 1.57).
bool is_steep(Real height_over_length) {
  constexpr Real steep = 0.045;
  return height_over_length > steep;
}

std::string text_of(std::size_t n, const WavemakerSettings& w, Real spacing) {
  const Expected e = expected_of(w);
  const char* paddle = w.kind == PaddleKind::piston ? "piston" : "flap";
  const std::string resolved =
      fmt::format("{:.1f} spacings a length, {:.1f} a height", e.length / spacing, w.height / spacing);
  if (w.wave == WaveKind::solitary)
    return fmt::format(
        "waves {:<5} a solitary wave of {:.4g} m on {:.4g} m, {:.4g} m/s, {:.4g} m long; {}\n"
        "  {:<9} {:.4g} m in {:.4g} s from {:.4g} m\n",
        n, w.height, w.depth, e.celerity, e.length, resolved, paddle, e.stroke,
        SolitaryWave(w.height, w.depth, w.gravity).duration(), w.position);
  const bool irregular = w.wave == WaveKind::irregular;
  return fmt::format(
      "waves {:<5} {} = {:.4g} m, {} = {:.4g} s on {:.4g} m: k = {:.4g} 1/m, L = {:.4g} m, H/L = {:.3f}{}, {:.4g} m/s; "
      "{}\n"
      "  {:<9} {} of {:.4g} m about {:.4g} m, H/S = {:.4g}, ramp of {:.4g} s\n",
      n, irregular ? "H_m0" : "H", w.height, irregular ? "T_p" : "T", w.period, w.depth, e.k, e.length,
      w.height / e.length, is_steep(w.height / e.length) ? " (steep: lower than linear theory has them)" : "",
      e.celerity, resolved, paddle, irregular ? "strokes up" : "a stroke", e.stroke, w.position,
      biesel_transfer(w.kind, e.k * w.depth), w.ramp);
}

template <class Use>
void for_each_wavemaker(const Scene& scene, const Use& use) {
  for (std::size_t k = 0; k < scene.obstacles.size(); ++k)
    if (scene.obstacles[k].wavemaker) use(*scene.obstacles[k].wavemaker, SceneTable("obstacle", k).line_in(scene));
}

}  // namespace

std::string wave_text(const Scene& scene) {
  std::string text;
  std::size_t n = 0;
  for_each_wavemaker(scene, [&](const WavemakerSettings& w, int) { text += text_of(n++, w, scene.fluid.spacing); });
  for (std::size_t k = 0; k < scene.dampings.size(); ++k) {
    const DampingSettings zone = resolved(scene).dampings[k];
    const Vec3 d = zone.direction;
    text += fmt::format("damping {:<3} along {}{}, {:.4g} m long, up to {:.4g} 1/s\n", k, d.sum() > 0 ? "+" : "-",
                        d.x() != 0 ? "x" : "y", std::abs((zone.max - zone.min).dot(d)), zone.rate);
  }
  return text;
}

std::vector<std::string> wave_warnings(const Scene& scene) {
  constexpr Real min_length = 30, min_height = 4;                               // spacings
  constexpr Real highest_ursell = 8 * std::numbers::pi * std::numbers::pi / 3;  // Madsen 1971
  std::vector<std::string> warnings;
  for_each_wavemaker(scene, [&](const WavemakerSettings& w, int line) {
    const Real s = scene.fluid.spacing, length = expected_of(w).length;
    if (const auto depth = depth_of_water(scene); depth && std::abs(*depth - w.depth) > s)
      warnings.push_back(
          fmt::format("the waves of line {} are those of water {:.4g} m deep, and the blocks of [[particles]] are "
                      "{:.4g} m deep; leave depth out, or give that of the still water",
                      line, w.depth, *depth));
    if (length < min_length * s)
      warnings.push_back(
          fmt::format("the waves of line {} are {:.1f} spacings long, and die early with less than "
                      "{:.0f}; make them longer, or the spacing at most {:.4g} m",
                      line, length / s, min_length, length / min_length));
    const Real ursell = w.height * length * length / (w.depth * w.depth * w.depth);
    if (w.wave == WaveKind::regular && ursell > highest_ursell)
      warnings.push_back(
          fmt::format("the waves of line {} have H L²/d³ = {:.3g}, and from {:.3g} on Stokes' theory, by which the "
                      "paddle goes, has a second crest in each trough; make them lower or shorter, or the water deeper",
                      line, ursell, highest_ursell));
    if (w.height < min_height * s)
      warnings.push_back(
          fmt::format("the waves of line {} are {:.1f} spacings high, and noisy with less than {:.0f}; "
                      "make them higher, or the spacing at most {:.4g} m",
                      line, w.height / s, min_height, w.height / min_height));
  });
  return warnings;
}

}  // namespace trevi
