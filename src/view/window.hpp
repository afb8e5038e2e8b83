// The window: advances a source with a timer, paints what is new, responds to keys. Draws only when something has
// changed, so a paused picture takes no processor time.
#pragma once

#include <vtkNew.h>

#include <chrono>

#include "view/frame_source.hpp"
#include "view/music_player.hpp"
#include "view/options.hpp"

class vtkRenderer;
class vtkRenderWindow;
class vtkRenderWindowInteractor;
class vtkTextActor;

namespace trevi {

/// InputError if there is no screen to draw on; VTK would end the program.
void require_screen();

class Window {
 public:
  /// InputError if there is no screen to open a window on.
  Window(FrameSource& source, const ViewOptions& options);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Runs until the user closes the window.
  void run(MusicPlayer& music);

  /// Paints the current frame and writes it as PNG. RunError if the file cannot be written.
  void save(const std::string& path);
  /// Turns the camera once around every few seconds; returns pictures per second.
  double benchmark(double seconds);

  void press(const std::string& key);
  void tick();
  /// Takes the frame and state of the source into the picture.
  void paint();
  void render();

 private:
  using Instant = std::chrono::steady_clock::time_point;
  bool press_steering(const std::string& key);
  bool press_looks(const std::string& key);
  void update_texts();
  void update_title();
  void save_numbered();
  void measure();

  FrameSource& source_;
  ViewOptions options_;
  vtkNew<vtkRenderer> renderer_;
  vtkNew<vtkRenderWindow> window_;
  vtkNew<vtkRenderWindowInteractor> interactor_;
  vtkNew<vtkTextActor> status_, message_, help_;
  Painter painter_;
  MusicPlayer* music_ = nullptr;
  std::shared_ptr<const ViewedFrame> shown_;
  std::string scene_name_, note_;  ///< note_: for the user, until the next
  bool dirty_ = true;
  Instant last_tick_, last_picture_;
  double interval_ = 0;  ///< s from picture to picture, smoothed
};

}  // namespace trevi
