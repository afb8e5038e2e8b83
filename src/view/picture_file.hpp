// The content of a window as a PNG file.
#pragma once

#include <string>

class vtkRenderWindow;

namespace trevi {

/// RunError if it cannot be written.
void write_picture(vtkRenderWindow* window, const std::string& path);

}  // namespace trevi
