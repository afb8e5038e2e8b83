#include "boundary/boundary.hpp"

#include "base/threads.hpp"

namespace trevi {

namespace {

class WallBoundary : public Boundary {
 public:
  using Boundary::Boundary;
  Vec3 predict(Vec3& p, const Vec3& v, Real dt) override { return walls().predict(p, v, dt); }
  Vec3 collide(const Vec3& p, const Vec3& shift) override { return walls().collide(p, shift); }
  OpenSpace open_space(std::span<const Vec3>, Extent, LocalId) const override { return OpenSpace(walls().box()); }
  bool is_open_inside() const override { return true; }
};

class ObstacleBoundary : public Boundary {
 public:
  ObstacleBoundary(const Walls& walls, std::shared_ptr<Obstacles> obstacles)
      : Boundary(walls), obstacles_(std::move(obstacles)) {}
  Vec3 predict(Vec3& p, const Vec3& v, Real dt) override { return obstacles_->predict(p, v, dt); }
  Vec3 collide(const Vec3& p, const Vec3& shift) override { return obstacles_->collide(p, shift); }
  OpenSpace open_space(std::span<const Vec3> p, Extent extent, LocalId first) const override {
    return obstacles_->open_space(p, extent, first);
  }
  void begin_step() override { obstacles_->begin_step(); }
  void settle_bodies(MPI_Comm comm, Particles& particles, Real dt) override { obstacles_->settle(comm, particles, dt); }
  void give_to_bodies(MPI_Comm comm) override { obstacles_->give_to_bodies(comm); }
  void finish_bodies(MPI_Comm comm) override { obstacles_->finish_bodies(comm); }
  void move(Real begin, Real end) override { obstacles_->move(begin, end); }
  Real fastest(Real begin, Real end) const override { return obstacles_->fastest(begin, end); }
  Real acceleration(Real begin, Real end, Real h) const override { return obstacles_->acceleration(begin, end, h); }
  Obstacles* obstacles() const override { return obstacles_.get(); }

 private:
  const std::vector<LocalId>* bent() const override { return obstacles_->bent(); }

  std::shared_ptr<Obstacles> obstacles_;
};

// `Inside` is what particles meet in the box; it does not know that the box is periodic.
template <class Inside>
class PeriodicBoundary : public Inside {
 public:
  template <class... Rest>
  explicit PeriodicBoundary(const PeriodicDomain& domain, Rest&&... rest)
      : Inside(std::forward<Rest>(rest)...), domain_(domain) {}

  OpenSpace open_space(std::span<const Vec3>, Extent, LocalId) const override { return {}; }
  bool is_open_inside() const override { return false; }

  void round_positions(Particles& particles) const override {
    for_each_index({0, particles.size()},
                   [&](std::size_t i) { particles.position[i] = domain_.rounded(particles.position[i]); });
  }
  void wrap_positions(Particles& particles) const override {
    for_each_index({0, particles.size()}, [&](std::size_t i) {
      Vec3& p = particles.position[i];
      p = domain_.rounded(p);
      p += domain_.back(p);
    });
  }
  void wrap_predicted(Particles& particles) const override {
    for_each_index({0, particles.size()}, [&](std::size_t i) {
      const Vec3 back = domain_.in_order(particles.predicted[i]);
      particles.predicted[i] += back;
      particles.position[i] += back;
    });
  }

 protected:
  PeriodicDomain domain_;
};

// Walls along the other axes do not depend on the position along the periodic ones, so paths are computed without it.
class PeriodicWalls : public PeriodicBoundary<WallBoundary> {
 public:
  using PeriodicBoundary::PeriodicBoundary;
  Vec3 predict(Vec3& p, const Vec3& v, Real dt) override {
    return domain_.moved(p, walls().predict(domain_.without_place(p), v, dt));
  }
  Vec3 collide(const Vec3& p, const Vec3& shift) override {
    return domain_.moved(p, walls().collide(domain_.without_place(p), shift));
  }
};

class PeriodicObstacles : public PeriodicBoundary<ObstacleBoundary> {
 public:
  using PeriodicBoundary::PeriodicBoundary;
  Vec3 predict(Vec3& p, const Vec3& v, Real dt) override {
    const Vec3 before = p, end = ObstacleBoundary::predict(p, v, dt);
    if (p != before) p = domain_.moved_to(before, p);
    return domain_.moved_to(before, end);
  }
  Vec3 collide(const Vec3& p, const Vec3& shift) override {
    return domain_.moved_to(p, ObstacleBoundary::collide(p, shift));
  }
};

// Two dimensions. Nothing pushes along y except perhaps rounding, but a layer that is compressed buckles, which would
// amplify this to metres.
template <class Inside>
class Layer : public Inside {
 public:
  using Inside::Inside;
  void wrap_positions(Particles& particles) const override {
    Inside::wrap_positions(particles);
    for_each_index({0, particles.size()}, [&](std::size_t i) {
      particles.position[i].y() = 0;
      particles.velocity[i].y() = 0;
    });
  }
};

template <class Inside>
using AsItIs = Inside;

template <template <class> class Kind>
std::unique_ptr<Boundary> make(BoundaryParts parts) {
  if (parts.periodic && parts.obstacles)
    return std::make_unique<Kind<PeriodicObstacles>>(*parts.periodic, parts.walls, std::move(parts.obstacles));
  if (parts.periodic) return std::make_unique<Kind<PeriodicWalls>>(*parts.periodic, parts.walls);
  if (parts.obstacles) return std::make_unique<Kind<ObstacleBoundary>>(parts.walls, std::move(parts.obstacles));
  return std::make_unique<Kind<WallBoundary>>(parts.walls);
}

}  // namespace

LocalId Boundary::predict(Particles& particles, Real dt) {
  PerThread<LocalId> lost;
  lost.for_each([&](LocalId& first) { first = particles.size(); });
  std::vector<Vec3>& x = particles.position;
  const std::vector<Vec3>& v = particles.velocity;
  const auto bend = [&](LocalId one) {  // all others are inside
    const auto i = static_cast<std::size_t>(one);
    particles.predicted[i] = predict(x[i], v[i], dt);
    if (!walls_.inside(particles.predicted[i])) lost.mine() = std::min(lost.mine(), one);
  };
  if (const std::vector<LocalId>* const all = bent(); all != nullptr) {
    for_each_part({0, static_cast<LocalId>(all->size())}, Obstacles::at_once, [&](Range part) {
      for (LocalId k = part.begin; k < part.end; ++k) bend((*all)[static_cast<std::size_t>(k)]);
    });
  } else {
    for_each_part({0, particles.size()}, Obstacles::at_once, [&](Range part) {
      const auto begin = static_cast<std::size_t>(part.begin), count = static_cast<std::size_t>(part.size());
      const Straight way{{&x[begin], count}, {&v[begin], count}, dt};
      const OpenSpace open = open_space(way.p, Extent::path, part.begin);
      std::array<LocalId, Obstacles::at_once> left;
      const std::size_t few = go_straight(open, way, &particles.predicted[begin], left.data());
      for (std::size_t k = 0; k < few; ++k) bend(part.begin + left[k]);
    });
  }
  LocalId first = particles.size();
  lost.for_each([&](LocalId one) { first = std::min(first, one); });
  return first;
}

std::unique_ptr<Boundary> make_boundary(BoundaryParts parts) {
  return parts.layer ? make<Layer>(std::move(parts)) : make<AsItIs>(std::move(parts));
}

}  // namespace trevi
