// A picture of triangles without a graphics library: an orthographic view of a box from its front, right and above,
// with a depth for each pixel and shading by the angle to the viewer. For a look at a scene, not for publications. Not
// collective.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "trevi/box.hpp"
#include "trevi/obstacle.hpp"

namespace trevi {

using Colour3 = std::array<float, 3>;  ///< red, green, blue from 0 to 1

class Canvas {
 public:
  /// The whole box is visible.
  Canvas(const Box& box, int width, int height);

  /// Draws the triangles that face the viewer; what is behind something drawn before is hidden.
  void draw(const TriangleMesh& mesh, const Colour3& colour);
  void draw_line(const Vec3& from, const Vec3& to, const Colour3& colour);
  /// Lays the nearest of these triangles over what has been drawn so far, with `opacity` from 0 to 1.
  void draw_glass(const TriangleMesh& mesh, const Colour3& colour, float opacity);

  /// The bytes of a PNG file.
  std::string png() const;

 private:
  struct Layer {
    std::vector<float> depth;  // towards the viewer
    std::vector<Colour3> colour;
  };
  Vec3 on_screen(const Vec3& place) const;  // pixels, and m towards the viewer
  void draw(const TriangleMesh& mesh, const Colour3& colour, Layer& layer) const;
  void fill(const std::array<Vec3, 3>& corners, const Colour3& colour, Layer& layer) const;
  Layer empty_layer() const;

  int width_, height_;
  Vec3 right_, up_, towards_, middle_;
  Real scale_ = 1;  // pixels per metre
  Layer front_;
};

}  // namespace trevi
