#include "yarm/rays/rays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace {

constexpr double kNearPlane = 1e-3;  // m; what is nearer is not projected
constexpr double kFar = 1e30;
constexpr double kPi = 3.14159265358979323846;
constexpr double kGrazingCosine = 0.5;  // beyond 60 deg from the surface's normal
constexpr double kSteepest = 85.0 * kPi / 180.0;

struct Vec3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Vec3 operator*(double s, const Vec3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
double dot(const Vec3& a, const Vec3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// A point of the ray where it enters a solid: parameter (0 or less: no hit) and the surface's normal, solid's frame.
struct Hit {
  double t = 0.0;
  Vec3 normal;
};

// A rigid pose; columns of the rotation and the translation.
struct Pose {
  Vec3 x;
  Vec3 y;
  Vec3 z;
  Vec3 origin;

  static Pose of(const double* m) {
    return {{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}, {m[3], m[7], m[11]}};
  }
  Vec3 turn(const Vec3& v) const { return v.x * x + v.y * y + v.z * z; }
  Vec3 turnBack(const Vec3& v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
  Vec3 apply(const Vec3& v) const { return turn(v) + origin; }
  Pose operator*(const Pose& other) const { return {turn(other.x), turn(other.y), turn(other.z), apply(other.origin)}; }
};

Hit hitBox(const Vec3& half, const Vec3& o, const Vec3& d) {
  const std::array<double, 3> half_size{half.x, half.y, half.z};
  const std::array<double, 3> origin{o.x, o.y, o.z};
  const std::array<double, 3> direction{d.x, d.y, d.z};
  double enter = -std::numeric_limits<double>::infinity();
  double leave = std::numeric_limits<double>::infinity();
  std::size_t axis = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (direction[i] == 0.0) {
      if (std::abs(origin[i]) > half_size[i]) {
        return {};
      }
      continue;
    }
    const double inverse = 1.0 / direction[i];
    const double a = (-half_size[i] - origin[i]) * inverse;
    const double b = (half_size[i] - origin[i]) * inverse;
    if (std::min(a, b) > enter) {
      enter = std::min(a, b);
      axis = i;
    }
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave || enter <= 0.0) {
    return {};
  }
  return {enter, {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0}};
}

Hit hitCylinder(double radius, double half_length, const Vec3& o, const Vec3& d) {
  if (d.z != 0.0) {
    const double t = ((d.z < 0.0 ? half_length : -half_length) - o.z) / d.z;
    const double x = o.x + t * d.x;
    const double y = o.y + t * d.y;
    if (t > 0.0 && x * x + y * y <= radius * radius) {
      return {t, {0.0, 0.0, 1.0}};
    }
  }
  const double a = d.x * d.x + d.y * d.y;
  const double b = o.x * d.x + o.y * d.y;
  const double c = o.x * o.x + o.y * o.y - radius * radius;
  const double discriminant = b * b - a * c;
  if (a == 0.0 || discriminant < 0.0) {
    return {};
  }
  const double t = (-b - std::sqrt(discriminant)) / a;
  if (t <= 0.0 || std::abs(o.z + t * d.z) > half_length) {
    return {};
  }
  return {t, {(o.x + t * d.x) / radius, (o.y + t * d.y) / radius, 0.0}};
}

Hit hitSphere(double radius, const Vec3& o, const Vec3& d) {
  const double a = dot(d, d);
  const double b = dot(o, d);
  const double discriminant = b * b - a * (dot(o, o) - radius * radius);
  if (discriminant < 0.0) {
    return {};
  }
  const double t = (-b - std::sqrt(discriminant)) / a;
  return {t, (1.0 / radius) * (o + t * d)};
}

struct Solid {
  std::int32_t shape;
  const double* size;

  Vec3 halfExtent() const {
    switch (shape) {
      case YARM_BOX:
        return {0.5 * size[0], 0.5 * size[1], 0.5 * size[2]};
      case YARM_CYLINDER:
        return {size[0], size[0], 0.5 * size[1]};
      default:
        return {size[0], size[0], size[0]};
    }
  }
  Hit hit(const Vec3& origin, const Vec3& direction) const {
    switch (shape) {
      case YARM_BOX:
        return hitBox(halfExtent(), origin, direction);
      case YARM_CYLINDER:
        return hitCylinder(size[0], 0.5 * size[1], origin, direction);
      default:
        return hitSphere(size[0], origin, direction);
    }
  }
};

// Pixels [left, right) x [top, bottom).
struct Window {
  int left;
  int right;
  int top;
  int bottom;
};

// Grows to hold every point that is put into it, in pixels.
struct Bounds {
  double left = 1e9;
  double right = -1e9;
  double top = 1e9;
  double bottom = -1e9;

  void add(const YarmCamera& camera, const Vec3& p) {
    const double u = p.x / p.z * camera.focal_px + 0.5 * camera.width;
    const double v = p.y / p.z * camera.focal_px + 0.5 * camera.height;
    left = std::min(left, u);
    right = std::max(right, u);
    top = std::min(top, v);
    bottom = std::max(bottom, v);
  }
};

// The pixels that the part of a box before the near plane projects to.
Window windowOf(const YarmCamera& camera, const Pose& optical_from_solid, const Vec3& half) {
  std::array<Vec3, 8> corners;
  for (unsigned i = 0; i < corners.size(); ++i) {
    corners[i] = optical_from_solid.apply(
        {(i & 1U) != 0 ? half.x : -half.x, (i & 2U) != 0 ? half.y : -half.y, (i & 4U) != 0 ? half.z : -half.z});
  }
  Bounds bounds;
  for (unsigned i = 0; i < corners.size(); ++i) {
    const Vec3& from = corners[i];
    if (from.z >= kNearPlane) {
      bounds.add(camera, from);
    }
    for (const unsigned axis : {1U, 2U, 4U}) {
      const Vec3& to = corners[i ^ axis];
      if (from.z < kNearPlane && to.z >= kNearPlane) {
        const double share = (kNearPlane - from.z) / (to.z - from.z);
        bounds.add(camera, (1.0 - share) * from + share * to);
      }
    }
  }
  const auto pixel = [](double value, int limit) { return static_cast<int>(std::clamp(value, 0.0, double(limit))); };
  return {pixel(bounds.left - 1.0, camera.width), pixel(bounds.right + 2.0, camera.width),
          pixel(bounds.top - 1.0, camera.height), pixel(bounds.bottom + 2.0, camera.height)};
}

bool allBehind(const Pose& optical_from_solid, const Vec3& half) {
  const double reach = std::abs(optical_from_solid.x.z) * half.x + std::abs(optical_from_solid.y.z) * half.y +
                       std::abs(optical_from_solid.z.z) * half.z;
  return optical_from_solid.origin.z + reach <= 0.0;
}

struct Point {
  float x;
  float y;
  float z;
  std::uint32_t rgb;
};

}  // namespace

float yarmRaysSigma(double depth, double incidence_cosine) {
  const double beyond = depth - 0.4;
  double sigma = 0.0012 + 0.0019 * beyond * beyond;
  const double cosine = std::abs(incidence_cosine);
  if (cosine < kGrazingCosine) {
    const double theta = std::min(std::acos(cosine), kSteepest);
    const double left = 0.5 * kPi - theta;
    sigma += 0.0001 / std::sqrt(std::max(depth, 0.1)) * theta * theta / (left * left);
  }
  return static_cast<float>(sigma);
}

void yarmRaysFloor(const YarmCamera* camera, const double* world_from_optical, std::uint32_t colour, float* depth,
                   float* noise_sigma, std::uint32_t* rgb) {
  const Pose pose = Pose::of(world_from_optical);
  const double pixel = 1.0 / camera->focal_px;
  std::size_t at = 0;
  for (int row = 0; row < camera->height; ++row) {
    const double v = (row + 0.5 - 0.5 * camera->height) * pixel;
    for (int column = 0; column < camera->width; ++column, ++at) {
      const Vec3 ray{(column + 0.5 - 0.5 * camera->width) * pixel, v, 1.0};
      const double down = pose.turn(ray).z;
      const double t = down < 0.0 ? -pose.origin.z / down : kFar;
      const bool seen = t > 0.0 && t < camera->far_m + 1.0;
      depth[at] = static_cast<float>(seen ? t : kFar);
      noise_sigma[at] = seen ? yarmRaysSigma(t, down / std::sqrt(dot(ray, ray))) : 0.0F;
      rgb[at] = seen ? colour : 0U;
    }
  }
}

void yarmRaysAdd(const YarmCamera* camera, const double* optical_from_world, std::int32_t n, const std::int32_t* shapes,
                 const double* sizes, const double* world_from_solid, const std::uint32_t* colours, float* depth,
                 float* noise_sigma, std::uint32_t* rgb) {
  const Pose view = Pose::of(optical_from_world);
  const double pixel = 1.0 / camera->focal_px;
  for (std::int32_t i = 0; i < n; ++i) {
    const Solid solid{shapes[i], sizes + 3 * i};
    const Pose pose = view * Pose::of(world_from_solid + 16 * i);
    if (allBehind(pose, solid.halfExtent())) {
      continue;
    }
    const Window window = windowOf(*camera, pose, solid.halfExtent());
    const Vec3 origin = -1.0 * pose.turnBack(pose.origin);
    for (int row = window.top; row < window.bottom; ++row) {
      const double v = (row + 0.5 - 0.5 * camera->height) * pixel;
      for (int column = window.left; column < window.right; ++column) {
        const Vec3 ray{(column + 0.5 - 0.5 * camera->width) * pixel, v, 1.0};
        const Vec3 direction = pose.turnBack(ray);
        const Hit hit = solid.hit(origin, direction);
        const std::size_t at = static_cast<std::size_t>(row) * camera->width + column;
        if (hit.t > 0.0 && hit.t < depth[at]) {
          depth[at] = static_cast<float>(hit.t);
          noise_sigma[at] = yarmRaysSigma(hit.t, dot(hit.normal, direction) / std::sqrt(dot(ray, ray)));
          rgb[at] = colours[i];
        }
      }
    }
  }
}

void yarmRaysCloud(const YarmCamera* camera, const float* depth, const float* noise_sigma, const std::uint32_t* rgb,
                   const float* normals, void* points) {
  const float pixel = static_cast<float>(1.0 / camera->focal_px);
  const float near = static_cast<float>(camera->near_m);
  const float far = static_cast<float>(camera->far_m);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  auto* out = static_cast<Point*>(points);
  for (int row = 0; row < camera->height; ++row) {
    const float v = (static_cast<float>(row) + 0.5F - 0.5F * static_cast<float>(camera->height)) * pixel;
    const std::size_t start = static_cast<std::size_t>(row) * camera->width;
    for (int column = 0; column < camera->width; ++column) {
      const std::size_t at = start + column;
      const float noisy = normals == nullptr ? depth[at] : depth[at] + noise_sigma[at] * normals[at];
      const float z = noisy >= near && noisy <= far ? noisy : nan;
      const float u = (static_cast<float>(column) + 0.5F - 0.5F * static_cast<float>(camera->width)) * pixel;
      out[at] = {u * z, v * z, z, rgb[at]};
    }
  }
}
