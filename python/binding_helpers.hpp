// How members of settings become attributes.
#pragma once

#include <fmt/format.h>

#include "bindings.hpp"
#include "trevi/error.hpp"

namespace trevi::python {

// A setting that follows from others where it is None.
template <class Class, class Owner, class Value>
void derived(Class& made, const char* name, Derived<Value> Owner::*member, const char* doc) {
  made.def_property(
      name,
      [member](const Owner& owner) {
        const Derived<Value>& setting = owner.*member;
        return setting.given() ? std::optional<Value>(setting.value()) : std::nullopt;
      },
      [member](Owner& owner, const std::optional<Value>& value) {
        owner.*member = value ? Derived<Value>(*value) : Derived<Value>();
      },
      doc);
}

// A misspelt name would otherwise be an attribute of its own, without a word.
template <class Class>
void closed(Class& made) {
  made.def("__setattr__", [](const py::object& self, const py::str& name, const py::object& value) {
    if (!py::hasattr(py::type::of(self), name))
      throw py::attribute_error(fmt::format("{} has no setting {}; see help()",
                                            py::str(py::type::of(self).attr("__name__")).cast<std::string>(),
                                            name.cast<std::string>()));
    py::module_::import("builtins").attr("object").attr("__setattr__")(self, name, value);
  });
}

// A vector that may be changed in place, by settings.domain.max[2] = 3.
template <class Owner>
py::cpp_function in_place(Vec3 Owner::*member) {
  return {[member](Owner& owner) -> Vec3& { return owner.*member; }, py::return_value_policy::reference_internal};
}
template <class Owner>
py::cpp_function assigned(Vec3 Owner::*member) {
  return [member](Owner& owner, const Vec3& value) { owner.*member = value; };
}

}  // namespace trevi::python
