#include "yarm/slam/match.hpp"

#include <Eigen/Cholesky>

#include <algorithm>

namespace yarm::slam {

namespace {

constexpr double kGateRate = 0.7;     // the gate of an iteration, as a share of the one before
constexpr double kConvergedM = 2e-4;  // m, rad: a smaller step at the last gate ends the iteration
constexpr double kWeakSigma = 0.1;    // m, rad: pull towards the start when there is no prior
constexpr int kOverlapStride = 4;

struct NormalEquations {
  Eigen::Matrix3d hessian{Eigen::Matrix3d::Zero()};
  Eigen::Vector3d gradient{Eigen::Vector3d::Zero()};
  double squares{0};  // of the normalised residuals
  int pairs{0};
  int in_view{0};
  int paired{0};
};

// Adds the pairs of one point; true when it found one.
class PairAdder {
 public:
  PairAdder(const std::vector<MatchTarget>& targets, const Pose2& pose, const MatchParams& params)
      : targets_(targets), pose_(pose), params_(params) {
    for (const MatchTarget& target : targets) {
      const Pose2 relative = target.T_map_sensor.inverse() * pose;
      relative_.push_back({relative, std::cos(relative.yaw), std::sin(relative.yaw), std::cos(target.T_map_sensor.yaw),
                           std::sin(target.T_map_sensor.yaw)});
    }
    cos_ = std::cos(pose.yaw);
    sin_ = std::sin(pose.yaw);
  }

  void add(const SurfacePoint& point, double gate, NormalEquations& sums) const {
    bool in_view = false;
    bool paired = false;
    for (std::size_t k = 0; k < targets_.size(); ++k) {
      const Relative& relative = relative_[k];
      const ScanPoints& other = *targets_[k].points;
      const Eigen::Vector2d at{relative.pose.x + relative.cos * point.x - relative.sin * point.y,
                               relative.pose.y + relative.sin * point.x + relative.cos * point.y};
      const Eigen::Vector2d normal{relative.cos * point.nx - relative.sin * point.ny,
                                   relative.sin * point.nx + relative.cos * point.ny};
      const int partner = other.nearest(at, normal, gate, params_.normals_dot);
      in_view = in_view || partner >= 0 || other.inView(at);
      if (partner >= 0) {
        paired = true;
        addPair(point, at, other.points()[partner], relative, sums);
      }
    }
    sums.in_view += in_view ? 1 : 0;
    sums.paired += paired ? 1 : 0;
  }

 private:
  struct Relative {
    Pose2 pose;  // of the scan's sensor in the target's
    double cos, sin;
    double target_cos, target_sin;
  };

  void addPair(const SurfacePoint& point, const Eigen::Vector2d& at, const SurfacePoint& partner,
               const Relative& relative, NormalEquations& sums) const {
    const double variance = point.sigma * point.sigma + partner.sigma * partner.sigma;
    const double distance = partner.nx * (at.x() - partner.x) + partner.ny * (at.y() - partner.y);
    const double squared = distance * distance / variance;
    const double weight = 1.0 / (variance * (1.0 + squared / (params_.cauchy * params_.cauchy)));
    const Eigen::Vector2d normal{relative.target_cos * partner.nx - relative.target_sin * partner.ny,
                                 relative.target_sin * partner.nx + relative.target_cos * partner.ny};
    const Eigen::Vector2d arm{-sin_ * point.x - cos_ * point.y, cos_ * point.x - sin_ * point.y};
    const Eigen::Vector3d jacobian{normal.x(), normal.y(), normal.dot(arm)};
    sums.hessian.noalias() += weight * jacobian * jacobian.transpose();
    sums.gradient.noalias() += weight * distance * jacobian;
    sums.squares += squared;
    ++sums.pairs;
  }

  const std::vector<MatchTarget>& targets_;
  Pose2 pose_;
  const MatchParams& params_;
  std::vector<Relative> relative_;
  double cos_{1};
  double sin_{0};
};

NormalEquations linearise(const ScanPoints& scan, const Pose2& pose, const std::vector<MatchTarget>& targets,
                          double gate, const MatchParams& params) {
  const PairAdder adder(targets, pose, params);
  NormalEquations sums;
  for (const SurfacePoint& point : scan.points()) {
    adder.add(point, gate, sums);
  }
  sums.hessian /= params.information_divisor;
  sums.gradient /= params.information_divisor;
  return sums;
}

Eigen::Vector3d difference(const Pose2& a, const Pose2& b) {
  return {a.x - b.x, a.y - b.y, wrapAngle(a.yaw - b.yaw)};
}

PosePrior weakPrior(const Pose2& start) {
  return {start, Eigen::Matrix3d::Identity() / (kWeakSigma * kWeakSigma)};
}

void judge(const NormalEquations& sums, const MatchParams& params, MatchResult& result) {
  result.information = sums.hessian;
  result.in_view = sums.in_view;
  result.paired = sums.paired;
  result.residual = sums.pairs > 0 ? std::sqrt(sums.squares / sums.pairs) : 0.0;
  result.ok = sums.pairs > 0 && result.share() >= params.least_paired;
  if (!result.ok) {
    result.reason =
        std::to_string(result.paired) + " of " + std::to_string(result.in_view) + " points in view found a partner";
  }
}

}  // namespace

MatchResult matchScan(const ScanPoints& scan, const Pose2& start, const std::vector<MatchTarget>& targets,
                      const std::optional<PosePrior>& prior, const MatchParams& params) {
  const PosePrior pull = prior ? *prior : weakPrior(start);
  MatchResult result;
  result.T_map_sensor = start;
  double gate = params.gate_first;
  NormalEquations sums;
  for (result.iterations = 1;; ++result.iterations) {
    sums = linearise(scan, result.T_map_sensor, targets, gate, params);
    if (sums.pairs == 0) {
      break;
    }
    const Eigen::Matrix3d hessian = sums.hessian + pull.information;
    const Eigen::Vector3d gradient = sums.gradient + pull.information * difference(result.T_map_sensor, pull.pose);
    const Eigen::Vector3d step = hessian.ldlt().solve(-gradient);
    Pose2& pose = result.T_map_sensor;
    pose = {pose.x + step.x(), pose.y + step.y(), wrapAngle(pose.yaw + step.z())};
    const bool is_last_gate = gate <= params.gate_last;
    if ((is_last_gate && step.cwiseAbs().maxCoeff() < kConvergedM) || result.iterations >= params.iterations) {
      break;
    }
    gate = std::max(params.gate_last, gate * kGateRate);
  }
  judge(sums, params, result);
  return result;
}

double overlapOf(const ScanPoints& scan, const Pose2& T_map_sensor, const MatchTarget& target) {
  const Pose2 relative = target.T_map_sensor.inverse() * T_map_sensor;
  int total = 0;
  int seen = 0;
  for (std::size_t i = 0; i < scan.points().size(); i += kOverlapStride) {
    const SurfacePoint& point = scan.points()[i];
    ++total;
    seen += target.points->inView(relative * Eigen::Vector2d{point.x, point.y}) ? 1 : 0;
  }
  return total > 0 ? static_cast<double>(seen) / total : 0.0;
}

}  // namespace yarm::slam
