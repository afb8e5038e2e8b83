#include "parallel/log.hpp"

#include <algorithm>

#include "trevi/error.hpp"

namespace trevi {

namespace {

struct NamedEvent {
  std::string name;
  PetscLogEvent handle;
};

/// What Trevi has registered with PETSc, which has no public function to list it. Static, as PETSc's own registry is
/// global to the process, too.
struct Registry {
  PetscClassId class_id = 0;
  std::vector<NamedEvent> events;
  std::vector<PetscLogStage> stages{0};  ///< PETSc's main stage is always there
};

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
  known.events.push_back({name, handle});
  return handle;
}

}  // namespace

Event::Event(const std::string& name) {
  // Registering a name twice would give two lines; objects of one kind share their event.
  Registry& known = registry();
  const auto found = std::find_if(known.events.begin(), known.events.end(),
                                  [&](const NamedEvent& event) { return event.name == name; });
  handle_ = found != known.events.end() ? found->handle : register_event(known, name);
}

ScopedStage::ScopedStage(const std::string& name) {
  PetscLogStage stage = -1;
  if (PetscLogStageGetId(name.c_str(), &stage) != 0 || stage < 0) {
    require(PetscLogStageRegister(name.c_str(), &stage) == 0, "PETSc would not register stage " + name);
    registry().stages.push_back(stage);
  }
  PetscLogStagePush(stage);
}

void forget_events() { registry() = {}; }

std::vector<EventTotals> event_totals() {
  std::vector<EventTotals> totals;
  for (const NamedEvent& event : registry().events) {
    EventTotals total{event.name};
    for (const PetscLogStage stage : registry().stages) {
      PetscEventPerfInfo info{};
      PetscLogEventGetPerfInfo(stage, event.handle, &info);
      total.seconds += info.time;
      total.flops += info.flops;
      total.calls += info.count;
    }
    totals.push_back(std::move(total));
  }
  return totals;
}

}  // namespace trevi
