#include "yarm/slam/scan_points.hpp"

#include <algorithm>
#include <limits>

namespace yarm::slam {

namespace {

constexpr double kMostBearing = 4.0 * M_PI;  // rad
constexpr std::size_t kMostBeams = 20000;
constexpr int kMostMissing = 3;  // beams without a range that a line may pass over
constexpr double kRadiusSigmas =
    4.0;  // a line is fitted over line_radius and so many sigmas: far points need longer ones
constexpr double kOcclusionMargin = 0.15;  // m: a point this far behind what was seen still counts as in view

using Vec2 = Eigen::Vector2d;

// Sums of points relative to the one whose line is sought.
struct LineSums {
  int count{0};
  Vec2 sum{Vec2::Zero()};
  double xx{0}, xy{0}, yy{0};

  void add(const Vec2& d) {
    ++count;
    sum += d;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
};

struct Line {
  Vec2 mean;
  Vec2 normal;
  double residual;  // root mean square, metres
};

// Total least squares: the normal is the direction of least variance.
Line fit(const LineSums& sums) {
  const double n = sums.count;
  const Vec2 mean = sums.sum / n;
  const double xx = sums.xx / n - mean.x() * mean.x();
  const double xy = sums.xy / n - mean.x() * mean.y();
  const double yy = sums.yy / n - mean.y() * mean.y();
  const double along = 0.5 * std::atan2(2.0 * xy, xx - yy);
  const double least = 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy);
  return {mean, {-std::sin(along), std::cos(along)}, std::sqrt(std::max(0.0, least))};
}

// The beams of a scan as points, NaN where nothing was seen.
class Beams {
 public:
  Beams(const Scan& scan, const ScanParams& params) : params_(params) {
    const auto count = scan.ranges.size();
    points_.resize(count);
    ranges_.assign(count, std::numeric_limits<double>::quiet_NaN());
    for (std::size_t beam = 0; beam < count; ++beam) {
      const auto range = usableRange(scan, beam, params);
      if (range && *range <= params.use_range) {
        const double bearing = scan.angle_min + static_cast<double>(beam) * scan.angle_increment;
        ranges_[beam] = *range;
        points_[beam] = {*range * std::cos(bearing), *range * std::sin(bearing)};
      }
    }
  }

  [[nodiscard]] bool seen(int beam) const { return ranges_[beam] == ranges_[beam]; }
  [[nodiscard]] double range(int beam) const { return ranges_[beam]; }

  [[nodiscard]] std::optional<SurfacePoint> surfaceAt(int beam) const {
    const double sigma = rangeSigma(params_, ranges_[beam]);
    LineSums sums;
    sums.add(Vec2::Zero());
    walk(beam, -1, sigma, sums);
    walk(beam, 1, sigma, sums);
    if (sums.count < params_.line_points) {
      return std::nullopt;
    }
    const Line line = fit(sums);
    if (line.residual > params_.line_residual * sigma) {
      return std::nullopt;
    }
    const Vec2 point = points_[beam] + line.normal * line.normal.dot(line.mean);
    const double side = line.normal.dot(point) > 0.0 ? -1.0 : 1.0;
    const Vec2f p = point.cast<float>();
    const Vec2f n = (side * line.normal).cast<float>();
    return SurfacePoint{p.x(), p.y(), n.x(), n.y(), static_cast<float>(sigma)};
  }

 private:
  using Vec2f = Eigen::Vector2f;

  void walk(int beam, int step, double sigma, LineSums& sums) const {
    const double radius = params_.line_radius + kRadiusSigmas * sigma;
    const double gap = params_.line_gap + kRadiusSigmas * sigma;
    int last = beam;
    for (int i = beam + step; i >= 0 && i < static_cast<int>(ranges_.size()); i += step) {
      if (!seen(i)) {
        if (std::abs(i - last) > kMostMissing) {
          return;
        }
        continue;
      }
      const Vec2 away = points_[i] - points_[beam];
      if (away.squaredNorm() > radius * radius || (points_[i] - points_[last]).squaredNorm() > gap * gap) {
        return;
      }
      sums.add(away);
      last = i;
    }
  }

  const ScanParams& params_;
  std::vector<Vec2> points_;
  std::vector<double> ranges_;
};

std::string faultOfPlace(const Pose2& pose, const std::string& what) {
  if (!pose.isFinite()) {
    return what + " is not finite";
  }
  const double far = std::max(std::abs(pose.x), std::abs(pose.y));
  return far <= kMostFar
             ? ""
             : what + " is " + std::to_string(far) + " m off on an axis, at most " + std::to_string(kMostFar);
}

}  // namespace

std::optional<double> usableRange(const Scan& scan, std::size_t beam, const ScanParams& params) {
  const double range = scan.ranges[beam];
  if (!(range >= scan.range_min && range <= scan.range_max)) {
    return std::nullopt;
  }
  return range + params.bias_slope * range * range;
}

std::string faultOf(const Scan& scan) {
  if (scan.ranges.empty()) {
    return "the scan has no beams";
  }
  if (scan.ranges.size() > kMostBeams) {
    return "the scan has " + std::to_string(scan.ranges.size()) + " beams, at most " + std::to_string(kMostBeams) +
           " are taken";
  }
  if (!std::isfinite(scan.angle_min) || !std::isfinite(scan.angle_increment) || scan.angle_increment == 0.0) {
    return "the scan's angle_min and angle_increment must be finite, the increment not 0";
  }
  if (std::abs(scan.angle_increment) * static_cast<double>(scan.ranges.size()) > 2.0 * M_PI + 0.1) {
    return "the scan's beams go round more than once; is angle_increment in radians?";
  }
  if (!(scan.range_min >= 0.0) || !(scan.range_max > scan.range_min)) {
    return "the scan's range_min must be at least 0 and range_max above it";
  }
  if (std::abs(scan.angle_min) > kMostBearing) {
    return "the scan's angle_min is " + std::to_string(scan.angle_min) + " rad, at most " +
           std::to_string(kMostBearing) + "; is it in radians?";
  }
  const std::string fault = faultOfPlace(scan.T_base_sensor, "the sensor's pose on the robot");
  return fault.empty() ? faultOfPlace(scan.T_odom_base, "the odometry's pose") : fault;
}

ScanPoints::ScanPoints(const Scan& scan, const ScanParams& params) {
  const Beams beams(scan, params);
  const int count = static_cast<int>(scan.ranges.size());
  const bool clockwise = scan.angle_increment < 0.0;
  const int stride = std::max(1, params.stride);
  const int bins = (count + stride - 1) / stride;
  bin_width_ = std::abs(scan.angle_increment) * stride;
  first_bearing_ = clockwise ? scan.angle_min + (count - 1) * scan.angle_increment : scan.angle_min;
  point_of_bin_.assign(bins, -1);
  range_of_bin_.assign(bins, std::numeric_limits<float>::quiet_NaN());
  for (int bin = 0; bin < bins; ++bin) {
    const int beam = clockwise ? count - 1 - bin * stride : bin * stride;
    if (!beams.seen(beam)) {
      continue;
    }
    range_of_bin_[bin] = static_cast<float>(beams.range(beam));
    if (const auto point = beams.surfaceAt(beam)) {
      point_of_bin_[bin] = static_cast<std::int16_t>(points_.size());
      points_.push_back(*point);
    }
  }
}

double ScanPoints::binOf(const Eigen::Vector2d& point) const {
  const double bearing = std::atan2(point.y(), point.x()) - first_bearing_;
  return (bearing < -M_PI ? bearing + 2.0 * M_PI : bearing) / bin_width_;
}

bool ScanPoints::inView(const Eigen::Vector2d& point) const {
  const int bin = static_cast<int>(std::lround(binOf(point)));
  if (bin < 0 || bin >= static_cast<int>(range_of_bin_.size())) {
    return false;
  }
  return point.norm() <= range_of_bin_[bin] + kOcclusionMargin;
}

int ScanPoints::nearest(const Eigen::Vector2d& point, const Eigen::Vector2d& normal, double gate,
                        double normals_dot) const {
  const double range = point.norm();
  const double reach = gate < range ? gate / range / bin_width_ : 0.0;
  const double bin = binOf(point);
  const double last_bin = static_cast<double>(point_of_bin_.size()) - 1.0;
  if (bin + reach < 0.0 || bin - reach > last_bin || range <= gate) {
    return -1;
  }
  const int from = static_cast<int>(std::max(0.0, std::ceil(bin - reach)));
  const int to = static_cast<int>(std::min(last_bin, std::floor(bin + reach)));
  int best = -1;
  double least = gate * gate;
  for (int i = from; i <= to; ++i) {
    const int index = point_of_bin_[i];
    if (index < 0) {
      continue;
    }
    const SurfacePoint& other = points_[index];
    const double dx = other.x - point.x();
    const double dy = other.y - point.y();
    const double squared = dx * dx + dy * dy;
    if (squared < least && other.nx * normal.x() + other.ny * normal.y() >= normals_dot) {
      least = squared;
      best = index;
    }
  }
  return best;
}

}  // namespace yarm::slam
