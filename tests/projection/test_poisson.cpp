// The Poisson equation of the projection against manufactured solutions: the error of phi falls with the square of the
// spacing in the interior, below a free surface that lies anywhere in its cells, and in the cells that a round wall
// cuts. Observed orders are printed. On one rank: bits do not depend on the ranks (tests/solver/test_ranks.cpp).
#include <cmath>
#include <numbers>

#include "boundary/obstacles/obstacles.hpp"
#include "stages.hpp"

namespace trevi::test {
namespace {

constexpr Real pi = std::numbers::pi;

/// phi, m², and its gradient, m; up to a constant where the water has no surface.
struct Solution {
  std::function<Real(const Vec3&)> phi;
  Field gradient;
  bool closed = false;
};

/// Errors of phi over its size, in all cells and in those beside what is tested.
struct Errors {
  Real all = 0, beside = 0;
};

/// Of a run of stages for water that moves by minus the gradient, so that phi brings it to rest; `beside` says of
/// which cells.
template <class Beside>
Errors errors_of(Stages& stages, const Solution& exact, Real g_dt2, const Beside& beside) {
  stages.classify();
  stages.solve(g_dt2);
  Real sum = 0, cells = 0;
  const auto difference = [&](LocalId k, LocalId r, LocalId c) {
    return stages.pressure.phi(stages.grid.index(k, r, c)) - exact.phi(stages.middle(k, r, c));
  };
  const auto counts = [&](LocalId k, LocalId r, LocalId c) {
    const std::size_t at = stages.grid.index(k, r, c);
    return stages.surface->is_wet(at) && !stages.surface->is_solid(at);
  };
  stages.for_each_cell([&](LocalId k, LocalId r, LocalId c) {
    if (!counts(k, r, c)) return;
    sum += difference(k, r, c);
    cells += 1;
  });
  const Real origin = exact.closed ? sum / cells : 0;
  Errors errors;
  stages.for_each_cell([&](LocalId k, LocalId r, LocalId c) {
    if (!counts(k, r, c)) return;
    const Real error = std::abs(difference(k, r, c) - origin);
    errors.all = std::max(errors.all, error);
    if (beside(stages.grid.index(k, r, c))) errors.beside = std::max(errors.beside, error);
  });
  return errors;
}

/// Prints errors at spacings that are halved from one to the next, and returns the order over all of them.
Real order_of(const char* what, const std::vector<Real>& errors) {
  const Real order = std::log2(errors.front() / errors.back()) / static_cast<Real>(errors.size() - 1);
  std::printf("%s: errors", what);
  for (const Real one : errors) std::printf(" %.2e", one);
  std::printf(", order %.2f\n", order);
  return order;
}

// phi is 0 half a cell above the last one.
Real interior_error(LocalId cells) {
  const Real size = 1.0 / cells, link = 1 / (size * size);
  Multigrid multigrid(world);
  multigrid.resize({{0, cells}, 1, {0, 1}}, cells, cells, cells);
  MultigridLevel& finest = multigrid.finest();
  const auto middle = [&](LocalId i) { return pi * (i + 0.5) * size; };
  const auto exact = [&](LocalId k, LocalId r, LocalId c) {
    return std::cos(middle(k)) * std::cos(middle(r)) * std::cos(middle(c) / 2);
  };
  const auto for_each_cell = [&](const auto& visit) {
    for (LocalId k = 0; k < cells; ++k)
      for (LocalId r = 0; r < cells; ++r)
        for (LocalId c = 0; c < cells; ++c) visit(k, r, c, finest.shape().index(k + 1, r, c));
  };
  for_each_cell([&](LocalId k, LocalId r, LocalId c, std::size_t at) {
    finest.link[0][at] = k > 0 ? link : 0;
    finest.link[1][at] = r > 0 ? link : 0;
    finest.link[2][at] = c > 0 ? link : 0;
    finest.dirichlet[at] = c + 1 == cells ? 2 * link : 0;
    finest.rhs[at] = 2.25 * pi * pi * exact(k, r, c);
  });
  Halo halo(world);
  multigrid.solve(halo, 30);
  Real wrong = 0;
  for_each_cell([&](LocalId k, LocalId r, LocalId c, std::size_t at) {
    wrong = std::max(wrong, std::abs(finest.phi[at] - exact(k, r, c)));
  });
  return wrong;
}

TEST(Poisson, IsOfSecondOrderInTheInterior) {
  EXPECT_NEAR(order_of("interior", {interior_error(8), interior_error(16), interior_error(32)}), 2, 0.1);
}

// The surface lies at another height of its cells with each spacing.
TEST(Poisson, IsOfSecondOrderBelowAFreeSurface) {
  constexpr Real size = 1e-6, length = 1.6, height = 1.5;
  const Solution exact{[](const Vec3& p) {
                         return -size * (1 + std::cos(pi * p.x() / length) / 2) * std::cos(pi * p.z() / (2 * height));
                       },
                       [](const Vec3& p) {
                         const Real k = pi / length, m = pi / (2 * height), along = 1 + std::cos(k * p.x()) / 2;
                         return Vec3(size * k / 2 * std::sin(k * p.x()) * std::cos(m * p.z()), 0,
                                     size * m * along * std::sin(m * p.z()));
                       }};
  std::vector<Real> all, beside;
  for (const Real spacing : {0.1, 0.05, 0.025}) {
    const Box basin{Vec3::Zero(), Vec3(length, 0.4, 2.13)};
    Water water([&](const Vec3& p) { return Vec3(-exact.gradient(p)); },
                {.top = height, .at = 0, .box = basin, .spacing = spacing});
    Stages stages(water, spacing);
    const Errors errors =
        errors_of(stages, exact, size / height, [&](std::size_t at) { return stages.surface->is_top(at); });
    all.push_back(errors.all / size);
    beside.push_back(errors.beside / size);
  }
  EXPECT_GT(order_of("all cells", all), 1.6);
  EXPECT_GT(order_of("cells at the surface", beside), 1.6);
}

// Water at rest under gravity that leans: its surface steps down by a cell after every other one, and on the lattice
// the mean height of each cell is that of the plane, but at the walls, beyond which there is none.
TEST(Poisson, HasTheLinearPressureBelowASurfaceThatLeans) {
  constexpr Real spacing = 0.1, g_dt2 = 1e-3;
  for (const Real slope : {0.5, -0.5}) {
    const auto surface = [&](const Vec3& p) { return 1.25 + slope * (p.x() - 1); };
    const Solution exact{[&](const Vec3& p) { return g_dt2 * (p.z() - surface(p)); },
                         [&](const Vec3&) { return Vec3(-g_dt2 * slope, 0, g_dt2); }};
    Water water([&](const Vec3& p) { return Vec3(-exact.gradient(p)); },
                {.top = 2.2, .at = 0, .holds = [&](const Vec3& p) { return p.z() < surface(p); }});
    Stages stages(water, spacing);
    const auto inside = [&](std::size_t at) {
      const auto plane = static_cast<LocalId>(at / stages.grid.step(0));
      return plane > 2 && plane < stages.grid.planes() - 1;
    };
    const Errors errors = errors_of(stages, exact, g_dt2, inside);
    EXPECT_LT(errors.all, 0.11 * g_dt2 * spacing);  // 0.101 at the walls
    EXPECT_LT(errors.beside, 0.03 * g_dt2 * spacing);
  }
}

// A cylinder that is full of water to the ceiling.
TEST(Poisson, IsOfSecondOrderInCutCells) {
  constexpr Real size = 1e-6, radius = 0.73, height = 1.2;
  const Vec3 centre(0.81, 0.79, height / 2);
  const Solution exact{
      [&](const Vec3& p) {
        const Real r = (p - centre).head<2>().norm();
        return size * std::cos(pi * r / radius) * (1 + std::cos(pi * p.z() / height) / 2);
      },
      [&](const Vec3& p) {
        const Vec3 off(p.x() - centre.x(), p.y() - centre.y(), 0);
        const Real r = off.norm(), k = pi / radius, m = pi / height;
        const Real slope = -size * k * std::sin(k * r) * (1 + std::cos(m * p.z()) / 2);
        return Vec3(slope * off.stableNormalized() + Vec3(0, 0, -size * m / 2 * std::sin(m * p.z()) * std::cos(k * r)));
      },
      true};
  std::vector<Real> all, beside;
  for (const Real spacing : {0.1, 0.05, 0.025}) {
    Settings settings;
    settings.domain = {Vec3::Zero(), Vec3(1.6, 1.6, height)};
    settings.fluid.spacing = spacing;
    settings.obstacles.emplace_back();
    ObstacleSettings& vessel = settings.obstacles.back();
    vessel.shape = ShapeKind::cylinder;
    vessel.inside = true;
    vessel.center = centre;
    vessel.radius = radius;
    vessel.height = 4;
    settings = resolved(settings);
    const Real cell = 2 * spacing;
    Obstacles obstacles(settings, Walls(settings.domain, settings.walls, 1e-6 * cell), std::nullopt);
    Water water([&](const Vec3& p) { return Vec3(-exact.gradient(p)); },
                {.top = height, .at = 0, .box = settings.domain, .spacing = spacing, .holds = [&](const Vec3& p) {
                   return (p - centre).head<2>().norm() < radius;
                 }});
    Stages stages(water, spacing, &obstacles);
    const Errors errors = errors_of(stages, exact, 0, [&](std::size_t at) { return stages.surface->is_cut(at); });
    all.push_back(errors.all / size);
    beside.push_back(errors.beside / size);
  }
  EXPECT_GT(order_of("all cells", all), 1.6);
  EXPECT_GT(order_of("cut cells", beside), 1.6);
}

}  // namespace
}  // namespace trevi::test
