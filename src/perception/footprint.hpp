// The rectangle in which something small lies, from the points on it and those beside it.
#pragma once

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace yarm::perception {

/// A rectangle on the ground, seen from above.
struct Footprint {
  Eigen::Vector2f middle{0.F, 0.F};  ///< metres, world
  float axis_rad{0.F};               ///< direction of its longer side, (-pi/2, pi/2]
  float length{0.F};                 ///< along that side, metres
  float width{0.F};                  ///< across it, metres
};

/// The smallest rectangle with all of `on` in it and as few of `beside` as can be; each edge lies half-way between the
/// outermost point on the thing and the next one beside it, or half a `pitch` out where there is none that near. So it
/// is told better than the points lie apart. Empty without a point on it. O(points) for each of some ninety directions.
[[nodiscard]] std::optional<Footprint> footprintOf(const std::vector<Eigen::Vector2f>& on,
                                                   const std::vector<Eigen::Vector2f>& beside, float pitch);

}  // namespace yarm::perception
