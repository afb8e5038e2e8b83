// The neighbourhood of each particle in one substep: cell order, ghosts, packed records, neighbour list. rebuild() is
// called after the prediction; list, ghosts and order then stay the same until the end of the substep. The records
// follow the particles: write the owned ones, then exchange them by halo(). Work on interior planes may go on between
// start() and finish() of the halo. Collective: rebuild and everything that exchanges.
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
  /// particles must be in this rank's window. Where a particle has too many neighbours
  /// (list().first_overfull_particle(), on its rank alone), the rows of it and of those after it are empty; collective
  /// calls remain possible.
  void rebuild(Particles& particles, const Slabs& slabs, Velocities velocities = Velocities::discard) {
    arrange(particles, slabs, velocities);
    search();
  }
  /// The two parts of it, between which there is no list: the order, ghosts and records; the list of neighbours of the
  /// positions that the records have.
  void arrange(Particles& particles, const Slabs& slabs, Velocities velocities);
  void search();

  /// Writes the positions of the owned particles of the range into their records, on this thread; the scalar is set to
  /// zero.
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

  /// Sends the positions in the records of the boundary, and receives those of the ghosts, whose scalars become zero;
  /// where the box is periodic, brings those from beyond its end, and the copies, to the place where they are
  /// neighbours.
  void start_positions() { halo_.template start_part<Coordinates>(records_, 0); }
  void finish_positions();
  /// The same for the scalars alone.
  void start_scalars() { halo_.template start_part<T>(records_, offsetof(Packed<T>, w)); }
  void finish_scalars();
  /// Exchanges another field of all particles, and copies it; of vectors the three coordinates alone.
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

  /// boundary(): the particles whose records the neighbour ranks hold, i.e. those of the first and the last plane, and
  /// of the rows at cuts in the others; interior(): all others. In ranges as long as they get, in their order. With
  /// `depth` so many planes and rows in place of one belong to the boundary.
  std::vector<Range> boundary(LocalId depth = 1) const;
  std::vector<Range> interior(LocalId depth = 1) const;
  /// The planes and rows of the interior, counted from the own ones; empty where there are none.
  CellWindow interior_window(LocalId depth) const;
  Range all() const { return {0, order_.owned()}; }

  /// With all that is borrowed from its Scratch.
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
