// The data that a picture is drawn from, whether a run sends them to its viewer or the viewer reads them from the run's
// files: the box, and for each frame the particles worth drawing (visible.hpp). Plain data in SI units; a
// ViewedParticle may be sent and stored as its bytes.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "trevi/forcing.hpp"
#include "trevi/obstacle.hpp"

namespace trevi {

struct ViewedScene {
  std::string name, directory;  ///< the directory of the output, absolute
  Vec3 min = Vec3::Zero(), max = Vec3::Ones();
  Real spacing = 0.1, rest_density = 1000;
  int ranks = 1;
  std::int64_t last_step = 0;
};

struct ViewedParticle {
  float x = 0, y = 0, z = 0;  ///< m
  float speed = 0;            ///< m/s
  float density = NAN;        ///< kg/m³; nan unless requested
  std::uint8_t rgb[3] = {0, 0, 0};
  std::uint8_t unused = 0;
};

struct ViewedFrame {
  std::int64_t step = 0;
  Real time = 0;
  std::int64_t particles = 0;  ///< of the run
  int level = 0;               ///< of thinning (visible.hpp)
  std::vector<FountainState> fountains;
  std::vector<std::int64_t> rank_counts;  ///< how many of the particles below are of rank 0, 1, ...
  std::vector<ViewedParticle> shown;
  std::vector<std::shared_ptr<const TriangleMesh>> solids;  ///< surfaces of obstacles, in the world, towards the water
};

}  // namespace trevi
