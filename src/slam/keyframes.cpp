#include "yarm/slam/keyframes.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace yarm::slam {

namespace {
constexpr double kMostTurn = 1.0;  // rad: scans turned further apart share too little of a narrow field of view
constexpr int kSameVisit = 12;     // keyframes closer in number than this belong to one visit
}  // namespace

std::vector<MatchTarget> Keyframes::targets(const std::vector<int>& keyframes) const {
  std::vector<MatchTarget> result;
  for (const int keyframe : keyframes) {
    result.push_back(target(keyframe));
  }
  return result;
}

int Keyframes::add(std::shared_ptr<const ScanPoints> points, const Pose2& T_map_sensor) {
  poses_.push_back(T_map_sensor);
  points_.push_back(std::move(points));
  return size() - 1;
}

bool Keyframes::isAnotherVisit(int a, int b) {
  return std::abs(a - b) >= kSameVisit;
}

void Keyframes::correct(const std::vector<Pose2>& poses) {
  if (poses.empty()) {
    return;
  }
  const std::size_t last = poses.size() - 1;
  const Pose2 shift = poses[last] * poses_[last].inverse();
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    poses_[i] = i <= last ? poses[i] : shift * poses_[i];
  }
}

void Keyframes::visit(int keyframe) {
  trail_.erase(std::remove(trail_.begin(), trail_.end(), keyframe), trail_.end());
  trail_.push_front(keyframe);
  if (static_cast<int>(trail_.size()) > params_.recent) {
    trail_.pop_back();
  }
}

std::vector<int> Keyframes::overlapping(const ScanPoints& scan, const Pose2& T_map_sensor) const {
  std::vector<std::pair<double, int>> found;
  for (int i = 0; i < size(); ++i) {
    if (poses_[i].distanceTo(T_map_sensor) > params_.old_distance ||
        std::abs(wrapAngle(poses_[i].yaw - T_map_sensor.yaw)) > kMostTurn ||
        std::find(trail_.begin(), trail_.end(), i) != trail_.end()) {
      continue;
    }
    const double overlap = overlapOf(scan, T_map_sensor, target(i));
    if (overlap > params_.old_overlap) {
      found.emplace_back(-overlap, i);
    }
  }
  std::sort(found.begin(), found.end());
  std::vector<int> chosen;
  for (const auto& [overlap, keyframe] : found) {
    const bool is_new_visit =
        std::all_of(chosen.begin(), chosen.end(), [&](int other) { return isAnotherVisit(other, keyframe); });
    if (is_new_visit && static_cast<int>(chosen.size()) < params_.old) {
      chosen.push_back(keyframe);
    }
  }
  return chosen;
}

std::optional<int> Keyframes::knownPlace(const Pose2& T_map_sensor) const {
  std::optional<int> best;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < size(); ++i) {
    const double away = poses_[i].distanceTo(T_map_sensor) / params_.known_distance;
    const double turned = std::abs(wrapAngle(poses_[i].yaw - T_map_sensor.yaw)) / params_.known_angle;
    if (away < 1.0 && turned < 1.0 && away + turned < least) {
      least = away + turned;
      best = i;
    }
  }
  return best;
}

}  // namespace yarm::slam
