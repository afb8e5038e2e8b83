// Frames of cell means in VTKHDF 1.0: an ImageData whose points are the centres of the cells (cell_means.hpp),
// DIR/cells_<step>.hdf, with the requested fields, and DIR/cells.hdf.series that lists them with physical time. Points
// are used because the reader of VTK 9.1 does not read cell data in an ImageData. The same bytes on any rank count.
// Collective.
#pragma once

#include <array>
#include <memory>

#include "io/frames/cell_means.hpp"
#include "io/frames/frame_writer.hpp"

namespace trevi {

inline constexpr std::array<const char*, 3> cell_field_names{"fraction", "velocity", "density"};

/// `fields`: some of these names; options.fields is left empty.
std::unique_ptr<Observer> make_cell_frame_writer(MPI_Comm comm, FrameOptions options, const CoarseCells& cells,
                                                 const std::vector<std::string>& fields, Real particle_volume);

}  // namespace trevi
