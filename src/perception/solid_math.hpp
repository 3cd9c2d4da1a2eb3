// Distances to solids, for inlining into the loop over all points.
#pragma once

#include "yarm/perception/solids.hpp"

#include <algorithm>
#include <cmath>

namespace yarm::perception::solid_math {

constexpr float kTiny = 1e-6F;

inline SurfaceDistance boxDistance(const Eigen::Vector3f& half, const Eigen::Vector3f& p) {
  const Eigen::Vector3f q = p.cwiseAbs() - half;
  const Eigen::Vector3f sign(p.x() < 0 ? -1.F : 1.F, p.y() < 0 ? -1.F : 1.F, p.z() < 0 ? -1.F : 1.F);
  const Eigen::Vector3f out = q.cwiseMax(0.F);
  const float d = out.norm();
  if (d > kTiny) {
    return {d, (out / d).cwiseProduct(sign)};
  }
  int axis = 0;
  const float inside = q.maxCoeff(&axis);
  SurfaceDistance result{inside, Eigen::Vector3f::Zero()};
  result.normal[axis] = sign[axis];
  return result;
}

inline SurfaceDistance sphereDistance(float radius, const Eigen::Vector3f& p) {
  const float length = p.norm();
  return {length - radius, length > kTiny ? Eigen::Vector3f(p / length) : Eigen::Vector3f::UnitZ()};
}

inline SurfaceDistance cylinderDistance(float radius, float half, const Eigen::Vector3f& p) {
  const float rho = std::sqrt(p.x() * p.x() + p.y() * p.y());
  const Eigen::Vector3f radial =
      rho > kTiny ? Eigen::Vector3f(p.x() / rho, p.y() / rho, 0.F) : Eigen::Vector3f::UnitX();
  const Eigen::Vector3f axial(0.F, 0.F, p.z() < 0 ? -1.F : 1.F);
  const float dr = rho - radius;
  const float dz = std::abs(p.z()) - half;
  const float out_r = std::max(dr, 0.F);
  const float out_z = std::max(dz, 0.F);
  const float d = std::sqrt(out_r * out_r + out_z * out_z);
  if (d > kTiny) {
    return {d, (out_r * radial + out_z * axial) / d};
  }
  return dr > dz ? SurfaceDistance{dr, radial} : SurfaceDistance{dz, axial};
}

inline SurfaceDistance capsuleDistance(float radius, float half, const Eigen::Vector3f& p) {
  return sphereDistance(radius, {p.x(), p.y(), p.z() - std::clamp(p.z(), -half, half)});
}

/// Distance of a point (solid's own frame) to the surface of a solid.
inline SurfaceDistance distance(Solid::Shape shape, const Eigen::Vector3f& size, const Eigen::Vector3f& point) {
  switch (shape) {
    case Solid::Shape::kSphere:
      return sphereDistance(size.x(), point);
    case Solid::Shape::kCylinder:
      return cylinderDistance(size.x(), 0.5F * size.z(), point);
    case Solid::Shape::kCapsule:
      return capsuleDistance(size.x(), 0.5F * size.z(), point);
    case Solid::Shape::kBox:
      break;
  }
  return boxDistance(0.5F * size, point);
}

}  // namespace yarm::perception::solid_math
