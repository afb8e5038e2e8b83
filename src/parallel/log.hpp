// Phases and kernels as PETSc stages and events, so that -log_view and run.json show the time of each part of the
// method. An event is registered when the object that needs it is built, so the log has no lines for what a scene does
// not use. Not collective, but all ranks must register the same events in the same order, as make_solver() does.
#pragma once

#include <petsclog.h>

#include <optional>
#include <string>
#include <vector>

namespace trevi {

class Event {
 public:
  explicit Event(const std::string& name);
  PetscLogEvent handle() const { return handle_; }

 private:
  PetscLogEvent handle_ = 0;
};

/// An event that outlives sessions, for code without an object: registered where a session first asks for it.
class LastingEvent {
 public:
  explicit LastingEvent(const char* name) : name_(name) {}
  const Event& operator()();

 private:
  const char* name_;
  std::optional<Event> event_;
  int session_ = 0;
};

/// Times the scope in which it exists.
class ScopedEvent {
 public:
  explicit ScopedEvent(const Event& event) : handle_(event.handle()) { PetscLogEventBegin(handle_, 0, 0, 0, 0); }
  ~ScopedEvent() { PetscLogEventEnd(handle_, 0, 0, 0, 0); }
  ScopedEvent(const ScopedEvent&) = delete;
  ScopedEvent& operator=(const ScopedEvent&) = delete;

 private:
  PetscLogEvent handle_;
};

/// A stage of -log_view: everything logged in its scope is listed under its name.
class ScopedStage {
 public:
  explicit ScopedStage(const std::string& name);
  ~ScopedStage() { PetscLogStagePop(); }
  ScopedStage(const ScopedStage&) = delete;
  ScopedStage& operator=(const ScopedStage&) = delete;
};

/// Work of the event being timed: floating-point operations, and bytes that it reads or writes, each array counted
/// once.
void log_work(const Event& event, double flops, double bytes);

/// Time and work of one event on this rank, all stages together.
struct EventTotals {
  std::string name;
  double seconds = 0, flops = 0, bytes = 0;
  long calls = 0;
};

/// To be called at the end of a session, when PETSc discards its log; the next session registers events again.
void forget_events();

/// Totals of all events of the solver, in order of registration.
std::vector<EventTotals> event_totals();

/// Time of the event of that name on this rank so far; 0 if there is none.
double event_seconds(const std::string& name);

}  // namespace trevi
