#include "yarm/perception/solids.hpp"

#include "safe_cast.hpp"
#include "solid_math.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace yarm::perception {

namespace {

using solid_math::kTiny;

constexpr int kMostSteps = 1 << 12;  // of a sampled surface, along one direction
constexpr float kMiss = std::numeric_limits<float>::infinity();

/// The slab method (Kay and Kajiya, 1986).
float enterBox(const Eigen::Vector3f& half, const Eigen::Vector3f& o, const Eigen::Vector3f& d) {
  float enter = 0.F;
  float leave = kMiss;
  for (int a = 0; a < 3; ++a) {
    if (std::abs(d[a]) < kTiny) {
      if (std::abs(o[a]) > half[a]) {
        return kMiss;
      }
      continue;
    }
    const float near = (-std::copysign(half[a], d[a]) - o[a]) / d[a];
    const float far = (std::copysign(half[a], d[a]) - o[a]) / d[a];
    enter = std::max(enter, near);
    leave = std::min(leave, far);
  }
  return enter > 0.F && enter <= leave ? enter : kMiss;
}

/// Entry into a ball (squared terms of all axes) or an endless tube (of x and y only).
float enterRound(float radius, const Eigen::Vector3f& o, const Eigen::Vector3f& d) {
  const float a = d.squaredNorm();
  const float b = o.dot(d);
  const float disc = b * b - a * (o.squaredNorm() - radius * radius);
  if (a < kTiny || disc < 0.F) {
    return kMiss;
  }
  const float t = (-b - std::sqrt(disc)) / a;
  return t > 0.F ? t : kMiss;
}

float enterTube(float radius, float half, const Eigen::Vector3f& o, const Eigen::Vector3f& d) {
  const float t = enterRound(radius, {o.x(), o.y(), 0.F}, {d.x(), d.y(), 0.F});
  return t < kMiss && std::abs(o.z() + t * d.z()) <= half ? t : kMiss;
}

float enterCylinder(float radius, float half, const Eigen::Vector3f& o, const Eigen::Vector3f& d) {
  float best = enterTube(radius, half, o, d);
  if (std::abs(d.z()) > kTiny) {
    const float t = (-std::copysign(half, d.z()) - o.z()) / d.z();
    const Eigen::Vector3f p = o + t * d;
    best = t > 0.F && p.head<2>().squaredNorm() <= radius * radius ? std::min(best, t) : best;
  }
  return best;
}

int steps(float length, float pitch) {
  return intWithin(std::ceil(length / pitch), 1, kMostSteps);
}

void sampleBox(const Eigen::Vector3f& half, float pitch, std::vector<Eigen::Vector3f>& out) {
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const int nu = steps(2 * half[u], pitch);
    const int nv = steps(2 * half[v], pitch);
    for (int i = 0; i <= nu; ++i) {
      for (int j = 0; j <= nv; ++j) {
        for (const float side : {-1.F, 1.F}) {
          Eigen::Vector3f p;
          p[axis] = side * half[axis];
          p[u] = half[u] * (2.F * static_cast<float>(i) / static_cast<float>(nu) - 1.F);
          p[v] = half[v] * (2.F * static_cast<float>(j) / static_cast<float>(nv) - 1.F);
          out.push_back(p);
        }
      }
    }
  }
}

void sampleRing(float radius, float z, float pitch, std::vector<Eigen::Vector3f>& out) {
  const int n = steps(2.F * static_cast<float>(M_PI) * radius, pitch);
  for (int i = 0; i < n; ++i) {
    const float angle = 2.F * static_cast<float>(M_PI) * static_cast<float>(i) / static_cast<float>(n);
    out.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
}

void sampleTube(float radius, float half, float pitch, std::vector<Eigen::Vector3f>& out) {
  const int nz = steps(2 * half, pitch);
  for (int i = 0; i <= nz; ++i) {
    sampleRing(radius, half * (2.F * static_cast<float>(i) / static_cast<float>(nz) - 1.F), pitch, out);
  }
}

void sampleCylinder(float radius, float half, float pitch, std::vector<Eigen::Vector3f>& out) {
  sampleTube(radius, half, pitch, out);
  const int nr = steps(radius, pitch);
  for (int i = 0; i < nr; ++i) {
    const float r = radius * static_cast<float>(i) / static_cast<float>(nr);
    sampleRing(r, half, pitch, out);
    sampleRing(r, -half, pitch, out);
  }
}

void sampleCaps(float radius, float half, float pitch, std::vector<Eigen::Vector3f>& out) {
  const int n = steps(0.5F * static_cast<float>(M_PI) * radius, pitch);
  for (int i = 0; i <= n; ++i) {
    const float angle = 0.5F * static_cast<float>(M_PI) * static_cast<float>(i) / static_cast<float>(n);
    for (const float side : {-1.F, 1.F}) {
      sampleRing(radius * std::cos(angle), side * (half + radius * std::sin(angle)), pitch, out);
    }
  }
}

/// What is wrong with a number that must lie in (low, high], or nothing.
std::string sizeFault(const char* what, double value) {
  if (value > 0.0 && value <= kLargestSolid) {
    return "";
  }
  return std::string(what) + " " + std::to_string(value) + " m, must be above 0 and at most " +
         std::to_string(kLargestSolid) + " m";
}

}  // namespace

std::string poseFault(const Eigen::Isometry3d& pose) {
  if (!pose.matrix().allFinite()) {
    return "the pose is not finite";
  }
  const double farthest = pose.translation().cwiseAbs().maxCoeff();
  return farthest <= kFarthestPose ? ""
                                   : "the position is " + std::to_string(farthest) + " m off on an axis, at most " +
                                         std::to_string(kFarthestPose) + " m";
}

std::string solidFault(const Solid& solid) {
  std::string fault;
  switch (solid.shape) {
    case Solid::Shape::kSphere:
      fault = sizeFault("radius", solid.size.x());
      break;
    case Solid::Shape::kCylinder:
    case Solid::Shape::kCapsule:
      fault = sizeFault("radius", solid.size.x());
      fault += fault.empty() ? sizeFault("length", solid.size.z()) : "";
      break;
    case Solid::Shape::kBox:
      for (int axis = 0; axis < 3 && fault.empty(); ++axis) {
        fault = sizeFault("edge", solid.size[axis]);
      }
      break;
  }
  return fault.empty() ? poseFault(solid.T_frame_solid) : fault;
}

SurfaceDistance surfaceDistance(Solid::Shape shape, const Eigen::Vector3f& size, const Eigen::Vector3f& point) {
  return solid_math::distance(shape, size, point);
}

float rayEntry(Solid::Shape shape, const Eigen::Vector3f& size, const Eigen::Vector3f& origin,
               const Eigen::Vector3f& direction) {
  const float half = 0.5F * size.z();
  const Eigen::Vector3f cap(0.F, 0.F, half);
  switch (shape) {
    case Solid::Shape::kSphere:
      return enterRound(size.x(), origin, direction);
    case Solid::Shape::kCylinder:
      return enterCylinder(size.x(), half, origin, direction);
    case Solid::Shape::kCapsule:
      return std::min({enterTube(size.x(), half, origin, direction), enterRound(size.x(), origin - cap, direction),
                       enterRound(size.x(), origin + cap, direction)});
    case Solid::Shape::kBox:
      break;
  }
  return enterBox(0.5F * size, origin, direction);
}

Eigen::Vector3f halfExtents(Solid::Shape shape, const Eigen::Vector3f& size) {
  switch (shape) {
    case Solid::Shape::kSphere:
      return Eigen::Vector3f::Constant(size.x());
    case Solid::Shape::kCylinder:
      return {size.x(), size.x(), 0.5F * size.z()};
    case Solid::Shape::kCapsule:
      return {size.x(), size.x(), 0.5F * size.z() + size.x()};
    case Solid::Shape::kBox:
      break;
  }
  return 0.5F * size;
}

std::vector<Eigen::Vector3f> sampleSurface(Solid::Shape shape, const Eigen::Vector3f& size, float pitch) {
  std::vector<Eigen::Vector3f> out;
  const float half = 0.5F * size.z();
  switch (shape) {
    case Solid::Shape::kSphere:
      sampleCaps(size.x(), 0.F, pitch, out);
      break;
    case Solid::Shape::kCylinder:
      sampleCylinder(size.x(), half, pitch, out);
      break;
    case Solid::Shape::kCapsule:
      sampleTube(size.x(), half, pitch, out);
      sampleCaps(size.x(), half, pitch, out);
      break;
    case Solid::Shape::kBox:
      sampleBox(0.5F * size, pitch, out);
      break;
  }
  return out;
}

}  // namespace yarm::perception
