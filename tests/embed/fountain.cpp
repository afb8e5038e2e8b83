// All that a scene file can say, said by a program: the scene of fountain.toml, with its bits and its files. The folder
// for these is the argument.
#include <trevi/solver.hpp>

trevi::Settings settings(const char* folder) {
  using trevi::Vec3;
  trevi::Settings all;
  all.domain = {Vec3(0, 0, 0), Vec3(1.6, 0.8, 1.6)};  // m
  all.dt = 0.0166666667;                              // s
  all.gravity = Vec3(0, 0, -9.8);
  trevi::FountainSettings& fountain = all.fountains.emplace_back();
  fountain.center[0] = fountain.center[1] = 0.4;
  fountain.diameter = 0.3;
  fountain.height = 0.4;
  fountain.direction = Vec3(1, 0, 3);
  fountain.speed = 2;  // m/s
  fountain.jitter = 0.5;
  trevi::InletSettings& inlet = all.inlets.emplace_back();
  inlet.center = Vec3(1.0, 0.4, 1.4);
  inlet.direction = Vec3(1, 0.2, -0.5);
  inlet.radius = 0.15;
  inlet.flow = 0.1;  // m³/s
  trevi::DrainSettings& drain = all.drains.emplace_back();
  drain.min = Vec3(1.2, 0, 0);
  drain.max = Vec3(1.6, 0.8, 0.1);
  all.output.directory = folder;
  all.output.series = trevi::Schedule{.every_steps = 5};
  all.output.checkpoint = trevi::CheckpointSettings{.keep = 1};
  all.seed = 12;
  return all;
}

int main(int argc, char** argv) {
  const trevi::Mpi mpi(argc, argv);
  const trevi::Session session(MPI_COMM_WORLD);
  const trevi::Settings all = settings(argc > 1 ? argv[1] : "out/fountain");
  trevi::Particles water;
  for (int n = session.rank(); n < 16 * 8 * 5; n += session.size()) {
    water.id.push_back(n);
    water.position.push_back(all.fluid.spacing * trevi::Vec3(n % 16 + 0.5, n / 16 % 8 + 0.5, n / 128 + 0.5));
    water.velocity.push_back(trevi::Vec3::Zero());
  }
  const auto solver = trevi::make_solver(session.comm(), all, std::move(water));
  solver->start();
  while (solver->clock().step < 30) solver->step();
  solver->finish();
}
