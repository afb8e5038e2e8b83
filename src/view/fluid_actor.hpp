// Draws spheres as the surface of a fluid, in screen space: their nearest depths and colours are written to textures,
// smoothed together (after van der Laan, Green, Sainz, I3D 2009, by an edge-avoiding filter), and lit by the normals of
// the smoothed depth. Colours are smoothed with the weights of the depth, so that they blend along a surface and never
// through it. Anything nearer that has already been drawn is kept.
#pragma once

#include <vtkNew.h>
#include <vtkOpenGLActor.h>

#include <memory>

class vtkOpenGLFramebufferObject;
class vtkOpenGLQuadHelper;
class vtkOpenGLRenderWindow;
class vtkTextureObject;

namespace trevi {

/// To be used with a vtkOpenGLSphereMapper, and without lighting.
class FluidActor : public vtkOpenGLActor {
 public:
  static FluidActor* New();
  vtkTypeMacro(FluidActor, vtkOpenGLActor)

  /// The radius of a sphere, in the units of the scene.
  void set_radius(double radius) { radius_ = radius; }

  void Render(vtkRenderer* renderer, vtkMapper* mapper) override;
  void ReleaseGraphicsResources(vtkWindow* window) override;

 protected:
  FluidActor();
  ~FluidActor() override;

 private:
  // The view of the camera: the tangents of half its angles, the range of its depths, and pixels.
  struct View {
    float tangent[2], near_and_far[2], pixel[2];
    int size[2];
  };
  static View view_of(vtkRenderer* renderer);
  void prepare(vtkOpenGLRenderWindow* window, const View& view);
  void draw_spheres(vtkRenderer* renderer, vtkMapper* mapper, const View& view);
  void find_distances(vtkOpenGLRenderWindow* window, const View& view);
  void smooth(vtkOpenGLRenderWindow* window, const View& view);
  void light(vtkOpenGLRenderWindow* window, const View& view);

  vtkNew<vtkOpenGLFramebufferObject> target_;
  vtkNew<vtkTextureObject> colour_, depth_;
  vtkNew<vtkTextureObject> water_[2];  // colour, and distance along the line of sight; 0: no water
  std::unique_ptr<vtkOpenGLQuadHelper> distances_, filter_, lights_;
  double radius_ = 1;
};

}  // namespace trevi
