// An output field: the speed of each particle, m/s. `speed_field` is the entry of the list output_fields; scenes, VTU
// and VTKHDF go by that list.
#pragma once

#include "io/frames/fields.hpp"

namespace trevi {

inline Rows speeds(const FieldSource& source) {
  const auto rows = std::make_shared<std::vector<float>>();
  for (const Vec3& v : source.frame.particles.velocity) rows->push_back(static_cast<float>(v.norm()));
  return {rows, rows->data()};
}

inline const OutputField speed_field{"speed", RowFormatOf<float>::value, speeds};

}  // namespace trevi
