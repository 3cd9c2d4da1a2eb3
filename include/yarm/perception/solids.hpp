// Geometry of known solids: distance, nearest surface point, which cells lie inside.
#pragma once

#include "yarm/perception/types.hpp"

#include <string>
#include <vector>

namespace yarm::perception {

inline constexpr double kLargestSolid = 20.0;     ///< edge, radius or length beyond which a solid is absurd, metres
inline constexpr double kFarthestPose = 10000.0;  ///< coordinate beyond which a pose is absurd, metres

/// What makes a pose absurd, with the number and the limit; empty when nothing does.
[[nodiscard]] std::string poseFault(const Eigen::Isometry3d& pose);

/// What makes a solid absurd, with the number and the limit; empty when nothing does.
[[nodiscard]] std::string solidFault(const Solid& solid);

/// Distance of a point to a solid's surface and the way there, in the solid's own frame.
struct SurfaceDistance {
  float distance{0};  ///< metres, negative inside
  Eigen::Vector3f normal{
      Eigen::Vector3f::UnitZ()};  ///< outward unit vector: the point minus distance * normal is on the surface
};

/// Distance of a point (solid's own frame) to the surface of a solid.
[[nodiscard]] SurfaceDistance surfaceDistance(Solid::Shape shape, const Eigen::Vector3f& size,
                                              const Eigen::Vector3f& point);

/// Where a ray first enters a solid (solid's own frame): the multiple of `direction` from `origin`, +inf when it misses
/// or when the origin lies inside.
[[nodiscard]] float rayEntry(Solid::Shape shape, const Eigen::Vector3f& size, const Eigen::Vector3f& origin,
                             const Eigen::Vector3f& direction);

/// Half extents of the smallest axis-aligned box (solid's own frame) around a solid, metres.
[[nodiscard]] Eigen::Vector3f halfExtents(Solid::Shape shape, const Eigen::Vector3f& size);

/// Points on the surface of a solid (solid's own frame) no farther apart than about `pitch` metres.
[[nodiscard]] std::vector<Eigen::Vector3f> sampleSurface(Solid::Shape shape, const Eigen::Vector3f& size, float pitch);

}  // namespace yarm::perception
