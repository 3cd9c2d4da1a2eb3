#include "object_memory.hpp"

#include "yarm/perception/solids.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace yarm::perception {

namespace {

constexpr float kSamplePitch = 0.05F;  // a little under a cell's smallest edge, metres
constexpr float kInset = 0.003F;       // keeps samples of touching faces out of each other's cells, metres
constexpr int kHitsBesideShape = 3;    // sets in which something beside the known shape must show to be learnt
constexpr double kGoodView = 0.7;      // share of the last good view's points that makes a view as good

bool sameSolid(const Solid& a, const Solid& b) {
  // Not equal to itself with NaN: taken anew in every set, and refused.
  return a.shape == b.shape && a.size == b.size && a.frame == b.frame &&
         a.T_frame_solid.matrix() == b.T_frame_solid.matrix();
}

float distanceToSegment(const Eigen::Vector3f& p, const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const Eigen::Vector3f ab = b - a;
  const float length2 = ab.squaredNorm();
  const float t = length2 > 0.F ? std::clamp((p - a).dot(ab) / length2, 0.F, 1.F) : 0.F;
  return (p - a - t * ab).norm();
}

std::vector<Eigen::Vector3f> insetSurface(const Solid& solid) {
  const bool box = solid.shape == Solid::Shape::kBox;
  const Eigen::Vector3f inset(box ? 2 * kInset : kInset, box ? 2 * kInset : 0.F, 2 * kInset);
  const Eigen::Vector3f size = (solid.size.cast<float>() - inset).cwiseMax(1e-3F);
  std::vector<Eigen::Vector3f> points = sampleSurface(solid.shape, size, kSamplePitch);
  const Eigen::Isometry3f T = solid.T_frame_solid.cast<float>();
  std::transform(points.begin(), points.end(), points.begin(), [&](const Eigen::Vector3f& p) { return T * p; });
  return points;
}

}  // namespace

bool ObjectMemory::isRobot() const {
  return seed_.object == ObjectKind::kMobile || seed_.object == ObjectKind::kManipulator;
}

void ObjectMemory::takeShapes(const KnownObject* known) {
  static const KnownObject kNothing;
  const KnownObject& now = known != nullptr ? *known : kNothing;
  link_frames_ = now.link_frames;
  if (!std::equal(told_.begin(), told_.end(), now.solids.begin(), now.solids.end(), sameSolid)) {
    told_ = now.solids;
    solids_.clear();
    std::copy_if(told_.begin(), told_.end(), std::back_inserter(solids_),
                 [](const Solid& solid) { return solidFault(solid).empty(); });
    surfaces_.clear();
    for (const Solid& solid : solids_) {
      surfaces_.push_back(insetSurface(solid));
    }
  }
  if (known != nullptr && !known->seed_frame.empty()) {
    T_seed_frame_[known->seed_frame] = Eigen::Isometry3d::Identity();
  }
}

void ObjectMemory::refresh(const Seed& seed, const KnownObject* known, const LinkPoses& links) {
  seed_ = seed;
  takeShapes(known);
  const Eigen::Isometry3d T_seed_world = seed.T_world_seed.inverse();
  const auto keep = [&](const std::string& frame) {
    const auto found = links.find(frame);
    if (found != links.end()) {
      T_seed_frame_[frame] = T_seed_world * found->second;
    }
  };
  for (const std::string& frame : link_frames_) {
    keep(frame);
  }
  for (const Solid& solid : solids_) {
    keep(solid.frame);
  }
}

std::optional<Eigen::Isometry3d> ObjectMemory::poseOf(const std::string& frame) const {
  const auto found = T_seed_frame_.find(frame);
  if (found == T_seed_frame_.end()) {
    return std::nullopt;
  }
  return seed_.T_world_seed * found->second;
}

std::optional<Eigen::Isometry3d> ObjectMemory::poseOfLearned(const std::string& frame) const {
  return frame.empty() ? seed_.T_world_seed : poseOf(frame);
}

void ObjectMemory::appendSurfaces(std::vector<Eigen::Vector3f>& out) const {
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    if (const auto T = poseOf(solids_[s].frame)) {
      const Eigen::Isometry3f T_world_frame = T->cast<float>();
      for (const Eigen::Vector3f& p : surfaces_[s]) {
        out.push_back(T_world_frame * p);
      }
    }
  }
}

std::string ObjectMemory::nearestLink(const Eigen::Vector3f& point) const {
  std::string best;
  float best_distance = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < link_frames_.size(); ++i) {
    const auto here = poseOf(link_frames_[i]);
    if (!here) {
      continue;
    }
    const auto next = i + 1 < link_frames_.size() ? poseOf(link_frames_[i + 1]) : std::nullopt;
    const Eigen::Vector3f a = here->translation().cast<float>();
    const float d = distanceToSegment(point, a, next ? next->translation().cast<float>().eval() : a);
    if (d < best_distance) {
      best_distance = d;
      best = link_frames_[i];
    }
  }
  return best;
}

void ObjectMemory::learn(const Eigen::Vector3f& point, std::int64_t set, const AssociationParams& params) {
  const std::string frame = nearestLink(point);
  const Eigen::Isometry3d T = poseOfLearned(frame).value_or(seed_.T_world_seed);
  const LearnedCloud empty(static_cast<float>(params.cloud_spacing), hasShape() ? kHitsBesideShape : 1);
  learned_.emplace(frame, empty).first->second.add(T.inverse().cast<float>() * point, set);
}

float ObjectMemory::learnedDistance(const Eigen::Vector3f& point) const {
  float best = std::numeric_limits<float>::infinity();
  for (const auto& [frame, cloud] : learned_) {
    const auto T = cloud.empty() ? std::nullopt : poseOfLearned(frame);
    if (T) {
      best = std::min(best, cloud.distance(T->inverse().cast<float>() * point));
    }
  }
  return best;
}

bool ObjectMemory::hasLearned() const {
  return std::any_of(learned_.begin(), learned_.end(), [](const auto& entry) { return !entry.second.empty(); });
}

void ObjectMemory::appendLearned(std::vector<Eigen::Vector3f>& out) const {
  for (const auto& [frame, cloud] : learned_) {
    if (const auto T = poseOfLearned(frame)) {
      const Eigen::Isometry3f T_world_frame = T->cast<float>();
      for (const Eigen::Vector3f& p : cloud.points()) {
        out.push_back(T_world_frame * p);
      }
    }
  }
}

void ObjectMemory::carryRecent(const std::vector<Eigen::Vector3f>& seen, std::vector<Eigen::Vector3f>& hidden) {
  const Eigen::Isometry3f T_world_seed = seed_.T_world_seed.cast<float>();
  if (!seen.empty() && static_cast<double>(seen.size()) >= kGoodView * static_cast<double>(recent_.size())) {
    const Eigen::Isometry3f T_seed_world = T_world_seed.inverse();
    recent_.clear();
    for (const Eigen::Vector3f& p : seen) {
      recent_.push_back(T_seed_world * p);
    }
    return;
  }
  for (const Eigen::Vector3f& p : recent_) {
    hidden.push_back(T_world_seed * p);
  }
}

float ObjectMemory::recentDistance(const Eigen::Vector3f& point) const {
  const Eigen::Vector3f local = seed_.T_world_seed.inverse().cast<float>() * point;
  float best = std::numeric_limits<float>::infinity();
  for (const Eigen::Vector3f& p : recent_) {
    best = std::min(best, (p - local).squaredNorm());
  }
  return std::sqrt(best);
}

}  // namespace yarm::perception
