// Where obstacles and bodies are, and what the water does to them.
#include <fmt/format.h>

#include "boundary/geometry/pose.hpp"
#include "boundary/rigid_bodies/rigid_body.hpp"
#include "solver.hpp"

namespace trevi::python {

namespace {

// The last row of three columns, or None without rows.
py::object last(const Table& rows, const char* name, std::size_t number) {
  Vec3 value;
  for (Eigen::Index a = 0; a < 3; ++a) {
    const auto column = rows.find(fmt::format("{}_{}_{}", name, "xyz"[a], number));
    if (column == rows.end() || column->second.empty()) return py::none();
    value[a] = column->second.back();
  }
  return py::cast(value);
}

}  // namespace

py::dict as_arrays(const Table& table) {
  py::dict arrays;
  for (const auto& [name, values] : table)
    arrays[name.c_str()] = py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
  return arrays;
}

py::list obstacles_of(const PySolver& self) {
  py::list list;
  for (std::size_t k = 0; k < self.settings().obstacles.size(); ++k) {
    const Pose pose = BodyMotion(self.settings().obstacles[k]).at(self.get().clock().time());
    py::dict one;
    one["center"] = pose.center;
    one["rotation"] = pose.turn;
    one["force"] = last(self.record().obstacles, "force", k);
    one["torque"] = last(self.record().obstacles, "torque", k);
    list.append(one);
  }
  return list;
}

py::list bodies_of(const PySolver& self) {
  py::list list;
  const std::vector<BodyState> bodies = self.get().bodies();
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const BodyState& body = bodies[k];
    py::dict one;
    one["position"] = body.position;
    one["orientation"] = py::array_t<double>(4, body.orientation.data());
    one["rotation"] = rotation_of(body.orientation);
    one["velocity"] = body.velocity;
    one["angular_velocity"] = body.angular_velocity;
    one["force"] = last(self.record().bodies, "force", k);
    one["torque"] = last(self.record().bodies, "torque", k);
    list.append(one);
  }
  return list;
}

}  // namespace trevi::python
