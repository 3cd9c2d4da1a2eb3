// A scan as points with the normals of the surfaces they lie on.
#pragma once

#include "yarm/slam/params.hpp"
#include "yarm/slam/types.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <vector>

namespace yarm::slam {

/// A point on a surface, in the sensor's frame.
struct SurfacePoint {
  float x{0}, y{0};    ///< on the fitted line, metres
  float nx{0}, ny{0};  ///< unit normal, towards the sensor
  float sigma{0};      ///< standard deviation along the ray, metres
};

/// The points of one scan in the order of their bearings, with a look-up by bearing. Not changed once made.
class ScanPoints {
 public:
  ScanPoints() = default;
  /// Points of a scan; beams without a line through them and their neighbours are left out. O(beams x window).
  ScanPoints(const Scan& scan, const ScanParams& params);

  [[nodiscard]] const std::vector<SurfacePoint>& points() const { return points_; }
  /// Whether a point (sensor's frame) would have been seen: inside the field of view and not behind what was.
  [[nodiscard]] bool inView(const Eigen::Vector2d& point) const;
  /// Nearest point no farther than `gate` whose normal has at least this cosine to `normal`; -1 if there is none.
  [[nodiscard]] int nearest(const Eigen::Vector2d& point, const Eigen::Vector2d& normal, double gate,
                            double normals_dot) const;

 private:
  [[nodiscard]] double binOf(const Eigen::Vector2d& point) const;

  std::vector<SurfacePoint> points_;
  std::vector<std::int16_t> point_of_bin_;  ///< index into points_, -1: none
  std::vector<float> range_of_bin_;         ///< metres, NaN: nothing seen
  double first_bearing_{0};
  double bin_width_{1};
};

/// Standard deviation of a range, metres.
[[nodiscard]] inline double rangeSigma(const ScanParams& params, double range) {
  return params.sigma_base + params.sigma_slope * range * range;
}

/// The range of a beam with the sensor's bias taken out, or nothing when it saw nothing.
[[nodiscard]] std::optional<double> usableRange(const Scan& scan, std::size_t beam, const ScanParams& params);

/// Why a scan cannot be used at all (no beams, limits or odometry that are not finite, ...); empty when it can.
[[nodiscard]] std::string faultOf(const Scan& scan);

}  // namespace yarm::slam
