#include "io/frames/cell_frames.hpp"

#include <algorithm>
#include <cstdio>

#include "io/hdf5/hdf5_writer.hpp"
#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

class CellFrameWriter : public FrameWriter {
 public:
  CellFrameWriter(MPI_Comm comm, FrameOptions options, const CoarseCells& cells, std::vector<std::string> names,
                  Real particle_volume)
      : FrameWriter(comm, std::move(options), {"CellFrames", cell_list, "", {cell_frames}}),
        cells_(cells),
        names_(std::move(names)),
        particle_volume_(particle_volume) {}

  bool wants_density() const override { return has("density"); }

 private:
  bool has(const char* name) const { return std::find(names_.begin(), names_.end(), name) != names_.end(); }

  void write(const Frame& frame, const std::string& path) override {
    const CellMeans means = cell_means(comm(), cells_, particle_volume_, frame);
    const std::string temporary = path + ".tmp";
    try {
      Hdf5Writer file(comm(), temporary);
      write_grid(file);
      write_field(file, "fraction", means.slice, means.fraction);
      write_field(file, "velocity", means.slice, means.velocity);
      write_field(file, "density", means.slice, means.density);
      file.close();
    } catch (const Error&) {  // thrown by all ranks alike
      if (rank_of(comm()) == 0) std::remove(temporary.c_str());
      throw;
    }
    on_root(comm(), [&] { publish_file(temporary, path); });
  }

  void write_grid(Hdf5Writer& file) const {
    const std::int64_t version[] = {1, 0};
    const auto& [x, y, z] = cells_.count();
    const std::int64_t extent[] = {0, x - 1, 0, y - 1, 0, z - 1};
    const Real axes[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    file.attribute("/VTKHDF/Version", std::span<const std::int64_t>(version));
    file.attribute("/VTKHDF/Type", std::string("ImageData"));
    file.attribute("/VTKHDF/WholeExtent", std::span<const std::int64_t>(extent));
    file.attribute("/VTKHDF/Origin", std::span<const Real>(cells_.origin().data(), 3));
    file.attribute("/VTKHDF/Spacing", std::span<const Real>(cells_.size().data(), 3));
    file.attribute("/VTKHDF/Direction", std::span<const Real>(axes));
  }

  template <class T>
  void write_field(Hdf5Writer& file, const char* name, RowSlice slice, const std::vector<T>& rows) const {
    if (!has(name)) return;
    const auto& [x, y, z] = cells_.count();
    file.write_grid(std::string("/VTKHDF/PointData/") + name, RowFormatOf<T>::value, {{z, y, x}, slice, rows.data()});
  }

  CoarseCells cells_;
  std::vector<std::string> names_;
  Real particle_volume_;
};

}  // namespace

std::unique_ptr<Observer> make_cell_frame_writer(MPI_Comm comm, FrameOptions options, const CoarseCells& cells,
                                                 const std::vector<std::string>& fields, Real particle_volume) {
  options.fields.clear();
  return std::make_unique<CellFrameWriter>(comm, std::move(options), cells, fields, particle_volume);
}

}  // namespace trevi
