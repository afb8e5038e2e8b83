// The state of the particles that one rank owns: a structure of arrays, one contiguous array per field, all of the same
// length. Invariant between prediction and the end of a step: cell order (cell plane, row, cell, then id), which is the
// same on any rank count. Ghosts exist only in the packed records of the pair loops (packed.hpp), not here.
// for_each_field is the only list of the fields; migration uses it. Sorting uses for_each_kept_field, because the
// velocities are about to be overwritten then. The fields that are written to files are in src/io/frames/fields.hpp.
#pragma once

#include <cassert>
#include <vector>

#include "trevi/types.hpp"

namespace trevi {

struct Particles {
  std::vector<GlobalId> id;     ///< unique over all ranks, from 0
  std::vector<Vec3> position;   ///< p at the start of the step, m
  std::vector<Vec3> predicted;  ///< p*, m
  std::vector<Vec3> velocity;   ///< v, m/s
  std::vector<float> hue;       ///< initial x as a fraction of the extent of the water; empty unless colour.by needs it
  bool has_hue = false;

  LocalId size() const { return static_cast<LocalId>(id.size()); }

  /// Calls visit(array) for each field that exists.
  template <class Visit>
  void for_each_field(Visit&& visit) {
    for_each_field_of(*this, visit);
  }
  template <class Visit>
  void for_each_field(Visit&& visit) const {
    for_each_field_of(*this, visit);
  }

  /// The same for all fields but the velocities, which have no meaning between the prediction and their update.
  template <class Visit>
  void for_each_kept_field(Visit&& visit) {
    for_each_kept_field_of(*this, visit);
  }

  void resize(std::size_t n) {
    for_each_field([n](auto& field) { field.resize(n); });
  }

 private:
  template <class Self, class Visit>
  static void for_each_kept_field_of(Self& self, Visit&& visit) {
    visit(self.id);
    visit(self.position);
    visit(self.predicted);
    if (self.has_hue) visit(self.hue);
  }
  template <class Self, class Visit>
  static void for_each_field_of(Self& self, Visit&& visit) {
    for_each_kept_field_of(self, visit);
    visit(self.velocity);
  }
};

}  // namespace trevi
