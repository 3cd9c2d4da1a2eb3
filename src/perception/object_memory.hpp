// What the association remembers of one registered object from set to set.
#pragma once

#include "yarm/perception/association.hpp"

#include "learned_cloud.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace yarm::perception {

/// One registered object: its frames, known solids, learnt surface and last good view.
class ObjectMemory {
 public:
  /// Takes the seed, the known shapes and the poses of the present set.
  void refresh(const Seed& seed, const KnownObject* known, const LinkPoses& links);

  [[nodiscard]] const Seed& seed() const { return seed_; }
  [[nodiscard]] const std::vector<Solid>& solids() const { return solids_; }
  [[nodiscard]] bool isRobot() const;
  [[nodiscard]] bool isTarget() const { return seed_.object == ObjectKind::kTarget; }
  [[nodiscard]] bool hasShape() const { return !solids_.empty(); }
  /// True for a fixed body with a known shape on which something may lie.
  [[nodiscard]] bool isFixture() const {
    return seed_.is_static && seed_.object == ObjectKind::kObstacle && hasShape();
  }
  /// True when it has several links that move against each other.
  [[nodiscard]] bool isArticulated() const { return link_frames_.size() > 1; }

  /// World <- frame now; empty when it has never been known.
  [[nodiscard]] std::optional<Eigen::Isometry3d> poseOf(const std::string& frame) const;

  // What appends does so to buffers that the caller keeps: returned vectors take 0.03 ms more of 0.38 ms a set
  // (perception_core_bench, "3 associate").

  /// Appends points on the surfaces of the known solids at their present poses, world.
  void appendSurfaces(std::vector<Eigen::Vector3f>& out) const;
  /// Learns a point (world) seen in calibration; it moves with the nearest link.
  void learn(const Eigen::Vector3f& point, std::int64_t set, const AssociationParams& params);
  /// Distance of a point (world) to the learnt surface, +inf when it is not near.
  [[nodiscard]] float learnedDistance(const Eigen::Vector3f& point) const;
  [[nodiscard]] bool hasLearned() const;
  /// Appends the learnt surface at its present pose, world.
  void appendLearned(std::vector<Eigen::Vector3f>& out) const;

  /// The last good view, carried rigidly with the seed: replaced when the present view is as good, else appended to
  /// `hidden`.
  void carryRecent(const std::vector<Eigen::Vector3f>& seen, std::vector<Eigen::Vector3f>& hidden);
  /// Distance of a point (world) to the last good view carried to the present pose; +inf without one.
  [[nodiscard]] float recentDistance(const Eigen::Vector3f& point) const;

 private:
  void takeShapes(const KnownObject* known);
  [[nodiscard]] std::string nearestLink(const Eigen::Vector3f& point) const;
  /// World <- what a learnt cloud is kept in: a link's frame, or the seed's for a name that is empty.
  [[nodiscard]] std::optional<Eigen::Isometry3d> poseOfLearned(const std::string& frame) const;

  Seed seed_;
  std::vector<Solid> told_;    // the known shapes as they were told
  std::vector<Solid> solids_;  // those of them that make sense
  std::vector<std::string> link_frames_;
  std::vector<std::vector<Eigen::Vector3f>> surfaces_;     // of each solid, in its frame
  std::map<std::string, Eigen::Isometry3d> T_seed_frame_;  // last known
  std::map<std::string, LearnedCloud> learned_;            // by frame
  std::vector<Eigen::Vector3f> recent_;                    // last good view, seed frame
};

}  // namespace yarm::perception
