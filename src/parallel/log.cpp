#include "parallel/log.hpp"

#include <algorithm>

#include "trevi/error.hpp"

namespace trevi {

namespace {

struct NamedEvent {
  std::string name;
  PetscLogEvent handle;
  double bytes = 0;
};

/// What Trevi has registered with PETSc, which has no public function to list it. Static, because PETSc's own registry
/// is also global to the process.
struct Registry {
  PetscClassId class_id = 0;
  std::vector<NamedEvent> events;
  std::vector<PetscLogStage> stages{0};  ///< PETSc's main stage is always there
};

// Counted from 1, so that it never equals that of a LastingEvent which nobody has asked for.
int& session_number() {
  static int number = 1;
  return number;
}

Registry& registry() {
  static Registry the_one;
  return the_one;
}

PetscLogEvent register_event(Registry& known, const std::string& name) {
  if (known.class_id == 0) {
    require(PetscClassIdRegister("Trevi", &known.class_id) == 0, "PETSc would not register the solver's log class");
  }
  PetscLogEvent handle = 0;
  require(PetscLogEventRegister(name.c_str(), known.class_id, &handle) == 0, "PETSc would not register event " + name);
  known.events.push_back({name, handle, 0});
  return handle;
}

}  // namespace

Event::Event(const std::string& name) {
  // Registering a name twice would give two lines; objects of one type share their event.
  Registry& known = registry();
  const auto found = std::find_if(known.events.begin(), known.events.end(),
                                  [&](const NamedEvent& event) { return event.name == name; });
  handle_ = found != known.events.end() ? found->handle : register_event(known, name);
}

const Event& LastingEvent::operator()() {
  if (session_ != session_number()) {
    event_.emplace(name_);
    session_ = session_number();
  }
  return *event_;
}

ScopedStage::ScopedStage(const std::string& name) {
  PetscLogStage stage = -1;
  if (PetscLogStageGetId(name.c_str(), &stage) != 0 || stage < 0) {
    require(PetscLogStageRegister(name.c_str(), &stage) == 0, "PETSc would not register stage " + name);
    registry().stages.push_back(stage);
  }
  PetscLogStagePush(stage);
}

void log_work(const Event& event, double flops, double bytes) {
  PetscLogFlops(flops);
  for (NamedEvent& known : registry().events) {
    if (known.handle == event.handle()) known.bytes += bytes;
  }
}

void forget_events() {
  registry() = {};
  ++session_number();
}

namespace {

EventTotals totals_of(const NamedEvent& event) {
  EventTotals total{event.name};
  total.bytes = event.bytes;
  for (const PetscLogStage stage : registry().stages) {
    PetscEventPerfInfo info{};
    PetscLogEventGetPerfInfo(stage, event.handle, &info);
    total.seconds += info.time;
    total.flops += info.flops;
    total.calls += info.count;
  }
  return total;
}

}  // namespace

std::vector<EventTotals> event_totals() {
  std::vector<EventTotals> totals;
  for (const NamedEvent& event : registry().events) totals.push_back(totals_of(event));
  return totals;
}

double event_seconds(const std::string& name) {
  for (const NamedEvent& event : registry().events) {
    if (event.name == name) return totals_of(event).seconds;
  }
  return 0;
}

}  // namespace trevi
