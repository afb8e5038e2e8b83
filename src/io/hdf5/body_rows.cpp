#include "io/hdf5/body_rows.hpp"

#include <algorithm>
#include <cmath>

#include "base/damaged_file.hpp"

namespace trevi {

namespace {

template <class State, class Visit>
void for_each_number(State& body, const Visit& visit) {
  const auto all = [&](auto& several) {
    for (auto& number : several) visit(number);
  };
  all(body.position), all(body.orientation), all(body.momentum), all(body.angular_momentum), all(body.velocity);
  all(body.angular_velocity), all(body.last_twist), all(body.last_force), all(body.added_mass);
}

constexpr std::int64_t numbers_of_body = 3 + 4 + 3 + 3 + 3 + 3 + 6 + 6 + 36;

}  // namespace

std::vector<Real> numbers_of(std::span<const BodyState> bodies) {
  std::vector<Real> rows;
  for (const BodyState& body : bodies) for_each_number(body, [&](Real number) { rows.push_back(number); });
  return rows;
}

std::vector<BodyState> bodies_of(const std::string& path, const Hdf5Reader& file) {
  const std::int64_t total = file.rows<Real>("/bodies");
  const auto rows = file.read<Real>("/bodies", {0, total, total});
  if (total % numbers_of_body != 0 ||
      !std::all_of(rows.begin(), rows.end(), [](Real number) { return std::isfinite(number); }))
    throw DamagedFile(path + ": /bodies: cannot be the state of bodies; use another checkpoint");
  std::vector<BodyState> bodies(static_cast<std::size_t>(total / numbers_of_body));
  auto next = rows.begin();
  for (BodyState& body : bodies) for_each_number(body, [&](Real& number) { number = *next++; });
  return bodies;
}

}  // namespace trevi
