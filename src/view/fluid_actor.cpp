#include "view/fluid_actor.hpp"

#include <vtkCamera.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLQuadHelper.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLShaderCache.h>
#include <vtkOpenGLState.h>
#include <vtkRenderer.h>
#include <vtkShaderProgram.h>
#include <vtkTextureObject.h>
#include <vtk_glew.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trevi {

namespace {

// Distance between the taps, as a fraction of three radii of a sphere, at least one pixel; an even number of passes.
constexpr float gaps[] = {0.32F, 0.16F, 0.08F, 0};

// Converts the depths of the projection to distances.
constexpr const char* distances_program = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 texCoord;
uniform sampler2D colour, depth;
uniform vec2 near_and_far;
void main(void) {
  float d = texture(depth, texCoord).r;
  float n = near_and_far.x, f = near_and_far.y;
  gl_FragData[0] = vec4(texture(colour, texCoord).rgb, d < 1.0 ? n * f / (f - d * (f - n)) : 0.0);
}
)";

// An edge-avoiding à-trous filter (Dammertz et al. 2010): nine taps of a B-spline, closer together in each pass, which
// together are as wide as two spheres. Weights fall with the difference along the line of sight: anything a few spheres
// away is another surface.
constexpr const char* filter_program = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 texCoord;
uniform sampler2D water;
uniform vec2 pixel;
uniform float radius, pixels, share;
void main(void) {
  vec4 here = texture(water, texCoord);
  gl_FragData[0] = here;
  if (here.a <= 0.0) return;
  vec2 stride = max(1.0, floor(share * clamp(3.0 * radius * pixels / here.a, 1.0, 40.0))) * pixel;
  float along = 0.5 / (radius * radius), weight = 0.0;
  vec4 sum = vec4(0.0);
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j) {
      vec4 there = texture(water, texCoord + vec2(float(i), float(j)) * stride);
      float off = there.a - here.a;
      float w = there.a <= 0.0 ? 0.0 : exp(-along * off * off) / (float(1 << (abs(i) + abs(j))));
      weight += w;
      sum += w * there;
    }
  gl_FragData[0] = sum / weight;
}
)";

// The same two lights as for spheres. Of the differences to both sides, the smaller one is on the same surface.
constexpr const char* lights_program = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 texCoord;
uniform sampler2D water;
uniform vec2 tangent, near_and_far, pixel;
vec3 place(vec2 at) {
  float z = texture(water, at).a;
  return vec3((2.0 * at - 1.0) * tangent * z, -z);
}
vec3 slope(vec3 here, vec2 way) {
  vec3 up = place(texCoord + way) - here, down = here - place(texCoord - way);
  return abs(up.z) < abs(down.z) ? up : down;
}
float lit(vec3 n, vec3 from, float intensity) {
  vec3 l = normalize(from);
  float shine = pow(max(dot(n, normalize(l + vec3(0.0, 0.0, 1.0))), 0.0), 60.0);
  return intensity * (max(dot(n, l), 0.0) + 0.35 * shine);
}
void main(void) {
  vec4 here = texture(water, texCoord);
  if (here.a <= 0.0) discard;
  vec3 p = place(texCoord);
  vec3 n = normalize(cross(slope(p, vec2(pixel.x, 0.0)), slope(p, vec2(0.0, pixel.y))));
  float bright = 0.25 + lit(n, vec3(-0.5, 0.9, 1.0), 0.8) + lit(n, vec3(0.6, -0.1, 1.0), 0.3);
  gl_FragData[0] = vec4(bright * here.rgb, 1.0);
  gl_FragDepth = near_and_far.y * (here.a - near_and_far.x) / (here.a * (near_and_far.y - near_and_far.x));
}
)";

using Quad = std::unique_ptr<vtkOpenGLQuadHelper>;

vtkShaderProgram* ready(vtkOpenGLRenderWindow* window, Quad& quad, const char* program) {
  if (!quad)
    quad = std::make_unique<vtkOpenGLQuadHelper>(window, nullptr, program, nullptr);
  else
    window->GetShaderCache()->ReadyShaderProgram(quad->Program);
  return quad->Program;
}

void bind(vtkShaderProgram* program, const char* name, vtkTextureObject* texture) {
  texture->Activate();
  program->SetUniformi(name, texture->GetTextureUnit());
}

}  // namespace

vtkStandardNewMacro(FluidActor);

FluidActor::FluidActor() = default;
FluidActor::~FluidActor() = default;

FluidActor::View FluidActor::view_of(vtkRenderer* renderer) {
  View view{};
  int from[2];
  renderer->GetTiledSizeAndOrigin(&view.size[0], &view.size[1], &from[0], &from[1]);
  vtkCamera* camera = renderer->GetActiveCamera();
  const double tangent = std::tan(0.5 * camera->GetViewAngle() * std::numbers::pi / 180);
  view.tangent[0] = static_cast<float>(tangent * view.size[0] / view.size[1]);
  view.tangent[1] = static_cast<float>(tangent);
  const double* range = camera->GetClippingRange();
  for (int a = 0; a < 2; ++a) {
    view.near_and_far[a] = static_cast<float>(range[a]);
    view.pixel[a] = 1.0F / static_cast<float>(view.size[a]);
  }
  return view;
}

void FluidActor::Render(vtkRenderer* renderer, vtkMapper* mapper) {
  auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetRenderWindow());
  vtkOpenGLState* state = window->GetState();
  const View view = view_of(renderer);
  prepare(window, view);
  {
    vtkOpenGLState::ScopedglEnableDisable blend(state, GL_BLEND), test(state, GL_DEPTH_TEST);
    vtkOpenGLState::ScopedglViewport viewport(state);
    vtkOpenGLState::ScopedglClearColor background(state);
    state->vtkglDisable(GL_BLEND);
    state->PushFramebufferBindings();
    draw_spheres(renderer, mapper, view);
    state->vtkglDisable(GL_DEPTH_TEST);
    find_distances(window, view);
    smooth(window, view);
    state->PopFramebufferBindings();
  }
  light(window, view);
}

void FluidActor::prepare(vtkOpenGLRenderWindow* window, const View& view) {
  target_->SetContext(window);
  const auto width = static_cast<unsigned>(view.size[0]), height = static_cast<unsigned>(view.size[1]);
  for (vtkTextureObject* texture : {colour_.Get(), depth_.Get(), water_[0].Get(), water_[1].Get()}) {
    texture->SetContext(window);
    if (texture->GetHandle() != 0) {
      texture->Resize(width, height);
      continue;
    }
    texture->SetWrapS(vtkTextureObject::ClampToEdge);
    texture->SetWrapT(vtkTextureObject::ClampToEdge);
    texture->SetMinificationFilter(vtkTextureObject::Nearest);
    texture->SetMagnificationFilter(vtkTextureObject::Nearest);
    if (texture == depth_)
      texture->AllocateDepth(width, height, vtkTextureObject::Float32);
    else
      texture->Allocate2D(width, height, 4, texture == colour_ ? VTK_UNSIGNED_CHAR : VTK_FLOAT);
  }
}

void FluidActor::draw_spheres(vtkRenderer* renderer, vtkMapper* mapper, const View& view) {
  vtkOpenGLState* state = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetRenderWindow())->GetState();
  target_->Bind();
  target_->AddColorAttachment(0, colour_);
  target_->AddDepthAttachment(depth_.Get());
  target_->ActivateDrawBuffers(1);
  state->vtkglViewport(0, 0, view.size[0], view.size[1]);
  state->vtkglEnable(GL_DEPTH_TEST);
  state->vtkglDepthMask(GL_TRUE);
  state->vtkglClearColor(0, 0, 0, 0);
  state->vtkglClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  Superclass::Render(renderer, mapper);
}

void FluidActor::find_distances(vtkOpenGLRenderWindow* window, const View& view) {
  target_->RemoveDepthAttachment();
  target_->AddColorAttachment(0, water_[0]);
  vtkShaderProgram* program = ready(window, distances_, distances_program);
  bind(program, "colour", colour_);
  bind(program, "depth", depth_);
  program->SetUniform2f("near_and_far", view.near_and_far);
  distances_->Render();
  colour_->Deactivate();
  depth_->Deactivate();
}

void FluidActor::smooth(vtkOpenGLRenderWindow* window, const View& view) {
  int from = 0;
  for (const float gap : gaps) {
    target_->AddColorAttachment(0, water_[1 - from]);
    vtkShaderProgram* program = ready(window, filter_, filter_program);
    bind(program, "water", water_[from]);
    program->SetUniform2f("pixel", view.pixel);
    program->SetUniformf("radius", static_cast<float>(radius_));
    program->SetUniformf("pixels", static_cast<float>(view.size[1]) / (2 * view.tangent[1]));
    program->SetUniformf("share", gap);
    filter_->Render();
    water_[from]->Deactivate();
    from = 1 - from;
  }
}

void FluidActor::light(vtkOpenGLRenderWindow* window, const View& view) {
  vtkShaderProgram* program = ready(window, lights_, lights_program);
  bind(program, "water", water_[0]);
  program->SetUniform2f("tangent", view.tangent);
  program->SetUniform2f("near_and_far", view.near_and_far);
  program->SetUniform2f("pixel", view.pixel);
  lights_->Render();
  water_[0]->Deactivate();
}

void FluidActor::ReleaseGraphicsResources(vtkWindow* window) {
  for (auto* quad : {&distances_, &filter_, &lights_}) quad->reset();
  for (vtkTextureObject* texture : {colour_.Get(), depth_.Get(), water_[0].Get(), water_[1].Get()})
    texture->ReleaseGraphicsResources(window);
  target_->ReleaseGraphicsResources(window);
  Superclass::ReleaseGraphicsResources(window);
}

}  // namespace trevi
