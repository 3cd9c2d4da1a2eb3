// Distances to solids, for inlining into the loops over all points: of one point (T = float), or of four at once.
#pragma once

#include "yarm/perception/solids.hpp"

#include <cmath>
#include <cstdint>
#include <limits>

namespace yarm::perception::solid_math {

constexpr float kTiny = 1e-6F;

/// Four values, one a point: the compiler's own vectors, so that it is fast on any processor.
using Four = float __attribute__((vector_size(16)));

template <typename T>
struct Vector {
  T x, y, z;
};

using FourVectors = Vector<Four>;

/// Distance and outward normal.
template <typename T>
struct Surface {
  T distance;
  Vector<T> normal;
};

template <typename T>
inline T larger(const T& a, const T& b) {
  return a > b ? a : b;
}

template <typename T>
inline T smaller(const T& a, const T& b) {
  return a < b ? a : b;
}

inline float magnitude(float v) {
  return std::abs(v);
}

/// `v` with the sign of `like`; v is not negative.
inline float signedAs(float v, float like) {
  return std::copysign(v, like);
}

using FourBits = std::int32_t __attribute__((vector_size(16)));

inline FourBits signBits() {
  return FourBits{} + std::numeric_limits<std::int32_t>::min();
}

inline Four magnitude(const Four& v) {
  return reinterpret_cast<Four>(reinterpret_cast<FourBits>(v) & ~signBits());
}

inline Four signedAs(const Four& v, const Four& like) {
  return reinterpret_cast<Four>(reinterpret_cast<FourBits>(v) | (reinterpret_cast<FourBits>(like) & signBits()));
}

inline float root(float v) {
  return std::sqrt(v);
}

inline Four root(const Four& v) {
  return Four{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])};
}

template <typename T>
inline T dot(const Vector<T>& a, const Vector<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <typename T>
inline Surface<T> boxDistance(const Eigen::Vector3f& half, const Vector<T>& p) {
  const T zero{};
  const T one = zero + 1.F;
  const Vector<T> q{magnitude(p.x) - half.x(), magnitude(p.y) - half.y(), magnitude(p.z) - half.z()};
  const Vector<T> out{larger(q.x, zero), larger(q.y, zero), larger(q.z, zero)};
  const T outside = root(dot(out, out));
  const T inside = larger(larger(q.x, q.y), q.z);
  const auto is_out = outside > kTiny;
  const T inverse = one / (is_out ? outside : one);
  // Inside, the normal is that of the nearest face.
  const T x_face = q.x >= inside ? one : zero;
  const T y_face = q.y >= inside ? one - x_face : zero;
  const T z_face = one - x_face - y_face;
  const Vector<T> n{is_out ? out.x * inverse : x_face, is_out ? out.y * inverse : y_face,
                    is_out ? out.z * inverse : z_face};
  return {is_out ? outside : inside, {signedAs(n.x, p.x), signedAs(n.y, p.y), signedAs(n.z, p.z)}};
}

template <typename T>
inline Surface<T> sphereDistance(float radius, const Vector<T>& p) {
  const T zero{};
  const T one = zero + 1.F;
  const T length = root(dot(p, p));
  const auto is_off = length > kTiny;
  const T inverse = one / (is_off ? length : one);
  return {length - radius, {p.x * inverse, p.y * inverse, is_off ? p.z * inverse : one}};
}

template <typename T>
inline Surface<T> cylinderDistance(float radius, float half, const Vector<T>& p) {
  const T zero{};
  const T one = zero + 1.F;
  const T rho = root(p.x * p.x + p.y * p.y);
  const auto is_off = rho > kTiny;
  const T inverse = one / (is_off ? rho : one);
  const Vector<T> radial{is_off ? p.x * inverse : one, p.y * inverse, zero};
  const T dr = rho - radius;
  const T dz = magnitude(p.z) - half;
  const T out_r = larger(dr, zero);
  const T out_z = larger(dz, zero);
  const T outside = root(out_r * out_r + out_z * out_z);
  const auto is_out = outside > kTiny;
  const T scale = one / (is_out ? outside : one);
  const T along_r = is_out ? out_r * scale : (dr > dz ? one : zero);
  const T along_z = is_out ? out_z * scale : (dr > dz ? zero : one);
  return {is_out ? outside : larger(dr, dz), {along_r * radial.x, along_r * radial.y, signedAs(along_z, p.z)}};
}

template <typename T>
inline Surface<T> capsuleDistance(float radius, float half, const Vector<T>& p) {
  const T beyond = larger(magnitude(p.z) - half, T{});
  return sphereDistance(radius, Vector<T>{p.x, p.y, signedAs(beyond, p.z)});
}

/// Distance of points (solid's own frame) to the surface of a solid.
template <typename T>
inline Surface<T> distance(Solid::Shape shape, const Eigen::Vector3f& size, const Vector<T>& p) {
  switch (shape) {
    case Solid::Shape::kSphere:
      return sphereDistance(size.x(), p);
    case Solid::Shape::kCylinder:
      return cylinderDistance(size.x(), 0.5F * size.z(), p);
    case Solid::Shape::kCapsule:
      return capsuleDistance(size.x(), 0.5F * size.z(), p);
    case Solid::Shape::kBox:
      break;
  }
  return boxDistance<T>(0.5F * size, p);
}

inline SurfaceDistance distance(Solid::Shape shape, const Eigen::Vector3f& size, const Eigen::Vector3f& point) {
  const Surface<float> s = distance(shape, size, Vector<float>{point.x(), point.y(), point.z()});
  return {s.distance, {s.normal.x, s.normal.y, s.normal.z}};
}

}  // namespace yarm::perception::solid_math
