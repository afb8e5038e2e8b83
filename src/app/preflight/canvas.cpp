#include "app/preflight/canvas.hpp"

#include <png.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "trevi/error.hpp"

namespace trevi {

Canvas::Canvas(const Box& box, int width, int height)
    : width_(width),
      height_(height),
      right_(Vec3(1, 0.45, 0).normalized()),
      towards_(Vec3(0.45, -1, 0.5).normalized()),
      middle_((box.min + box.max) / 2) {
  up_ = towards_.cross(right_).normalized();
  right_ = up_.cross(towards_);
  constexpr Real margin = 1.08;
  const Vec3 half = (box.max - box.min) / 2;
  const Real across = half.dot(right_.cwiseAbs()), along = half.dot(up_.cwiseAbs());
  scale_ = std::min(width / (2 * across), height / (2 * along)) / margin;
  front_ = empty_layer();
}

Canvas::Layer Canvas::empty_layer() const {
  const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  constexpr Colour3 paper{1, 1, 1};
  return {std::vector<float>(pixels, -std::numeric_limits<float>::infinity()), std::vector<Colour3>(pixels, paper)};
}

Vec3 Canvas::on_screen(const Vec3& place) const {
  const Vec3 d = place - middle_;
  return {width_ / 2.0 + scale_ * d.dot(right_), height_ / 2.0 - scale_ * d.dot(up_), d.dot(towards_)};
}

void Canvas::draw(const TriangleMesh& mesh, const Colour3& colour) { draw(mesh, colour, front_); }

void Canvas::draw(const TriangleMesh& mesh, const Colour3& colour, Layer& layer) const {
  for (const auto& t : mesh.triangles) {
    const Vec3& a = mesh.points[static_cast<std::size_t>(t[0])];
    const Vec3& b = mesh.points[static_cast<std::size_t>(t[1])];
    const Vec3& c = mesh.points[static_cast<std::size_t>(t[2])];
    const Vec3 normal = (b - a).cross(c - a).normalized();
    if (!(normal.dot(towards_) > 0)) continue;
    const auto light = static_cast<float>(0.45 + 0.35 * normal.dot(towards_) + 0.2 * std::max<Real>(0, normal.z()));
    fill({on_screen(a), on_screen(b), on_screen(c)}, {light * colour[0], light * colour[1], light * colour[2]}, layer);
  }
}

// By barycentric coordinates of the centres of pixels.
void Canvas::fill(const std::array<Vec3, 3>& corners, const Colour3& colour, Layer& layer) const {
  const auto& [a, b, c] = corners;
  const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  const Real area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  if (area == 0) return;
  const int first_x = static_cast<int>(std::max<Real>(0, std::ceil(low.x() - 0.5)));
  const int last_x = static_cast<int>(std::min<Real>(width_ - 1, std::floor(high.x() - 0.5)));
  const int first_y = static_cast<int>(std::max<Real>(0, std::ceil(low.y() - 0.5)));
  const int last_y = static_cast<int>(std::min<Real>(height_ - 1, std::floor(high.y() - 0.5)));
  for (int y = first_y; y <= last_y; ++y) {
    for (int x = first_x; x <= last_x; ++x) {
      const Real px = x + 0.5 - a.x(), py = y + 0.5 - a.y();
      const Real v = (px * (c.y() - a.y()) - py * (c.x() - a.x())) / area;
      const Real w = ((b.x() - a.x()) * py - (b.y() - a.y()) * px) / area;
      if (v < 0 || w < 0 || v + w > 1) continue;
      const auto depth = static_cast<float>(a.z() + v * (b.z() - a.z()) + w * (c.z() - a.z()));
      const std::size_t pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
      if (depth <= layer.depth[pixel]) continue;
      layer.depth[pixel] = depth;
      layer.colour[pixel] = colour;
    }
  }
}

void Canvas::draw_line(const Vec3& from, const Vec3& to, const Colour3& colour) {
  const Vec3 a = on_screen(from), b = on_screen(to);
  const int steps = static_cast<int>(std::ceil((b - a).head<2>().cwiseAbs().maxCoeff())) + 1;
  for (int k = 0; k <= steps; ++k) {
    const Vec3 p = a + (b - a) * k / steps;
    const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
    if (x < 0 || y < 0 || x >= width_ || y >= height_) continue;
    const std::size_t pixel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    if (static_cast<float>(p.z()) < front_.depth[pixel]) continue;
    front_.colour[pixel] = colour;
  }
}

void Canvas::draw_glass(const TriangleMesh& mesh, const Colour3& colour, float opacity) {
  Layer glass = empty_layer();
  draw(mesh, colour, glass);
  for (std::size_t n = 0; n < glass.depth.size(); ++n) {
    if (glass.depth[n] <= front_.depth[n] || std::isinf(glass.depth[n])) continue;
    for (std::size_t k = 0; k < 3; ++k) front_.colour[n][k] += opacity * (glass.colour[n][k] - front_.colour[n][k]);
  }
}

std::string Canvas::png() const {
  std::vector<unsigned char> bytes;
  bytes.reserve(3 * front_.colour.size());
  for (const Colour3& pixel : front_.colour)
    for (const float part : pixel)
      bytes.push_back(static_cast<unsigned char>(std::lround(255 * std::clamp(part, 0.F, 1.F))));
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_);
  image.height = static_cast<png_uint_32>(height_);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  std::string file;
  const auto write = [&](void* into) {
    return png_image_write_to_memory(&image, into, &size, 0, bytes.data(), 0, nullptr);
  };
  require(write(nullptr) != 0, "a picture: libpng tells no size");
  file.resize(size);
  require(write(file.data()) != 0, "a picture: libpng fails");
  file.resize(size);
  return file;
}

}  // namespace trevi
