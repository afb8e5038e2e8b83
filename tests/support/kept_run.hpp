// A run that keeps what the solver reports of each step.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "trevi/observer.hpp"
#include "trevi/scene.hpp"
#include "trevi/solver.hpp"

namespace trevi::test {

struct Keeper : Observer {
  std::vector<Diagnostics>& rows;
  std::vector<std::vector<BodyForce>>& forces;
  bool wants;
  Keeper(std::vector<Diagnostics>& r, std::vector<std::vector<BodyForce>>& f, bool w) : rows(r), forces(f), wants(w) {}
  bool due(const Clock&) const override { return true; }
  bool wants_diagnostics() const override { return true; }
  bool wants_forces() const override { return wants; }
  void observe(const Frame& frame) override {
    rows.push_back(*frame.diagnostics);
    forces.emplace_back(frame.forces.begin(), frame.forces.end());
  }
};

/// Not to be moved: its solver refers to it.
struct KeptRun {
  Scene scene;
  std::vector<Diagnostics> rows;
  std::vector<std::vector<BodyForce>> forces;  ///< none without obstacles
  std::unique_ptr<Solver> solver;

  KeptRun(MPI_Comm comm, const Scene& of) : KeptRun(comm, of, initial_particles(comm, of)) {}
  /// From other particles than those of the scene.
  KeptRun(MPI_Comm comm, Scene of, Particles water) : scene(std::move(of)) {
    SolverExtras extras;
    extras.observers.push_back(std::make_unique<Keeper>(rows, forces, has_solids(scene)));
    solver = make_solver(comm, scene, std::move(water), std::move(extras));
    solver->start();
  }
  KeptRun(const KeptRun&) = delete;
  void steps(int count) {
    for (int k = 0; k < count; ++k) solver->step();
  }
};

}  // namespace trevi::test
