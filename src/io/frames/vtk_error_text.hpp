// Keeps what VTK would print as an error, for a message of our own. Observes ErrorEvent of VTK's readers and writers.
// Rank-local. Only for source files that use VTK.
#pragma once

#include <vtkCommand.h>

#include <string>

namespace trevi {

class VtkErrorText : public vtkCommand {
 public:
  static VtkErrorText* New() { return new VtkErrorText; }
  void Execute(vtkObject*, unsigned long, void* data) override {
    // The first error is the cause; later ones only pass it on.
    if (data != nullptr && text_.empty()) text_ = static_cast<const char*>(data);
    if (text_.empty()) text_ = "no reason given";
  }
  bool empty() const { return text_.empty(); }
  /// Its first line, without the place in VTK where it occurred.
  std::string text() const {
    const std::size_t from = text_.find("): ");
    const std::string line = from == std::string::npos ? text_ : text_.substr(from + 3);
    return line.substr(0, line.find('\n'));
  }

 private:
  std::string text_;
};

}  // namespace trevi
