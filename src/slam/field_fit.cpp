#include "yarm/slam/field_fit.hpp"

#include "yarm/slam/scan_points.hpp"

#include <Eigen/Cholesky>

#include <algorithm>

namespace yarm::slam {

namespace {

constexpr double kGateRate = 0.6;     // the gate of an iteration, as a share of the one before
constexpr double kConvergedM = 5e-4;  // m, rad: a smaller step at the last gate ends the iteration
constexpr double kWeakSigma = 0.5;    // m, rad: pull towards the start when there is no prior

struct Sums {
  Eigen::Matrix3d hessian{Eigen::Matrix3d::Zero()};
  Eigen::Vector3d gradient{Eigen::Vector3d::Zero()};
  int agreeing{0};
};

Sums linearise(const std::vector<SeenPoint>& points, const Pose2& pose, const DistanceField& field, double gate,
               const FitParams& params) {
  const double c = std::cos(pose.yaw);
  const double s = std::sin(pose.yaw);
  const double map_variance = params.sigma_map * params.sigma_map;
  Sums sums;
  for (const SeenPoint& point : points) {
    const Eigen::Vector2d arm{c * point.at.x() - s * point.at.y(), s * point.at.x() + c * point.at.y()};
    const FieldSample sample = field.at(Eigen::Vector2d{pose.x, pose.y} + arm);
    sums.agreeing += sample.distance < params.gate_last ? 1 : 0;
    if (sample.distance >= gate) {
      continue;
    }
    const double variance = point.sigma * point.sigma + map_variance;
    const double squared = sample.distance * sample.distance / variance;
    const double weight = 1.0 / (variance * (1.0 + squared / (params.cauchy * params.cauchy)));
    const Eigen::Vector3d jacobian{sample.gradient.x(), sample.gradient.y(),
                                   sample.gradient.y() * arm.x() - sample.gradient.x() * arm.y()};
    sums.hessian.noalias() += weight * jacobian * jacobian.transpose();
    sums.gradient.noalias() += weight * sample.distance * jacobian;
  }
  sums.hessian /= params.information_divisor;
  sums.gradient /= params.information_divisor;
  return sums;
}

}  // namespace

FitResult fitToField(const std::vector<SeenPoint>& points, const Pose2& start, const DistanceField& field,
                     const std::optional<PosePrior>& prior, const FitParams& params) {
  const PosePrior pull = prior ? *prior : PosePrior{start, Eigen::Matrix3d::Identity() / (kWeakSigma * kWeakSigma)};
  FitResult result;
  result.pose = start;
  result.points = static_cast<int>(points.size());
  double gate = params.gate_first;
  for (int iteration = 1;; ++iteration) {
    const Sums sums = linearise(points, result.pose, field, gate, params);
    result.information = sums.hessian;
    result.agreeing = sums.agreeing;
    const bool is_last_gate = gate <= params.gate_last;
    if (iteration > params.iterations) {
      return result;
    }
    const Eigen::Vector3d away{result.pose.x - pull.pose.x, result.pose.y - pull.pose.y,
                               wrapAngle(result.pose.yaw - pull.pose.yaw)};
    const Eigen::Vector3d step =
        (sums.hessian + pull.information).ldlt().solve(-(sums.gradient + pull.information * away));
    result.pose = {result.pose.x + step.x(), result.pose.y + step.y(), wrapAngle(result.pose.yaw + step.z())};
    if (is_last_gate && step.cwiseAbs().maxCoeff() < kConvergedM) {
      return result;
    }
    gate = std::max(params.gate_last, gate * kGateRate);
  }
}

std::vector<SeenPoint> seenPoints(const Scan& scan, const ScanParams& params, int most) {
  std::vector<SeenPoint> points;
  const std::size_t stride = std::max<std::size_t>(1, scan.ranges.size() / static_cast<std::size_t>(most));
  points.reserve(scan.ranges.size() / stride + 1);
  const double c = std::cos(scan.T_base_sensor.yaw);
  const double s = std::sin(scan.T_base_sensor.yaw);
  for (std::size_t beam = stride / 2; beam < scan.ranges.size(); beam += stride) {
    const auto range = usableRange(scan, beam, params);
    if (!range || *range > params.use_range) {
      continue;
    }
    const double bearing = scan.angle_min + static_cast<double>(beam) * scan.angle_increment;
    const double x = *range * std::cos(bearing);
    const double y = *range * std::sin(bearing);
    points.push_back(
        {{scan.T_base_sensor.x + c * x - s * y, scan.T_base_sensor.y + s * x + c * y}, rangeSigma(params, *range)});
  }
  return points;
}

}  // namespace yarm::slam
