// The neighbourhood of each particle in one substep: cell order, ghosts, packed records, neighbour list. rebuild() is
// called after the prediction; list, ghosts and order then stay the same until the end of the substep. The records
// follow the particles: the owned ones are written and then exchanged by halo(). Interior planes can be processed
// between start() and finish() of the halo. Collective: rebuild() and everything that exchanges.
#pragma once

#include <mpi.h>

#include <array>
#include <cstddef>
#include <memory>

#include "domain/halo.hpp"
#include "domain/slabs.hpp"
#include "parallel/log.hpp"
#include "particles/neighbour_list.hpp"

namespace trevi {

template <class T>
class Neighbourhood {
 public:
  /// The list, and memory for sorting, are borrowed from `scratch`.
  Neighbourhood(MPI_Comm comm, const CellGrid& grid, const Vec3& origin, Real h,
                std::shared_ptr<Scratch> scratch = std::make_shared<Scratch>());

  /// Sorts the particles into cell order by their predicted positions, fetches ghosts and finds neighbours. All
  /// particles must be in this rank's window. If a particle has too many neighbours (list().first_overfull_particle(),
  /// on its rank only), its row and those after it are empty; collective calls remain possible.
  void rebuild(Particles& particles, const Slabs& slabs, Velocities velocities = Velocities::discard) {
    arrange(particles, slabs, velocities);
    search();
  }
  /// The two parts of rebuild(), between which there is no list: arrange() makes the order, ghosts and records;
  /// search() makes the list of neighbours from the positions in the records.
  void arrange(Particles& particles, const Slabs& slabs, Velocities velocities);
  void search();

  /// Writes the positions of owned particles of the range into their records, on this thread, and sets the scalars to
  /// 0.
  void encode(const std::vector<Vec3>& position, Range range);

  /// Record of owned particle i.
  Packed<T>& record(LocalId i) { return records_[static_cast<std::size_t>(order_.low_ghosts() + i)]; }
  std::vector<Packed<T>>& records() { return records_; }
  const std::vector<Packed<T>>& records() const { return records_; }
  const Encoding<T>& encoding() const { return encoding_; }
  const NeighbourList& list() const { return list_; }
  const CellOrder& order() const { return order_; }
  Scratch& scratch() const { return *scratch_; }
  /// For fields that have no positions, and for grids.
  Halo& halo() { return halo_; }
  const Halo& halo() const { return halo_; }

  /// Sends the positions in the records of the boundary and receives those of the ghosts, whose scalars become zero.
  /// Where the box is periodic, ghosts from beyond its end, and copies, are moved to where they are neighbours.
  void start_positions() { halo_.template start_part<Coordinates>(records_, 0); }
  void finish_positions();
  /// The same for the scalars only.
  void start_scalars() { halo_.template start_part<T>(records_, offsetof(Packed<T>, w)); }
  void finish_scalars();
  /// Exchanges another field of all particles and fills its periodic copies; for vectors, only the three coordinates.
  template <class Field>
  void exchange(Field& field) {
    halo_.exchange(field);
    copy(field);
  }
  void exchange_vectors(Borrowed<Vec4<T>>& field) {
    halo_.template start_part<std::array<T, 3>>(field, 0);
    halo_.template finish_part<std::array<T, 3>>(field, 0);
    copy(field);
  }

  /// boundary(): the particles whose records the neighbouring ranks hold, i.e. those of the first and the last plane,
  /// and of the rows at cuts in the other planes; interior(): all others. The ranges are as long as possible and in
  /// order. With `depth` this many planes and rows instead of one belong to the boundary.
  std::vector<Range> boundary(LocalId depth = 1) const;
  std::vector<Range> interior(LocalId depth = 1) const;
  /// The planes and rows of the interior, relative to the owned ones; empty if there are none.
  CellWindow interior_window(LocalId depth) const;
  Range all() const { return {0, order_.owned()}; }

  /// Memory in bytes, including everything that is borrowed from its Scratch.
  std::size_t bytes() const {
    return scratch_->bytes() + records_.capacity() * sizeof(Packed<T>) + list_.bytes() + order_.bytes() +
           halo_.memory();
  }

 private:
  using Coordinates = std::array<typename Packed<T>::Coordinate, 3>;
  template <class Field>
  void copy(Field& field) const {
    for (const CellOrder::Copy& copy : order_.copies())
      std::copy_n(field.begin() + copy.from, copy.count, field.begin() + copy.to);
  }
  void move_ghosts(std::size_t direction, Range range, Real turns);
  void move_ghosts_from_beyond();

  std::shared_ptr<Scratch> scratch_;
  MPI_Comm comm_;
  CellOrder order_;
  Halo halo_;
  Encoding<T> encoding_;
  std::vector<Packed<T>> records_;
  NeighbourList list_;
  Event sort_event_{"CellSort"}, halo_event_{"HaloRebuild"}, search_event_{"NeighbourSearch"};
};

extern template class Neighbourhood<float>;
extern template class Neighbourhood<double>;

}  // namespace trevi
