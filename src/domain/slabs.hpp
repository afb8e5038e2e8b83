// Who owns which part of the box: each rank owns a run of cell planes along the slab axis, at least one.
// Every rank knows all cuts (one number a rank), so ownership never needs a message. Not collective.
#pragma once

#include <span>
#include <vector>

#include "trevi/types.hpp"

namespace trevi {

/// A message between neighbour slabs is shorter than this: MPI counts its bytes in an int.
inline constexpr std::size_t max_message_bytes = std::size_t{1} << 31;

class Slabs {
 public:
  /// Cuts the planes so that the largest weight of a rank is as small as whole planes allow. `weights`: one per plane,
  /// in any unit. Throws InputError when there are more ranks than planes.
  Slabs(std::span<const Real> weights, int ranks);

  int ranks() const { return static_cast<int>(cuts_.size()) - 1; }
  LocalId first_plane(int rank) const { return cuts_[static_cast<std::size_t>(rank)]; }
  LocalId end_plane(int rank) const { return cuts_[static_cast<std::size_t>(rank) + 1]; }  ///< one past
  int owner(LocalId plane) const;
  /// Largest sum of weights over ranks, divided by the mean; 1 where there is no weight. `weights`: one per plane.
  Real imbalance(std::span<const Real> weights) const;
  /// Whether each rank, with its ghost planes, can count its cells in a LocalId.
  bool cells_fit(LocalId cells_per_plane) const;
  /// Throws InputError when a rank and its ghosts would have more particles, or cells, than a LocalId counts, or a
  /// plane at a cut more bytes than one message holds. `weights`: particles of each plane, `record_bytes` each.
  void check_capacity(std::span<const Real> weights, LocalId cells_per_plane, std::size_t record_bytes) const;

 private:
  Real cells(int rank, LocalId cells_per_plane) const;  // ghost planes included
  void check_messages(std::span<const Real> weights, LocalId cells_per_plane, std::size_t record_bytes) const;

  std::vector<LocalId> cuts_;  // ranks + 1
};

}  // namespace trevi
