// Frames for ParaView in VTKHDF 1.0: one HDF5 file per frame, DIR/particles_<step>.hdf, written by all ranks together,
// and DIR/particles.hdf.series that lists them with physical time. A frame is an unstructured grid with one vertex per
// particle and one partition per rank that has any; fields as in fields.hpp. With short cells, Offsets and Connectivity
// are int32, and Types, which are all the same, take no space in the file: 8 bytes per particle instead of 17. A frame
// is written under a temporary name and renamed, so the list names only complete frames. Collective. Format: VTK File
// Formats, "VTKHDF"; the list: ParaView's file series, version 1.0.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "io/frames/frame_writer.hpp"
#include "io/hdf5/hdf5_writer.hpp"
#include "trevi/observer.hpp"

namespace trevi {

std::unique_ptr<Observer> make_vtkhdf_writer(MPI_Comm comm, FrameOptions options);

/// A VTKHDF file that is being written: the grid first, then point fields, with one row for each of this rank's points.
class VtkHdfFile {
 public:
  struct Layout {
    bool single_points = false, short_cells = false;
  };
  VtkHdfFile(MPI_Comm comm, const std::string& path, const std::vector<Vec3>& points)
      : VtkHdfFile(comm, path, points, Layout{}) {}
  VtkHdfFile(MPI_Comm comm, const std::string& path, const std::vector<Vec3>& points, Layout layout);

  template <class T>
  void field(const std::string& name, const std::vector<T>& rows) {
    field(name, RowFormatOf<T>::value, rows.data());
  }
  void field(const std::string& name, RowFormat format, const void* rows) {
    file_.write("/VTKHDF/PointData/" + name, format, points_, rows);
  }

  Hdf5Writer& file() { return file_; }  ///< for what VTK does not know
  void close() { file_.close(); }

 private:
  void write_cells(RowSlice partitions, bool is_short);
  template <class Integer>
  void write_numbers(RowSlice partitions);

  Hdf5Writer file_;
  RowSlice points_;
};

}  // namespace trevi
