#include "solver/guard.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/threads.hpp"
#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr const char* unstable =
    "the run has become unstable; use a smaller dt, time.cfl, or a smaller density.relaxation";

std::string text_of(const Vec3& p) { return fmt::format("({}, {}, {})", p.x(), p.y(), p.z()); }

}  // namespace

Guard::Guard(MPI_Comm comm, const Particles& particles, std::function<RequestCounts()> requests)
    : comm_(comm), consensus_(comm), ask_(std::move(requests)), start_(consensus_.count(state_of(particles.id))) {}

void Guard::expect(const StepState& change) {
  start_.particles += change.particles;
  start_.ids += change.ids;
  start_.squares += change.squares;
}

void Guard::note(std::int64_t step, const std::string& failure) {
  if (failure_.empty()) failure_ = fmt::format("rank {}, step {}: {}", rank_of(comm_), step, failure);
}

void Guard::check(const Particles& particles, const Walls& walls, std::int64_t step) {
  const LocalId failed = first_index({0, particles.size()}, [&](std::size_t i) {
    return !walls.inside(particles.predicted[i]) || !particles.velocity[i].allFinite();  // a NaN is not inside
  });
  if (failed < particles.size()) note_particle(particles, static_cast<std::size_t>(failed), step);
}

void Guard::check(std::span<const BodyState> bodies, std::int64_t step) {
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const BodyState& body = bodies[k];
    const Real sum = body.position.sum() + body.momentum.sum() + body.angular_momentum.sum() + body.velocity.sum() +
                     body.angular_velocity.sum() + body.orientation[0];
    if (std::isfinite(sum)) continue;
    return note(step, fmt::format("body {} is at {} with velocity {}: not a number; use a smaller dt, and look at its "
                                  "mass, its mooring and what it touches",
                                  k, text_of(body.position), text_of(body.velocity)));
  }
}

void Guard::note_particle(const Particles& particles, std::size_t i, std::int64_t step) {
  const Vec3 &p = particles.predicted[i], &v = particles.velocity[i];
  const char* what = p.allFinite() && v.allFinite() ? "outside the box" : "not a number";
  note(step, fmt::format("particle {} is at {} with velocity {}, {}: {}", particles.id[i], text_of(p), text_of(v), what,
                         unstable));
}

// Summed in integer units, so the order of the particles does not matter: the sums over a part are exact in doubles,
// too. The compression of particles on top of one another counts as a hundredfold at most. Adding 1.5 · 2^52 rounds
// like llrint, and vectorises.
void Guard::note_compression(std::span<const Real> density, Real rest_density) {
  constexpr Real largest = 100, units = 1 << 20;
  constexpr LocalId part_size = 8192;
  PerThread<std::int64_t> sums;
  for_each_part({0, static_cast<LocalId>(density.size())}, part_size, [&](Range part) {
    constexpr Real shift = 6755399441055744.0;
    std::array<Real, 4> lanes{};
    const auto add = [&](std::size_t lane, std::size_t i) {
      const Real c = density[i] / rest_density - 1;
      lanes[lane] += (units * std::min(std::max(0.0, c), largest) + shift) - shift;
    };
    auto i = static_cast<std::size_t>(part.begin);
    for (; i + lanes.size() <= static_cast<std::size_t>(part.end); i += lanes.size()) {
      for (std::size_t lane = 0; lane < lanes.size(); ++lane) add(lane, i + lane);
    }
    for (; i < static_cast<std::size_t>(part.end); ++i) add(0, i);
    sums.mine() += static_cast<std::int64_t>(lanes[0] + lanes[1] + lanes[2] + lanes[3]);
  });
  noted_compression_ = 0;
  sums.for_each([&](std::int64_t sum) { noted_compression_ += sum; });
}

void Guard::agree(const Particles& particles, std::int64_t step) {
  StepState mine = state_of(particles.id);
  mine.compression = noted_compression_;
  mine.failures = failure_.empty() ? 0 : 1;
  if (ask_) mine.requests = ask_();
  const StepState now = consensus_.count(mine);
  requests_ = now.requests;
  if (now.failures > 0) throw BlowUp(first_text(comm_, failure_));
  const std::string wrong = lost_or_doubled(now);
  if (!wrong.empty()) throw BlowUp(fmt::format("step {}: {}", step, wrong));
  last_compression_ = compression_;
  compression_ =
      now.particles > 0 ? std::ldexp(static_cast<Real>(now.compression), -20) / static_cast<Real>(now.particles) : 0;
}

void Guard::end_if_crushed(std::int64_t step) const {
  constexpr Real crushed = 0.5, relieved = 0.9;
  if (compression_ > crushed && compression_ > relieved * last_compression_) {
    throw BlowUp(
        fmt::format("step {}: the water is compressed by {:.0f} % in the mean: {}", step, 100 * compression_,
                    "particles lie on one another, there is more water than space, or solids press it; look at "
                    "the particles and at what moves"));
  }
}

std::string Guard::lost_or_doubled(const StepState& now) const {
  const auto more = static_cast<std::int64_t>(now.particles - start_.particles);
  const std::uint64_t difference = now.ids - start_.ids;
  if (more == 0 && difference == 0 && now.squares == start_.squares) return {};
  std::string what = fmt::format("{} particles instead of {}", now.particles, start_.particles);
  const bool one_lost = more == -1 && start_.squares - now.squares == difference * difference;
  const bool one_doubled = more == 1 && now.squares - start_.squares == difference * difference;
  if (one_lost) what = fmt::format("particle {} is lost", static_cast<GlobalId>(0 - difference));
  if (one_doubled) what = fmt::format("particle {} is there twice", static_cast<GlobalId>(difference));
  if (more == 0) what = "as many particles as at the start, but with other ids: some are lost, some there twice";
  return what +
         ": a fault of this machine or a bug of Trevi, as nothing ever removes a particle; go on from the last "
         "checkpoint, and report it if it happens again";
}

}  // namespace trevi
