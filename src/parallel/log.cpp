#include "parallel/log.hpp"

#include <algorithm>

#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr const char* class_name = "Trevi";

PetscClassId class_id() {
  PetscClassId id = 0;
  // Looked up by name instead of kept in a global: PETSc's own registry is the one place that knows.
  PetscBool known = PETSC_FALSE;
  PetscStageLog log = nullptr;
  PetscLogGetStageLog(&log);
  for (int i = 0; log != nullptr && i < log->classLog->numClasses; ++i) {
    PetscStrcmp(log->classLog->classInfo[i].name, class_name, &known);
    if (known) return log->classLog->classInfo[i].classid;
  }
  require(PetscClassIdRegister(class_name, &id) == 0, "PETSc would not register the solver's log class");
  return id;
}

}  // namespace

Event::Event(const std::string& name) {
  // Registering a name twice would give two lines; objects of one kind share their event.
  if (PetscLogEventGetId(name.c_str(), &handle_) == 0 && handle_ >= 0) return;
  require(PetscLogEventRegister(name.c_str(), class_id(), &handle_) == 0, "PETSc would not register event " + name);
}

ScopedStage::ScopedStage(const std::string& name) {
  PetscLogStage stage = -1;
  if (PetscLogStageGetId(name.c_str(), &stage) != 0 || stage < 0) PetscLogStageRegister(name.c_str(), &stage);
  PetscLogStagePush(stage);
}

std::vector<EventTotals> event_totals() {
  PetscStageLog log = nullptr;
  PetscLogGetStageLog(&log);
  std::vector<EventTotals> totals;
  if (log == nullptr) return totals;
  const PetscClassId ours = class_id();
  for (int event = 0; event < log->eventLog->numEvents; ++event) {
    if (log->eventLog->eventInfo[event].classid != ours) continue;
    EventTotals total{log->eventLog->eventInfo[event].name};
    for (int stage = 0; stage < log->numStages; ++stage) {
      PetscEventPerfInfo info{};
      PetscLogEventGetPerfInfo(stage, event, &info);
      total.seconds += info.time;
      total.flops += info.flops;
      total.calls += info.count;
    }
    totals.push_back(std::move(total));
  }
  return totals;
}

}  // namespace trevi
