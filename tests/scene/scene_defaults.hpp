// Each key of a scene that has a default, with that default written out as --set takes it.
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "trevi/scene.hpp"

namespace trevi::test {

/// Of the tables whose keys have their defaults with or without them, for a scene of blocks that names no cfl. What is
/// computed from other keys is taken from `scene`.
inline std::vector<std::string> defaults_of_all_scenes(const Scene& scene) {
  return {fmt::format("domain.slab_axis='{}'", scene.slab_axis == 0 ? 'x' : 'y'),
          "domain.slabs='balanced'",
          "domain.dimensions=3",
          "fluid.rest_density=1000.0",
          fmt::format("fluid.kernel_radius={}", 2 * scene.fluid.spacing),
          "fluid.mass='calibrated'",
          "fluid.density_kernel='spiky'",
          "fluid.gradient_kernel='spiky'",
          "particles.0.type='block'",
          "particles.0.velocity=[0, 0, 0]",
          "particles.0.vortex=0",
          "time.cfl=2",
          "time.max_substeps=500",
          "density.preset='default'",
          "density.method='chebyshev'",
          "density.iterations=3",
          "density.crush_limit=0.05",
          "density.spectral_radius=0.95",
          "density.coarse_grid=true",
          "density.max_shift=0.1",
          "density.epsilon=1",
          fmt::format("density.relaxation={}", scene.density.relaxation),
          "density.constraint='inequality'",
          "density.precision='double'",
          "walls.restitution=0.5",
          "walls.density='analytic'",
          "walls.reflection='normal'",
          "walls.floor_friction=0.0",
          fmt::format("output.directory='out/{}'", scene.name),
          "random.seed=1"};
}

/// Of the tables that make a feature, which a scene must have; see every_table.
inline const std::vector<std::string> defaults_of_features = {"gravity.acceleration=[0, 0, -9.8]",
                                                              "tensile.k=0.001",
                                                              "tensile.n=4",
                                                              "tensile.dq=0.2",
                                                              "vorticity.epsilon=0.002",
                                                              "vorticity.form='report'",
                                                              "viscosity.c=0.001",
                                                              "viscosity.no_slip=false",
                                                              "fountain.0.diameter=0.15",
                                                              "fountain.0.height=0.2",
                                                              "fountain.0.direction=[0, 0, 1]",
                                                              "fountain.0.speed=10",
                                                              "fountain.0.jitter=0",
                                                              "fountain.0.start=0",
                                                              "fountain.0.stop=1e300",
                                                              "fountain.0.speed_range=[5, 10]",
                                                              "fountain.0.mapping='linear'",
                                                              "fountain.0.follow='loudness'",
                                                              "fountain.0.rate=44100",
                                                              "inlet.0.type='disc'",
                                                              "inlet.0.direction=[0, 0, 1]",
                                                              "inlet.0.jitter=0",
                                                              "inlet.0.start=0",
                                                              "inlet.0.stop=1e300",
                                                              "inlet.0.recycle=false",
                                                              "inlet.0.speed_range=[5, 10]",
                                                              "inlet.0.mapping='linear'",
                                                              "inlet.0.follow='loudness'",
                                                              "inlet.0.rate=44100",
                                                              "drain.0.type='box'",
                                                              "obstacle.0.axis=[0, 0, 1]",
                                                              "obstacle.0.rotate=[0, 0, 0]",
                                                              "obstacle.0.inside=false",
                                                              "obstacle.0.velocity=[0, 0, 0]",
                                                              "obstacle.0.angular_velocity=[0, 0, 0]",
                                                              "obstacle.0.restitution=0.5",
                                                              "obstacle.0.friction=0",
                                                              "body.0.axis=[0, 0, 1]",
                                                              "body.0.rotate=[0, 0, 0]",
                                                              "body.0.inside=false",
                                                              "body.0.velocity=[0, 0, 0]",
                                                              "body.0.angular_velocity=[0, 0, 0]",
                                                              "body.0.restitution=0.5",
                                                              "body.0.friction=0",
                                                              "gauge.0.radius=0.2",
                                                              "output.vtu.fields=['velocity', 'density', 'id']",
                                                              "output.vtkhdf.fields=['velocity', 'density', 'id']",
                                                              "output.frames.0.what='particles'",
                                                              "output.frames.0.name='0'",
                                                              "output.frames.0.format='vtkhdf'",
                                                              "output.frames.0.fields=['velocity', 'density', 'id']",
                                                              "output.frames.0.precision='double'",
                                                              "output.frames.0.one_in=1",
                                                              "output.frames.0.surface=false",
                                                              "output.checkpoint.keep=2",
                                                              "output.series.every_steps=1",
                                                              "output.gauges.every_steps=1"};

inline const std::string every_table =
    "[gravity]\n[tensile]\n[vorticity]\n[viscosity]\n[[fountain]]\ncenter = [1, 0.5]\nmusic = '-'\n[[inlet]]\ncenter = "
    "[1, 0.5, 0.5]\nradius = 0.1\nspeed = 10\nmusic = '-'\n"
    "[[drain]]\nmin = [0, 0, 0]\nmax = [0.1, 0.1, 0.1]\n"
    "[[obstacle]]\ntype = 'cylinder'\ncenter = [1, 0.5, 0.5]\nradius = 0.1\nheight = 0.2\n"
    "[[body]]\ntype = 'cylinder'\ncenter = [1, 0.5, 0.8]\nradius = 0.1\nheight = 0.2\ndensity = 500\n"
    "[[gauge]]\ntype = 'height'\ncenter = [1, 0.5, 0]\n[output.vtu]\n"
    "every = 1\n[output.vtkhdf]\nevery = 1\n[[output.frames]]\nevery = "
    "1\n[output.checkpoint]\n[output.series]\n[output.gauges]\n";

/// Of what `density.preset = "report"` changes.
inline const std::vector<std::string> defaults_of_the_report = {"density.method='jacobi'",
                                                                "density.iterations=4",
                                                                "density.relaxation=1.0",
                                                                "density.coarse_grid=false",
                                                                "density.max_shift=0",
                                                                "density.epsilon=1.0",
                                                                "density.constraint='equality'",
                                                                "fluid.mass='volume'",
                                                                "fluid.density_kernel='poly6'",
                                                                "fluid.gradient_kernel='spiky'",
                                                                "walls.restitution=0.5",
                                                                "walls.density='none'",
                                                                "walls.reflection='report'",
                                                                "time.cfl=0",
                                                                "tensile={}",
                                                                "tensile.k=0.001",
                                                                "tensile.n=4",
                                                                "tensile.dq=0.2",
                                                                "vorticity={epsilon=0.002}",
                                                                "viscosity={c=0.001}"};

}  // namespace trevi::test
