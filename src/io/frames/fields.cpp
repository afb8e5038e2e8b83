#include "io/frames/fields.hpp"

#include <algorithm>

#include "base/threads.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

template <class T>
constexpr RowFormat format_of = RowFormatOf<T>::value;

template <class T>
Rows lent(const std::vector<T>& rows) {
  return {Rows(), rows.data()};
}

template <class T>
Rows made(std::vector<T> rows) {
  const auto kept = std::make_shared<const std::vector<T>>(std::move(rows));
  return {kept, kept->data()};
}

using Floats3 = std::array<float, 3>;

Rows velocities(const FieldSource& source) {
  const std::vector<Vec3>& exact = source.frame.particles.velocity;
  std::vector<Floats3> rows(exact.size());
  for_each_index({0, static_cast<LocalId>(rows.size())}, [to = rows.data(), from = exact.data()](std::size_t i) {
    for (const int a : {0, 1, 2}) to[i][static_cast<std::size_t>(a)] = static_cast<float>(from[i][a]);
  });
  return made(std::move(rows));
}

Rows densities(const FieldSource& source) {
  const auto exact = source.frame.density;
  require(exact.size() == source.frame.particles.id.size(), "no density was computed for this frame");
  std::vector<float> rows(exact.size());
  for_each_index({0, static_cast<LocalId>(rows.size())},
                 [to = rows.data(), from = exact.data()](std::size_t i) { to[i] = static_cast<float>(from[i]); });
  return made(std::move(rows));
}

Rows ids(const FieldSource& source) { return lent(source.frame.particles.id); }

Rows ranks(const FieldSource& source) {
  return made(std::vector<std::int32_t>(source.frame.particles.id.size(), source.rank));
}

Rows colours(const FieldSource& source) { return made(colours_of(source.colour, source.frame.particles)); }

}  // namespace

const std::array<OutputField, 7> output_fields = {{
    {"position", format_of<Vec3>, nullptr, FieldNeeds::nothing, &Particles::position},  // of frames: the points
    {"velocity", format_of<Floats3>, velocities, FieldNeeds::nothing, &Particles::velocity},
    {"hue", format_of<float>, nullptr, FieldNeeds::nothing, &Particles::hue, &Particles::has_hue},
    {"density", format_of<float>, densities, FieldNeeds::density},
    {"id", format_of<GlobalId>, ids},
    {"rank", format_of<std::int32_t>, ranks},
    {"rgb", format_of<Rgb>, colours, FieldNeeds::colour},
}};

std::vector<const OutputField*> frame_fields() {
  std::vector<const OutputField*> fields;
  for (const OutputField& field : output_fields) {
    if (field.rows != nullptr) fields.push_back(&field);
  }
  return fields;
}

std::vector<const OutputField*> frame_fields(const std::vector<std::string>& names) {
  std::vector<const OutputField*> fields = frame_fields();
  const auto is = [](const std::string& name) {
    return [&name](const OutputField* field) { return name == field->name; };
  };
  for (const std::string& name : names) {
    if (std::none_of(fields.begin(), fields.end(), is(name))) throw InputError("unknown output field \"" + name + "\"");
  }
  std::erase_if(fields, [&](const OutputField* field) {
    return std::find(names.begin(), names.end(), field->name) == names.end();
  });
  return fields;
}

}  // namespace trevi
