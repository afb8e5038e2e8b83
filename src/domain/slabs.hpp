// Who owns which part of the box: slabs are runs of cell planes along the slab axis, at least one each. A slab belongs
// to one rank, or is cut into runs of rows for several ranks, as many in each slab, with cuts of its own. Every rank
// knows all cuts (one or two numbers a rank), so ownership never needs a message. Not collective.
#pragma once

#include <span>
#include <vector>

#include "domain/cell_cuts.hpp"

namespace trevi {

/// A message between neighbour slabs is shorter than this: MPI counts its bytes in an int.
inline constexpr std::size_t max_message_bytes = std::size_t{1} << 31;

/// The cuts between so many parts for which the largest weight of a part is as small as can be; each part has one of
/// the weights at least, so there may not be more parts.
std::vector<LocalId> even_cuts(std::span<const Real> weights, int parts);

class Slabs {
 public:
  /// Cuts the planes so that the largest weight of a slab is as small as whole planes allow. `weights`: one per plane,
  /// in any unit. Throws InputError when there are more slabs than planes.
  Slabs(std::span<const Real> weights, int slabs);
  /// Cuts each slab into `parts` runs of rows: `rows` as in CellCuts.
  void set_rows(std::vector<LocalId> rows, int parts);

  const CellCuts& cuts() const { return cuts_; }
  int ranks() const { return cuts_.ranks(); }
  int slabs() const { return cuts_.slabs(); }
  int parts() const { return cuts_.parts; }  ///< runs of rows of each slab
  LocalId first_plane(int rank) const { return cuts_.planes[slab(rank)]; }
  LocalId end_plane(int rank) const { return cuts_.planes[slab(rank) + 1]; }  ///< one past
  /// What a rank owns of planes of `rows` rows.
  CellWindow window(int rank, LocalId rows) const { return cuts_.window(rank, rows); }
  int slab_of(LocalId plane) const;
  int owner(LocalId plane, LocalId row) const;
  int owner(const CellGrid& grid, const Vec3& p) const { return owner(grid.plane_of(p), grid.row_of(p)); }
  /// Largest sum of weights over slabs, divided by the mean; 1 where there is no weight. `weights`: one per plane.
  Real imbalance(std::span<const Real> weights) const;
  /// Whether each rank, with its ghosts, can count its cells in a LocalId.
  bool cells_fit(const CellGrid& grid) const { return cells_fit(grid.rows(), grid.columns()); }
  bool cells_fit(LocalId rows, LocalId columns) const;
  /// Throws InputError when a rank and its ghosts would have more particles, or cells, than a LocalId counts, or a
  /// plane at a cut more bytes than one message holds. `weights`: particles of each plane, of which each rank of a slab
  /// has an even share; `bytes_of_particle`: of the largest message.
  void check_capacity(std::span<const Real> weights, const std::array<LocalId, 2>& rows_and_columns,
                      Real bytes_of_particle) const;

 private:
  std::size_t slab(int rank) const { return static_cast<std::size_t>(rank / cuts_.parts); }
  Real cells(int rank, LocalId rows, LocalId columns) const;  // ghosts included
  void check_messages(std::span<const Real> weights, const std::array<LocalId, 2>& rows_and_columns,
                      Real bytes_of_particle) const;

  CellCuts cuts_;  // of rows {0, 1} where they are not cut
};

}  // namespace trevi
