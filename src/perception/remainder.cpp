#include "remainder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace yarm::perception {

namespace {

constexpr float kOnRobot = 0.06F;     // a noisy point this near to a robot's body lies on it, metres
constexpr float kFloorSigmas = 5.5F;  // what no body explains is the floor's up to this many sigmas of its noise

/// True for a point that the floor's noise may have lifted.
bool isFloorNoise(const MergedPoint& p) {
  return p.z < kFloorSigmas * p.sigma * std::abs(p.uz);
}

Eigen::Vector3f corner(const std::array<double, 3>& p) {
  return Eigen::Vector3d(p[0], p[1], p[2]).cast<float>();
}

/// Distance of a point to what stands for an object without a known shape: its last good view, its seed.
float distanceTo(const ObjectMemory& object, const Eigen::Vector3f& point) {
  const float seed = (object.seed().T_world_seed.translation().cast<float>() - point).norm();
  return std::min({seed, object.recentDistance(point), object.learnedDistance(point)});
}

int nearestOf(const PresentSet& set, const std::vector<int>& candidates, const Eigen::Vector3f& point) {
  int best = kNobody;
  float best_distance = std::numeric_limits<float>::infinity();
  for (const int i : candidates) {
    const float d = distanceTo(set.object(i), point);
    const bool loose = set.object(i).seed().object == ObjectKind::kDebris;
    if (d < best_distance && !(loose && d > kDebrisReach)) {
      best = i;
      best_distance = d;
    }
  }
  return best;
}

}  // namespace

Remainder::Remainder(const AssociationParams& params)
    : params_(params),
      components_(corner(params.grid.min), corner(params.grid.max), static_cast<float>(params.search_radius)),
      unknown_(params),
      tracks_(params) {}

void Remainder::share(PresentSet& set, const SceneModel& model) {
  const auto on_robot = [&](const Eigen::Vector3f& p) { return isOnRobot(set, model, p); };
  unknown_.dissolve(on_robot);
  tracks_.dissolve(on_robot);
  explained_.resize(set.owner.size());
  std::transform(set.owner.begin(), set.owner.end(), explained_.begin(),
                 [](int owner) { return static_cast<char>(owner != kNobody); });
  std::vector<Group> strangers;
  for (const Group& group : groups(set)) {
    Group left = shareGroup(set, model, group);
    if (static_cast<int>(left.size()) >= params_.unknown_min_points) {
      strangers.push_back(std::move(left));
    }
  }
  tracks_.update(set.stamp_ns, *set.points, explained_, *set.absent, strangers);
  unknown_.update(*set.points, strangers, *set.absent);
  unknown_.name(tracks_);
}

std::vector<Remainder::Group> Remainder::groups(const PresentSet& set) {
  rest_.clear();
  rest_points_.clear();
  for (std::size_t i = 0; i < set.points->size(); ++i) {
    if (set.owner[i] == kNobody && !isFloorNoise((*set.points)[i])) {
      rest_.push_back(static_cast<std::uint32_t>(i));
      rest_points_.push_back(set.seenAt(i));
    }
  }
  const Components components = components_.label(rest_points_);
  std::vector<Group> found(static_cast<std::size_t>(components.count));
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    found[static_cast<std::size_t>(components.of_point[i])].push_back(rest_[i]);
  }
  return found;
}

Remainder::Group Remainder::shareGroup(PresentSet& set, const SceneModel& model, const Group& group) const {
  const std::vector<int> claimants = shapelessNear(set, group);
  if (!claimants.empty()) {
    for (const std::uint32_t i : group) {
      set.owner[i] = nearestOf(set, claimants, set.placed[i]);
    }
  }
  Group left;
  const std::vector<char>& hosts = set.calibrating ? set.solid : set.robots;
  for (const std::uint32_t i : group) {
    if (set.owner[i] != kNobody) {
      continue;
    }
    const bool stranger = unknown_.covers(set.placed[i], reach() / 2);
    set.owner[i] = stranger ? kNobody : hostOf(set, model, set.placed[i], hosts);
    if (set.owner[i] == kNobody) {
      left.push_back(i);
    }
  }
  return left;
}

bool Remainder::isOnRobot(const PresentSet& set, const SceneModel& model, const Eigen::Vector3f& point) {
  if (model.nearest(point, set.robots, kOnRobot).object != kNobody) {
    return true;
  }
  return std::any_of(set.objects.begin(), set.objects.end(), [&](const ObjectMemory* object) {
    return object->isRobot() && object->learnedDistance(point) < kOnRobot;
  });
}

int Remainder::hostOf(const PresentSet& set, const SceneModel& model, const Eigen::Vector3f& point,
                      const std::vector<char>& hosts) const {
  const Explanation near = model.nearest(point, hosts, reach());
  int best = near.object;
  float best_distance = near.distance;
  for (int i = 0; i < set.objectCount(); ++i) {
    if (hosts[static_cast<std::size_t>(i)] != 0 && !set.object(i).hasShape()) {
      const float d = distanceTo(set.object(i), point);
      if (d < best_distance) {
        best = i;
        best_distance = d;
      }
    }
  }
  return best;
}

std::vector<int> Remainder::shapelessNear(const PresentSet& set, const Group& group) const {
  std::vector<int> result;
  for (int i = 0; i < set.objectCount(); ++i) {
    const ObjectMemory& object = set.object(i);
    if (object.hasShape() || object.isTarget() ||
        (!set.calibrating && object.seed().is_static && object.hasLearned())) {
      continue;
    }
    const bool hit = std::any_of(group.begin(), group.end(),
                                 [&](std::uint32_t p) { return distanceTo(object, set.placed[p]) < reach(); });
    if (hit) {
      result.push_back(i);
    }
  }
  return result;
}

}  // namespace yarm::perception
