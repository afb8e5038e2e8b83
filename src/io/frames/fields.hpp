// The output fields: the single list used by the scene reader, the frames (VTU, VTKHDF) and the checkpoints, so that a
// new field is one entry. Invariant: a field means the same in all formats, and files hold fields in the order of the
// list. Rank-local, but all ranks ask for the same rows, because colours are logged.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "io/frames/colour.hpp"
#include "io/hdf5/hdf5_rows.hpp"
#include "trevi/observer.hpp"

namespace trevi {

/// What the rows of a frame are made from.
struct FieldSource {
  const Frame& frame;
  const ColourScale& colour;
  int rank;
};

/// One row for each particle of this rank, computed on request or borrowed from the frame, which they must not outlive.
using Rows = std::shared_ptr<const void>;

enum class FieldNeeds { nothing, density, colour };

struct OutputField {
  /// The member of the particles' state, for checkpoints; nothing for fields that follow from the state.
  using Saved = std::variant<std::monostate, std::vector<Vec3> Particles::*, std::vector<float> Particles::*>;

  const char* name;
  RowFormat format;                        ///< in frames
  Rows (*rows)(const FieldSource&);        ///< of a frame; null: not a field of frames
  FieldNeeds needs = FieldNeeds::nothing;  ///< what a frame must have for it
  Saved saved = {};
  bool Particles::*when = nullptr;  ///< whether particles have it; null: all have
};

extern const std::array<OutputField, 7> output_fields;

/// The fields that frames can have.
std::vector<const OutputField*> frame_fields();

/// Those of `names` in the order of the list. InputError for an unknown name.
std::vector<const OutputField*> frame_fields(const std::vector<std::string>& names);

/// Calls visit(name, array) for each field that a checkpoint holds of these particles, except for the ids, by which it
/// sorts.
template <class State, class Visit>
void for_each_saved_field(State& particles, Visit&& visit) {
  for (const OutputField& field : output_fields) {
    const auto visit_member = [&](auto member) {
      if constexpr (!std::is_same_v<decltype(member), std::monostate>) visit(field.name, particles.*member);
    };
    if (field.when == nullptr || particles.*field.when) std::visit(visit_member, field.saved);
  }
}

}  // namespace trevi
