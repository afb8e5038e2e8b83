// Ownership of the parts of the box: slabs are runs of cell planes along the slab axis, of at least one plane each. A
// slab belongs to one rank, or is cut into runs of rows for several ranks. Their number is the same for all slabs, but
// each slab has cuts of its own. Every rank knows all cuts (one or two numbers per rank), so ownership never needs a
// message. Not collective.
#pragma once

#include <span>
#include <vector>

#include "domain/cell_cuts.hpp"

namespace trevi {

/// A message between neighbouring slabs is shorter than this, because MPI counts its bytes in an int.
inline constexpr std::size_t max_message_bytes = std::size_t{1} << 31;

/// The cuts between `parts` parts for which the largest weight of a part is as small as possible. Each part has at
/// least one of the weights, so there may not be more parts than weights.
std::vector<LocalId> even_cuts(std::span<const Real> weights, int parts);

class Slabs {
 public:
  /// Cuts the planes such that the largest weight of a slab is as small as whole planes allow. `weights`: one per
  /// plane, in any unit. Throws InputError if there are more slabs than planes.
  Slabs(std::span<const Real> weights, int slabs);
  /// Cuts each slab into `parts` runs of rows: `rows` as in CellCuts.
  void set_rows(std::vector<LocalId> rows, int parts);

  const CellCuts& cuts() const { return cuts_; }
  int ranks() const { return cuts_.ranks(); }
  int slabs() const { return cuts_.slabs(); }
  int parts() const { return cuts_.parts; }  ///< number of runs of rows of each slab
  LocalId first_plane(int rank) const { return cuts_.planes[slab(rank)]; }
  LocalId end_plane(int rank) const { return cuts_.planes[slab(rank) + 1]; }  ///< one past
  /// The window that a rank owns in planes of `rows` rows.
  CellWindow window(int rank, LocalId rows) const { return cuts_.window(rank, rows); }
  int slab_of(LocalId plane) const;
  int owner(LocalId plane, LocalId row) const;
  int owner(const CellGrid& grid, const Vec3& p) const { return owner(grid.plane_of(p), grid.row_of(p)); }
  /// Largest sum of weights over slabs, divided by the mean; 1 if there is no weight. `weights`: one per plane.
  Real imbalance(std::span<const Real> weights) const;
  /// Whether each rank, with its ghosts, can count its cells in a LocalId.
  bool cells_fit(const CellGrid& grid) const { return cells_fit(grid.rows(), grid.columns()); }
  bool cells_fit(LocalId rows, LocalId columns) const;
  /// Throws InputError if a rank and its ghosts would have more particles or cells than a LocalId can count, or a plane
  /// at a cut more bytes than one message can hold. `weights`: particles of each plane, of which each rank of a slab
  /// has an equal share; `bytes_of_particle`: bytes per particle of the largest message.
  void check_capacity(std::span<const Real> weights, const std::array<LocalId, 2>& rows_and_columns,
                      Real bytes_of_particle) const;

 private:
  std::size_t slab(int rank) const { return static_cast<std::size_t>(rank / cuts_.parts); }
  Real cells(int rank, LocalId rows, LocalId columns) const;  // ghosts included
  void check_messages(std::span<const Real> weights, const std::array<LocalId, 2>& rows_and_columns,
                      Real bytes_of_particle) const;

  CellCuts cuts_;  // rows {0, 1} if slabs are not cut
};

}  // namespace trevi
