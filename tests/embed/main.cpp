// Shares a lattice of 1000 particles among the ranks and prints its centre: the same on any number of ranks.
#include <trevi/particles.hpp>
#include <trevi/session.hpp>

#include <cstdio>

int main(int argc, char** argv) {
  const trevi::Session session(argc, argv);
  trevi::Particles water;
  for (trevi::GlobalId id = session.rank(); id < 1000; id += session.size()) {
    water.id.push_back(id);
    water.position.emplace_back(static_cast<double>(id % 10), static_cast<double>(id / 10 % 10),
                                static_cast<double>(id / 100));
  }
  trevi::Vec3 own = trevi::Vec3::Zero(), all;  // whole numbers, so that no order of the sum rounds
  for (const trevi::Vec3& position : water.position) own += position;
  MPI_Allreduce(own.data(), all.data(), 3, MPI_DOUBLE, MPI_SUM, session.comm());
  if (session.rank() == 0) std::printf("centre %g %g %g\n", all.x() / 1000, all.y() / 1000, all.z() / 1000);
}
