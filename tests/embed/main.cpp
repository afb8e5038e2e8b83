// Trevi inside another program: water in a tank, blown aside by a wind of the program's own, with a drop added halfway.
// Prints the same on any number of ranks.
#include <trevi/solver.hpp>

#include <cstdio>

struct Wind : trevi::Forcing {
  void apply(trevi::Particles& water, const trevi::StepInfo& info) override {
    for (trevi::Vec3& v : water.velocity) v.x() += 3 * info.dt;
  }
};

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  {
    const trevi::Session session(MPI_COMM_WORLD);
    trevi::Settings settings;
    settings.domain = {trevi::Vec3(0, 0, 0), trevi::Vec3(2, 1, 1.5)};  // m
    settings.gravity = trevi::Vec3(0, 0, -9.81);
    trevi::Particles water;  // each rank brings what it likes; the solver sends it to where it belongs
    for (int n = session.rank(); n < 20 * 10 * 5; n += session.size()) {
      water.id.push_back(n);
      water.position.push_back(settings.fluid.spacing * trevi::Vec3(n % 20 + 0.5, n / 20 % 10 + 0.5, n / 200 + 0.5));
      water.velocity.push_back(trevi::Vec3::Zero());
    }
    trevi::SolverExtras extras;
    extras.forcings.push_back(std::make_unique<Wind>());
    const auto solver = trevi::make_solver(session.comm(), settings, std::move(water), std::move(extras));
    for (int step = 0; step < 30; ++step) solver->step();
    solver->change_particles([&](trevi::Particles& particles) {
      if (session.rank() != 0) return;
      particles.id.push_back(1000);
      particles.position.emplace_back(1, 0.5, 1.4);
      particles.velocity.emplace_back(0, 0, -5);
    });
    for (int step = 0; step < 30; ++step) solver->step();
    double top = 0;
    for (const trevi::Vec3& p : solver->particles().position) top = std::max(top, p.z());
    MPI_Allreduce(MPI_IN_PLACE, &top, 1, MPI_DOUBLE, MPI_MAX, session.comm());
    if (session.rank() == 0) std::printf("t = %g s, highest particle at %.15g m\n", solver->clock().time(), top);
  }
  MPI_Finalize();
}
