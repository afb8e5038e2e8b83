#include "io/frames/blowup.hpp"

#include <filesystem>
#include <system_error>

#include "io/frames/vtkhdf.hpp"
#include "io/run_directory/files.hpp"
#include "parallel/collective.hpp"

namespace trevi {

namespace fs = std::filesystem;

std::string write_blowup(MPI_Comm comm, const std::string& directory, const BlowUpState& state) {
  const std::string path = directory + "/blowup_" + step_digits(state.step) + ".h5";
  const Particles& particles = state.particles;
  VtkHdfFile file(comm, path, particles.position);
  file.field("id", particles.id);
  file.field("velocity", particles.velocity);
  file.field("predicted", particles.predicted);
  file.field("rank", std::vector<std::int32_t>(particles.id.size(), rank_of(comm)));
  for (const char* name : {"id", "velocity", "predicted"}) {
    file.file().link(std::string("/VTKHDF/PointData/") + name, std::string("/particles/") + name);
  }
  file.file().link("/VTKHDF/Points", "/particles/position");
  file.file().attribute("step", state.step);
  file.file().attribute("message", state.message);
  file.close();
  on_root(comm, [&] {
    const fs::path link = fs::path(path).replace_extension(".hdf");
    std::error_code ignored;  // file systems without links: the file can be renamed by hand
    fs::remove(link, ignored);
    fs::create_symlink(fs::path(path).filename(), link, ignored);
  });
  return path;
}

}  // namespace trevi
