// Which particles one of [[output.frames]] holds: those in a box, those near the surface (visible.hpp, as the viewer
// draws it), every 2^k-th by a hash of its id, or those that meet all of these conditions. Invariant: whether a
// particle is selected depends only on its id and on the positions of all particles, so it is the same on any rank
// count, and of disjoint boxes that fill the domain exactly one holds it. Collective: select().
#pragma once

#include <optional>
#include <vector>

#include "trevi/box.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace trevi {

struct SelectionOptions {
  Box domain;
  std::optional<Box> box;       ///< faces that are not the domain's: the lower ones belong to it, the upper ones do not
  int thinning = 0;             ///< k
  std::optional<Real> surface;  ///< the kernel radius, m
};

/// A frame of some of the particles, which owns them.
struct SelectedFrame {
  Particles particles;
  std::vector<Real> density;
};

class FrameSelection {
 public:
  explicit FrameSelection(SelectionOptions options) : options_(std::move(options)) {}

  /// In the order of the frame.
  SelectedFrame select(MPI_Comm comm, const Frame& frame) const;

 private:
  bool in_box(const Vec3& p) const;
  std::vector<LocalId> near_surface(MPI_Comm comm, const std::vector<Vec3>& positions) const;

  SelectionOptions options_;
};

}  // namespace trevi
