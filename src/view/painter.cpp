#include "view/painter.hpp"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCullerCollection.h>
#include <vtkFloatArray.h>
#include <vtkLight.h>
#include <vtkOpenGLSphereMapper.h>
#include <vtkOutlineSource.h>
#include <vtkPlaneSource.h>
#include <vtkPointData.h>
#include <vtkPointGaussianMapper.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkShaderProperty.h>
#include <vtkUnsignedCharArray.h>

#include <cmath>
#include <numbers>

namespace trevi {

namespace {

constexpr double min_point = 2, largest_point = 16;  // pixels
constexpr double sphere_radius = 0.5;                // in spacings: neighbours touch
constexpr double fluid_radius = 0.75;                // larger, so that the gaps close
constexpr double view_angle = 30;                    // degrees, VTK's own

void set_floor(vtkPlaneSource* plane, const Vec3& min, const Vec3& max, double drop) {
  const double z = min.z() - drop;
  plane->SetOrigin(min.x(), min.y(), z);
  plane->SetPoint1(max.x(), min.y(), z);
  plane->SetPoint2(min.x(), max.y(), z);
}

}  // namespace

Painter::Painter(vtkRenderer* renderer) : renderer_(renderer) {
  renderer_->SetBackground(0.05, 0.06, 0.09);
  renderer_->SetBackground2(0.20, 0.24, 0.31);
  renderer_->GradientBackgroundOn();
  // They use the bounds of cells, and spheres have one cell for all: at close range they would be left out.
  renderer_->GetCullers()->RemoveAllItems();
  add_light({-0.5, 0.9, 1}, 0.85);
  add_light({0.6, -0.1, 1}, 0.3);
  add_points();
  add_spheres();
  add_fluid();
  add_solids();
  set_style(Style::points);
}

Painter::~Painter() = default;

// `from`: as seen by the camera, which is at (0, 0, 1) and looks at the origin.
void Painter::add_light(const Vec3& from, double intensity) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(from.x(), from.y(), from.z());
  light->SetIntensity(intensity);
  renderer_->AddLight(light);
}

void Painter::add_points() {
  points_->SetInputData(particles_);
  points_->SetScaleFactor(0);  // plain points instead of splats
  points_->EmissiveOff();
  points_actor_->SetMapper(points_);
  points_actor_->GetProperty()->LightingOff();
  // Points have no shape that could be lit; instead the far ones are darker. The depth runs from 0 to 1 over the box.
  points_actor_->GetShaderProperty()->AddFragmentShaderReplacement(
      "//VTK::Light::Impl", true,
      "//VTK::Light::Impl\n  gl_FragData[0].rgb *= mix(1.25, 0.75, clamp(gl_FragCoord.z, 0.0, 1.0));\n", false);
  renderer_->AddActor(points_actor_);
}

void Painter::add_spheres() {
  // It draws all points, but only of data that has a cell.
  vtkNew<vtkCellArray> cell;
  const vtkIdType first = 0;
  cell->InsertNextCell(1, &first);
  with_cell_->SetVerts(cell);
  spheres_->SetInputData(with_cell_);
  spheres_actor_->SetMapper(spheres_);
  spheres_actor_->GetProperty()->SetSpecular(0.25);
  spheres_actor_->GetProperty()->SetSpecularPower(20);
  spheres_actor_->GetProperty()->SetAmbient(0.15);
  renderer_->AddActor(spheres_actor_);
}

void Painter::add_fluid() {
  fluid_->SetInputData(with_cell_);
  fluid_actor_->SetMapper(fluid_);
  fluid_actor_->GetProperty()->LightingOff();
  renderer_->AddActor(fluid_actor_);
}

// Only what faces the camera: through the near walls of a vessel one sees the water.
void Painter::add_solids() {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(solids_);
  mapper->ScalarVisibilityOff();
  solids_actor_->SetMapper(mapper);
  solids_actor_->GetProperty()->SetColor(0.52, 0.50, 0.47);
  solids_actor_->GetProperty()->SetAmbient(0.2);
  solids_actor_->GetProperty()->SetInterpolationToFlat();
  solids_actor_->GetProperty()->BackfaceCullingOn();
  renderer_->AddActor(solids_actor_);
}

void Painter::show_solids() {
  if (drawn_solids_ == frame_->solids) return;
  drawn_solids_ = frame_->solids;
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> triangles;
  for (const auto& mesh : drawn_solids_) {
    const vtkIdType first = points->GetNumberOfPoints();
    for (const Vec3& p : mesh->points) points->InsertNextPoint(p.data());
    for (const auto& corners : mesh->triangles) {
      triangles->InsertNextCell(3);
      for (const std::int32_t corner : corners) triangles->InsertCellPoint(first + corner);
    }
  }
  solids_->SetPoints(points);
  solids_->SetPolys(triangles);
  solids_->Modified();
}

void Painter::set_scene(const ViewedScene& scene, const CameraPose& pose) {
  scene_ = scene;
  pose_ = pose;
  range_ = {1, scene.rest_density};
  spheres_->SetRadius(static_cast<float>(sphere_radius * scene.spacing));
  fluid_->SetRadius(static_cast<float>(fluid_radius * scene.spacing));
  fluid_actor_->set_radius(fluid_radius * scene.spacing);
  draw_box(scene);
  reset_camera();
}

void Painter::draw_box(const ViewedScene& scene) {
  for (const auto& prop : box_) renderer_->RemoveViewProp(prop);
  box_.clear();
  vtkNew<vtkOutlineSource> outline;
  outline->SetBounds(scene.min.x(), scene.max.x(), scene.min.y(), scene.max.y(), scene.min.z(), scene.max.z());
  vtkNew<vtkPlaneSource> floor;
  set_floor(floor, scene.min, scene.max, 0.5 * scene.spacing);
  vtkNew<vtkPolyDataMapper> lines, surface;
  lines->SetInputConnection(outline->GetOutputPort());
  surface->SetInputConnection(floor->GetOutputPort());
  vtkNew<vtkActor> edges, ground;
  edges->SetMapper(lines);
  edges->GetProperty()->SetColor(0.75, 0.78, 0.82);
  edges->GetProperty()->LightingOff();
  ground->SetMapper(surface);
  ground->GetProperty()->SetColor(0.30, 0.32, 0.36);
  ground->GetProperty()->LightingOff();
  box_ = {edges.Get(), ground.Get()};
  for (const auto& prop : box_) renderer_->AddViewProp(prop);
}

void Painter::reset_camera() {
  const Vec3 extent = scene_.max - scene_.min;
  Vec3 center = 0.5 * (scene_.min + scene_.max);
  if (pose_.zoom > 1) center.z() = scene_.min.z() + 0.5 * extent.z() / pose_.zoom;  // the water lies below the air
  const double degree = std::numbers::pi / 180;
  const double around = (pose_.azimuth - 90) * degree, above = pose_.elevation * degree;
  const Vec3 toward(std::cos(around) * std::cos(above), std::sin(around) * std::cos(above), std::sin(above));
  vtkCamera* camera = renderer_->GetActiveCamera();
  camera->SetViewAngle(view_angle);
  const double distance = 0.5 * extent.norm() / std::sin(0.5 * view_angle * degree) / std::max(pose_.zoom, 1e-3);
  const Vec3 eye = center + distance * toward;
  camera->SetFocalPoint(center.x(), center.y(), center.z());
  camera->SetPosition(eye.x(), eye.y(), eye.z());
  camera->SetViewUp(0, 0, 1);
  renderer_->ResetCameraClippingRange();
}

void Painter::size_points() {
  vtkCamera* camera = renderer_->GetActiveCamera();
  const double height = 2 * camera->GetDistance() * std::tan(0.5 * camera->GetViewAngle() * std::numbers::pi / 180);
  const double pixels = scene_.spacing * renderer_->GetSize()[1] / height;
  points_actor_->GetProperty()->SetPointSize(static_cast<float>(std::clamp(pixels, min_point, largest_point)));
}

void Painter::show(std::shared_ptr<const ViewedFrame> frame) {
  frame_ = std::move(frame);
  show_solids();
  vtkNew<vtkFloatArray> positions;
  positions->SetNumberOfComponents(3);
  positions->SetNumberOfTuples(static_cast<vtkIdType>(frame_->shown.size()));
  float* to = positions->GetPointer(0);
  for (const ViewedParticle& particle : frame_->shown) {
    *to++ = particle.x;
    *to++ = particle.y;
    *to++ = particle.z;
  }
  vtkNew<vtkPoints> points;
  points->SetData(positions);
  particles_->SetPoints(points);
  recolour();
}

void Painter::recolour() {
  colour_particles(*frame_, colour_, range_, rgb_);
  vtkNew<vtkUnsignedCharArray> colours;
  colours->SetName("colour");
  colours->SetNumberOfComponents(3);
  colours->SetNumberOfTuples(static_cast<vtkIdType>(frame_->shown.size()));
  std::copy(rgb_.begin(), rgb_.end(), colours->GetPointer(0));
  particles_->GetPointData()->SetScalars(colours);
  // The mappers check only the age of the points.
  if (particles_->GetPoints() != nullptr) particles_->GetPoints()->Modified();
  particles_->Modified();
  with_cell_->SetPoints(particles_->GetPoints());
  with_cell_->GetPointData()->SetScalars(colours);
  with_cell_->Modified();
}

void Painter::set_style(Style style) {
  style_ = style;
  points_actor_->SetVisibility(style == Style::points);
  spheres_actor_->SetVisibility(style == Style::spheres);
  fluid_actor_->SetVisibility(style == Style::fluid);
}

void Painter::set_colour(Colour colour) {
  colour_ = colour;
  recolour();
}

std::string Painter::legend() const { return trevi::legend(*frame_, colour_, range_); }

}  // namespace trevi
