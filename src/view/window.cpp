#include "view/window.hpp"

#include <X11/Xlib.h>
#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <filesystem>

#include "trevi/error.hpp"
#include "view/picture_file.hpp"
#include "view/status.hpp"

namespace trevi {

namespace {

using WallClock = std::chrono::steady_clock;

constexpr int tick_milliseconds = 10;

double seconds_between(WallClock::time_point from, WallClock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

/// VTK's own keys (wireframe, picking, stereo, ...) would interfere with ours.
class TrackballStyle : public vtkInteractorStyleTrackballCamera {
 public:
  static TrackballStyle* New() { return new TrackballStyle; }
  void OnChar() override {}
};

void set_up_text(vtkTextActor* actor, double x, double y, int size) {
  actor->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  actor->SetPosition(x, y);
  vtkTextProperty* text = actor->GetTextProperty();
  text->SetFontFamilyToCourier();
  text->SetFontSize(size);
  text->SetColor(0.95, 0.96, 0.98);
  text->SetBackgroundColor(0.03, 0.04, 0.06);
  text->SetBackgroundOpacity(0.6);
}

}  // namespace

void require_screen() {
  Display* display = XOpenDisplay(nullptr);
  if (display == nullptr)
    throw InputError(
        "no screen to draw on: DISPLAY is not set, or refused; without one use xvfb-run -a trevi-view ...");
  XCloseDisplay(display);
}

Window::Window(FrameSource& source, const ViewOptions& options)
    : source_(source), options_(options), painter_((require_screen(), renderer_)) {
  const bool attended = options.screenshot.empty() && options.frames.empty() && !options.benchmark;
  window_->SetOffScreenRendering(attended ? 0 : 1);
  window_->SetMultiSamples(0);  // several times the work in software, for little benefit
  window_->SetSize(options.width, options.height);
  window_->AddRenderer(renderer_);
  set_up_text(status_, 0.006, 0.01, 15);
  set_up_text(message_, 0.5, 0.92, 20);
  message_->GetTextProperty()->SetJustificationToCentered();
  message_->GetTextProperty()->SetColor(1.0, 0.85, 0.4);
  set_up_text(help_, 0.012, 0.97, 15);
  help_->GetTextProperty()->SetVerticalJustificationToTop();
  help_->VisibilityOff();
  for (vtkTextActor* text : {status_.Get(), message_.Get(), help_.Get()}) renderer_->AddViewProp(text);
  painter_.set_style(options.style);
  painter_.set_colour(options.colour);
  source_.want_density(options.colour == Colour::density);
  last_tick_ = last_picture_ = WallClock::now();
}

Window::~Window() = default;

void Window::run(MusicPlayer& music) {
  music_ = &music;
  interactor_->SetRenderWindow(window_);
  vtkNew<TrackballStyle> style;
  interactor_->SetInteractorStyle(style);
  interactor_->Initialize();
  vtkNew<vtkCallbackCommand> keys, ticks;
  keys->SetClientData(this);
  keys->SetCallback([](vtkObject* caller, unsigned long, void* self, void*) {
    static_cast<Window*>(self)->press(static_cast<vtkRenderWindowInteractor*>(caller)->GetKeySym());
  });
  ticks->SetClientData(this);
  ticks->SetCallback([](vtkObject*, unsigned long, void* self, void*) { static_cast<Window*>(self)->tick(); });
  interactor_->AddObserver(vtkCommand::KeyPressEvent, keys);
  interactor_->AddObserver(vtkCommand::TimerEvent, ticks);
  // Pictures that the mouse asks for count, too.
  vtkNew<vtkCallbackCommand> drawn;
  drawn->SetClientData(this);
  drawn->SetCallback([](vtkObject*, unsigned long, void* self, void*) { static_cast<Window*>(self)->measure(); });
  window_->AddObserver(vtkCommand::EndEvent, drawn);
  vtkNew<vtkCallbackCommand> drawing;
  drawing->SetClientData(&painter_);
  drawing->SetCallback(
      [](vtkObject*, unsigned long, void* painter, void*) { static_cast<Painter*>(painter)->size_points(); });
  window_->AddObserver(vtkCommand::StartEvent, drawing);
  interactor_->CreateRepeatingTimer(tick_milliseconds);
  paint();
  render();
  last_tick_ = WallClock::now();
  interactor_->Start();
}

void Window::tick() {
  const auto now = WallClock::now();
  const double seconds = std::min(seconds_between(last_tick_, now), 1.0);
  last_tick_ = now;
  if (source_.advance(seconds)) dirty_ = true;
  if (music_ != nullptr && source_.frame()) music_->follow(source_.frame()->time, source_.rate());
  if (!dirty_) return;
  paint();
  render();
}

void Window::paint() {
  const ViewedScene& scene = source_.scene();
  const std::string identity = fmt::format("{} {} {}", scene.name, scene.spacing, scene.max.sum());
  if (identity != scene_name_) {
    scene_name_ = identity;
    painter_.set_scene(scene, options_.camera);
  }
  if (source_.frame() && source_.frame() != shown_) {
    shown_ = source_.frame();
    painter_.show(shown_);
  }
  update_texts();
}

void Window::render() {
  dirty_ = false;
  renderer_->ResetCameraClippingRange();
  painter_.size_points();
  window_->Render();
  update_title();  // afterwards, so that its content can be seen
}

void Window::measure() {
  const auto now = WallClock::now();
  const double interval = seconds_between(last_picture_, now);
  last_picture_ = now;
  // After a rest the first picture says nothing about speed.
  interval_ = interval > 1 || interval_ == 0 ? interval : 0.8 * interval_ + 0.2 * interval;
}

void Window::update_texts() {
  const std::string frame = shown_ ? status_of(*shown_) : "waiting for the first frame";
  const std::string fps = interval_ > 0 && interval_ <= 1 ? fmt::format("  {:.0f} fps", 1 / interval_) : "";
  const std::string style = style_names[static_cast<std::size_t>(painter_.style())];
  status_->SetInput(fmt::format("{}{}\n{}  {}, {}  h: keys{}", frame, fps, source_.pace(), style, painter_.legend(),
                                note_.empty() ? "" : "  " + note_)
                        .c_str());
  message_->SetInput(source_.message().c_str());
  message_->SetVisibility(!source_.message().empty());
}

void Window::update_title() {
  const std::string step = shown_ ? fmt::format("step {}", shown_->step) : "no frame";
  const std::string style = style_names[static_cast<std::size_t>(painter_.style())];
  const std::string colour = colour_list[static_cast<std::size_t>(painter_.colour())].name;
  window_->SetWindowName(
      fmt::format("trevi-view: {}, {}, {}, {}, {}", source_.scene().name, step, source_.pace(), style, colour).c_str());
}

void Window::press(const std::string& key) {
  note_.clear();
  if (key == "Escape" || (key == "q" && source_.leave())) {
    interactor_->TerminateApp();
    return;
  }
  if (press_steering(key) || press_looks(key)) dirty_ = true;
}

bool Window::press_steering(const std::string& key) {
  if (key == "space")
    source_.pause(!source_.paused());
  else if (key == "Right" || key == "n")
    source_.step(1);
  else if (key == "Left")
    source_.step(-1);
  else if (key == "Home")
    source_.jump(false);
  else if (key == "End")
    source_.jump(true);
  else if (key == "plus" || key == "equal" || key == "KP_Add")
    source_.change_speed(2);
  else if (key == "minus" || key == "KP_Subtract")
    source_.change_speed(0.5);
  else if (key == "l")
    source_.switch_loop();
  else
    return key == "q";
  return true;
}

bool Window::press_looks(const std::string& key) {
  if (key == "r")
    painter_.reset_camera();
  else if (key == "c")
    painter_.set_colour(next_colour(painter_.colour()));
  else if (key == "p")
    painter_.set_style(static_cast<Style>((static_cast<std::size_t>(painter_.style()) + 1) % style_names.size()));
  else if (key == "s")
    save_numbered();
  else if (key == "h" || key == "question")
    help_->SetVisibility(!help_->GetVisibility());
  else
    return false;
  help_->SetInput(key_help(options_.live()).c_str());
  source_.want_density(painter_.colour() == Colour::density);
  return true;
}

void Window::save_numbered() {
  const std::string step = shown_ ? fmt::format("{:06d}", shown_->step) : "empty";
  std::string path = fmt::format("trevi_view_{}.png", step);
  for (int k = 1; std::filesystem::exists(path); ++k) path = fmt::format("trevi_view_{}_{}.png", step, k);
  try {
    write_picture(window_, path);
    note_ = "saved " + path;
  } catch (const Error& error) {
    note_ = error.what();
  }
}

void Window::save(const std::string& path) {
  paint();
  render();
  write_picture(window_, path);
}

double Window::benchmark(double seconds) {
  paint();
  render();
  const auto begin = WallClock::now();
  int pictures = 0;
  double passed = 0;
  for (; passed < seconds || pictures < 3; ++pictures) {
    renderer_->GetActiveCamera()->Azimuth(2);
    render();
    passed = seconds_between(begin, WallClock::now());
  }
  return pictures / passed;
}

}  // namespace trevi
