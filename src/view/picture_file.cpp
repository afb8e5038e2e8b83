#include "view/picture_file.hpp"

#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkRenderWindow.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include "io/run_directory/files.hpp"

namespace trevi {

void write_picture(vtkRenderWindow* window, const std::string& path) {
  vtkNew<vtkWindowToImageFilter> shot;
  shot->SetInput(window);
  shot->ReadFrontBufferOff();
  shot->ShouldRerenderOff();
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(shot->GetOutputPort());
  // Through memory, because VTK would only print that a disk is full.
  writer->WriteToMemoryOn();
  writer->Write();
  const vtkUnsignedCharArray* bytes = writer->GetResult();
  const auto size = static_cast<std::size_t>(writer->GetResult()->GetNumberOfValues());
  replace_file(path, {reinterpret_cast<const char*>(const_cast<vtkUnsignedCharArray*>(bytes)->GetPointer(0)), size});
}

}  // namespace trevi
