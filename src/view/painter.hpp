// Draws particles, obstacles and their box into a VTK renderer: as points, as lit spheres, or as the surface of a
// fluid, determined in screen space (fluid_actor.hpp). Nothing is meshed; a new frame is an upload of positions and
// colours.
#pragma once

#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <array>
#include <memory>
#include <vector>

#include "view/colours.hpp"
#include "view/fluid_actor.hpp"

class vtkActor;
class vtkOpenGLSphereMapper;
class vtkPointGaussianMapper;
class vtkPolyData;
class vtkProp;
class vtkRenderer;

namespace trevi {

enum class Style { points, spheres, fluid };
inline constexpr std::array<const char*, 3> style_names = {"points", "spheres", "fluid"};

/// Angles in degrees around and above, and the magnification (1: the whole box).
struct CameraPose {
  double azimuth = 30, elevation = 20, zoom = 1;
};

class Painter {
 public:
  explicit Painter(vtkRenderer* renderer);
  ~Painter();

  /// Sets the box, sizes of particles, and camera.
  void set_scene(const ViewedScene& scene, const CameraPose& pose);
  void reset_camera();
  /// To be called before a picture, because the camera may have moved: neighbouring points touch where the camera
  /// looks.
  void size_points();
  void show(std::shared_ptr<const ViewedFrame> frame);
  void set_style(Style style);
  void set_colour(Colour colour);
  Style style() const { return style_; }
  Colour colour() const { return colour_; }
  std::string legend() const;

 private:
  void add_light(const Vec3& from, double intensity);
  void add_points();
  void add_spheres();
  void add_fluid();
  void add_solids();
  void show_solids();
  void draw_box(const ViewedScene& scene);
  void recolour();

  vtkRenderer* renderer_;
  vtkNew<vtkPolyData> particles_, with_cell_;
  vtkNew<vtkPointGaussianMapper> points_;
  vtkNew<vtkOpenGLSphereMapper> spheres_, fluid_;
  vtkNew<vtkPolyData> solids_;
  vtkNew<vtkActor> points_actor_, spheres_actor_, solids_actor_;
  vtkNew<FluidActor> fluid_actor_;
  std::vector<vtkSmartPointer<vtkProp>> box_;
  ViewedScene scene_;
  CameraPose pose_;
  std::shared_ptr<const ViewedFrame> frame_ = std::make_shared<ViewedFrame>();
  std::vector<std::shared_ptr<const TriangleMesh>> drawn_solids_;
  ColourRange range_;
  std::vector<unsigned char> rgb_;
  Style style_ = Style::points;
  Colour colour_ = Colour::rainbow;
};

}  // namespace trevi
