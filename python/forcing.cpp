// Callables as forcings, and what they see of the particles.
#include <algorithm>
#include <cmath>

#include "base/simd.hpp"
#include "solver.hpp"
#include "trevi/error.hpp"

namespace trevi::python {

namespace {

/// An array of the solver that Python has during a call. Where a view of it is kept its memory stays with the view, and
/// the solver goes on with a copy.
template <class Row>
class Loan {
 public:
  explicit Loan(std::vector<Row>& rows) : rows_(&rows) {}
  Loan(const Loan&) = delete;
  Loan& operator=(const Loan&) = delete;

  std::size_t size() const { return owner_ ? lent_->size() : rows_->size(); }

  py::array array(bool writable) {
    if (!owner_) {
      lent_ = new std::vector<Row>(std::move(*rows_));
      owner_ = py::capsule(lent_, [](void* lent) { delete static_cast<std::vector<Row>*>(lent); });
      array_ = view_of(*lent_, owner_, writable);
    }
    return array_;
  }
  void replace(const std::vector<Row>& rows) {
    std::copy(rows.begin(), rows.end(), owner_ ? lent_->begin() : rows_->begin());
  }
  void end() {
    if (!owner_) return;
    array_.attr("flags").attr("writeable") = false;
    array_ = {};
    if (owner_.ref_count() == 1)
      *rows_ = std::move(*lent_);
    else
      *rows_ = *lent_;
    owner_ = {};
  }

 private:
  std::vector<Row>* rows_;
  std::vector<Row>* lent_ = nullptr;  ///< of the owner
  py::object owner_;                  ///< of the memory, where it is lent
  py::array array_;
};

/// What a callable sees of the particles: valid during the call.
class Water {
 public:
  explicit Water(Particles& particles)
      : positions_(particles.position), velocities_(particles.velocity), ids_(particles.id) {}

  py::array positions() { return valid(positions_).array(true); }
  py::array velocities() { return valid(velocities_).array(true); }
  py::array ids() { return valid(ids_).array(false); }
  void set_velocities(const py::object& given) {
    const std::vector<Vec3> rows = rows_of(given, "velocities");
    if (rows.size() != valid(velocities_).size()) throw InputError("velocities: must have a row for each particle");
    velocities_.replace(rows);
  }
  void end() {
    is_valid_ = false;
    positions_.end();
    velocities_.end();
    ids_.end();
  }

 private:
  template <class Row>
  Loan<Row>& valid(Loan<Row>& loan) const {
    if (!is_valid_) throw RunError("water is valid during the call of a forcing only; copy there what is to be kept");
    return loan;
  }

  bool is_valid_ = true;
  Loan<Vec3> positions_, velocities_;
  Loan<GlobalId> ids_;
};

class OwnForcing : public Forcing {
 public:
  OwnForcing(py::function call, Real fastest) : call_(std::move(call)), fastest_(fastest) {}
  void apply(Particles& particles, const StepInfo& step) override {
    const Denormals denormals(false);  // numpy counts as it does elsewhere
    const auto water = std::make_shared<Water>(particles);
    const auto end = [](Water* one) { one->end(); };
    const std::unique_ptr<Water, decltype(end)> lent(water.get(), end);
    call_(water, step);
  }
  Real fastest(const TimeSpan&) const override { return fastest_; }

 private:
  py::function call_;
  Real fastest_;
};

Real fastest_of(const py::handle& call) {
  if (!py::hasattr(call, "fastest")) return 0;
  Real fastest = -1;
  try {
    fastest = call.attr("fastest").cast<Real>();
  } catch (const py::cast_error&) {  // told below
  }
  if (!std::isfinite(fastest) || fastest < 0)
    throw InputError("forcings: the attribute fastest of a forcing must be a number from 0 on, m/s");
  return fastest;
}

}  // namespace

std::vector<std::unique_ptr<Forcing>> forcings_of(const py::object& calls) {
  const char* const wanted = "forcings: must be a list of callables f(water, step)";
  if (!py::isinstance<py::iterable>(calls)) throw InputError(wanted);
  std::vector<std::unique_ptr<Forcing>> forcings;
  for (const py::handle& call : calls) {
    if (PyCallable_Check(call.ptr()) == 0) throw InputError(wanted);
    forcings.push_back(std::make_unique<OwnForcing>(py::reinterpret_borrow<py::function>(call), fastest_of(call)));
  }
  return forcings;
}

void bind_forcing(py::module_& m) {
  py::class_<StepInfo>(m, "StepInfo", "The part of a step that is about to be made.")
      .def_readonly("step", &StepInfo::step, "steps done before")
      .def_readonly("substep", &StepInfo::substep)
      .def_readonly("time", &StepInfo::time, "at its start, s")
      .def_readonly("dt", &StepInfo::dt, "its length, s");

  py::class_<Water, std::shared_ptr<Water>>(m, "Water",
                                            "This rank's particles as a forcing sees them, valid during the call. "
                                            "Arrays that are kept are read-only, and no longer the solver's.")
      .def_property_readonly("positions", &Water::positions, "(n, 3), m")
      .def_property("velocities", &Water::velocities, &Water::set_velocities, "(n, 3), m/s; to be changed")
      .def_property_readonly("ids", &Water::ids);
}

}  // namespace trevi::python
