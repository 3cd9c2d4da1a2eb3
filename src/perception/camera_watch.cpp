#include "yarm/perception/camera_watch.hpp"

#include "scene_model.hpp"
#include "yarm/perception/solids.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace yarm::perception {

namespace {

constexpr float kNear = 0.12F;             // farther from a static surface a point says nothing, metres
constexpr float kMovingReach = 0.10F;      // nearer to a moving body a point may be that body's, metres
constexpr float kAboveFloor = 0.2F;        // lower points may be the floor, metres
constexpr std::size_t kPointsASet = 2000;  // looked at of each camera, about
constexpr std::size_t kLeastPoints = 200;  // for a fit
constexpr float kModelDeviation = 0.005F;  // of the surfaces themselves, metres
constexpr double kPriorDeviation = 0.02;   // of a turn before anything is seen, radians
constexpr std::array<float, 3> kTrims{0.12F, 0.06F, 0.04F};  // residuals beyond this are others' points, metres
constexpr double kDegree = M_PI / 180.0;

Eigen::Vector3f positionOf(const MergedPoint& p) {
  return {p.x, p.y, p.z};
}

float median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

/// The known solids of a set, and which objects are static.
struct CameraWatch::Model {
  SceneModel solids{AssociationParams()};
  std::vector<char> is_static;
  std::vector<char> is_moving;

  void build(const AssociationInput& input) {
    solids.clear();
    is_static.clear();
    is_moving.clear();
    for (const Seed& seed : *input.seeds) {
      is_static.push_back(seed.is_static && seed.object == ObjectKind::kObstacle ? 1 : 0);
      is_moving.push_back(seed.object != ObjectKind::kTarget && is_static.back() == 0 ? 1 : 0);
      const auto known = input.knowledge->find(seed.name);
      if (known == input.knowledge->end() || seed.object == ObjectKind::kTarget) {
        continue;
      }
      for (const Solid& solid : known->second.solids) {
        const auto pose = input.links->find(solid.frame);
        if (pose != input.links->end() && solidFault(solid).empty()) {
          solids.add(static_cast<int>(is_static.size()) - 1, solid, pose->second * solid.T_frame_solid);
        }
      }
    }
  }
};

CameraWatch::CameraWatch() : model_(std::make_unique<Model>()) {}
CameraWatch::~CameraWatch() = default;

void CameraWatch::add(const AssociationInput& input) {
  model_->build(input);
  std::map<std::int32_t, std::size_t> count;
  for (const MergedPoint& p : input.set->points) {
    ++count[p.camera];
  }
  std::map<std::int32_t, std::size_t> passed;
  for (const MergedPoint& p : input.set->points) {
    if (passed[p.camera]++ % (1 + count[p.camera] / kPointsASet) != 0) {
      continue;
    }
    if (p.z < kAboveFloor) {
      continue;
    }
    const Explanation near = model_->solids.nearest(positionOf(p), model_->is_static, kNear);
    if (near.piece < 0 || near.distance < -kNear ||
        model_->solids.nearest(positionOf(p), model_->is_moving, kMovingReach).piece >= 0) {
      continue;
    }
    const Eigen::Vector3f ray(p.ux, p.uy, p.uz);
    const float across = p.sigma * std::abs(ray.dot(near.normal));
    const float inverse = 1.F / std::sqrt(across * across + kModelDeviation * kModelDeviation);
    samples_[p.camera].push_back({positionOf(p), ray, near.normal, near.distance, inverse});
  }
}

CameraFit CameraWatch::fit(std::int32_t camera, const std::vector<Sample>& samples) {
  // The camera is where the rays meet.
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  std::vector<float> off;
  for (const Sample& s : samples) {
    const Eigen::Vector3d u = s.ray.cast<double>();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - u * u.transpose();
    sum += across;
    right += across * s.point.cast<double>();
    off.push_back(std::abs(s.distance));
  }
  const Eigen::Vector3d centre = sum.ldlt().solve(right);
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  double moved = 0.0;  // mean square of what the turn moves points by across the surfaces, square metres
  for (const float trim : kTrims) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Identity() / (kPriorDeviation * kPriorDeviation);
    Eigen::Matrix3d arms = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    std::size_t near = 0;
    for (const Sample& s : samples) {
      const Eigen::Vector3d arm = (s.point.cast<double>() - centre).cross(s.normal.cast<double>());
      if (std::abs(s.distance - turn.dot(arm)) <= trim) {
        const double weight = static_cast<double>(s.inverse_deviation) * s.inverse_deviation;
        normal += weight * arm * arm.transpose();
        arms += arm * arm.transpose();
        gradient += weight * s.distance * arm;
        ++near;
      }
    }
    turn = normal.ldlt().solve(gradient);
    moved = near > 0 ? turn.dot(arms * turn) / static_cast<double>(near) : 0.0;
  }
  if (moved < kModelDeviation * kModelDeviation) {
    turn.setZero();  // the surfaces themselves may be off by so much
  }
  return {camera, samples.size(), median(std::move(off)), turn.norm() / kDegree};
}

std::vector<CameraFit> CameraWatch::take() {
  std::vector<CameraFit> fits;
  for (const auto& [camera, samples] : samples_) {
    if (samples.size() >= kLeastPoints) {
      fits.push_back(fit(camera, samples));
    }
  }
  samples_.clear();
  return fits;
}

}  // namespace yarm::perception
