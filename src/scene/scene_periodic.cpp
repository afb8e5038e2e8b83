#include "scene/scene_periodic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "boundary/geometry/periods.hpp"
#include "fluid/forcings/inlet.hpp"
#include "particles/cell_grid.hpp"
#include "scene/scene_place.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

// An inlet does not see water beyond a periodic end, and makes none there.
void check_inlet(const Scene& scene, const InletSettings& inlet) {
  const Real least = 2 * scene.fluid.kernel_radius;
  const Vec3 reach = InletLattice(inlet, scene.fluid.spacing).reach();
  for (int a = 0; a < 3; ++a) {
    const Real gap = std::min(inlet.center[a] - scene.domain.min[a], scene.domain.max[a] - inlet.center[a]) - reach[a];
    if (scene.periodic[static_cast<std::size_t>(a)] && gap < least)
      throw InputError(fmt::format(
          "the opening is {:.6g} m from an end of the periodic axis {}; keep it {:.6g} m (two kernel radii) away from "
          "both ends",
          gap, "xyz"[a], least));
  }
}

}  // namespace

void read_periodic(Section& domain, Scene& scene) {
  std::vector<std::string> axes;
  if (!domain.texts({"periodic", "the axes along which the box repeats, of \"x\", \"y\" and \"z\""}, axes)) return;
  for (const std::string& axis : axes) {
    const std::size_t a = axis.size() == 1 ? std::string("xyz").find(axis) : std::string::npos;
    if (domain.check("periodic", a < 3, fmt::format("unknown axis \"{}\"; choose from x, y, z", printable(axis))))
      if (domain.check("periodic", !scene.periodic[a], fmt::format("names \"{}\" twice; name it once", axis)))
        scene.periodic[a] = true;
  }
}

void check_periodic(Section& domain, const Scene& scene) {
  const Real h = scene.fluid.kernel_radius;
  const Vec3 gravity = scene.gravity.value_or(Vec3::Zero());
  for (std::size_t a = 0; a < 3; ++a) {
    if (!scene.periodic[a]) continue;
    const Real length = (scene.domain.max - scene.domain.min)[static_cast<Eigen::Index>(a)];
    const Real below = std::max(3.0, std::floor(length / h)), above = std::max(below + 1, std::ceil(length / h));
    domain.check(
        "periodic", is_whole_period(length, h),
        fmt::format("{} is {} m long, and must be a whole number of kernel radii of {} m, three at least; make "
                    "it {:.6g} or {:.6g} m",
                    "xyz"[a], length, h, below * h, above * h));
  }
  domain.check("periodic", !scene.periodic[2] || gravity.z() == 0,
               "z cannot be periodic where gravity goes along it: the water would fall for ever; leave z out, or set "
               "[gravity] acceleration along x or y");
  domain.check("periodic", !scene.periodic[2] || scene.walls.floor_friction == 0,
               "there is no floor where z is periodic, and walls.floor_friction brakes the water on one; leave one of "
               "them out");
}

void check_no_images(const Scene& scene) {
  for (std::size_t k = 0; k < scene.inlets.size(); ++k)
    told_at(scene, {"inlet", k}, "center", [&] { check_inlet(scene, scene.inlets[k]); });
  for (std::size_t k = 0; k < scene.obstacles.size(); ++k) {
    if (const std::string wrong = why_not_periodic(scene.obstacles[k], scene); !wrong.empty())
      told_at(scene, {"obstacle", k}, "", [&] { throw InputError(wrong); });
  }
}

}  // namespace trevi
