// What no surface explains: shared out by connected groups, to objects without a known shape, to robots, or to nobody.
#pragma once

#include "yarm/perception/association.hpp"

#include "euclidean.hpp"
#include "object_tracks.hpp"
#include "present_set.hpp"
#include "scene_model.hpp"
#include "unknown_tracker.hpp"

#include <cstdint>
#include <functional>
#include <vector>

namespace yarm::perception {

/// Shares out the remainder and follows the things that nobody registered. One instance an association.
class Remainder {
 public:
  explicit Remainder(const AssociationParams& params);

  /// Gives the points that are kNobody's an owner where they have one; the groups that are left feed the tracker of
  /// unknown things. `model`: the known solids of the set.
  void share(PresentSet& set, const SceneModel& model);
  /// The points of the last set that no surface explained, floor noise left out: indices into its points.
  [[nodiscard]] const std::vector<std::uint32_t>& rest() const { return rest_; }
  /// Ends the unknown things of which more than half is `known` now: they have become something else.
  void forget(const std::function<bool(const Eigen::Vector3f&)>& known) {
    unknown_.dissolve(known);
    tracks_.forget(known);
  }
  [[nodiscard]] const UnknownTracker& unknown() const { return unknown_; }
  [[nodiscard]] const ObjectTracks& tracks() const { return tracks_; }
  void reset() {
    unknown_.reset();
    tracks_.reset();
  }

 private:
  using Group = std::vector<std::uint32_t>;

  [[nodiscard]] float reach() const { return static_cast<float>(params_.search_radius); }
  /// The connected groups of the remaining points.
  [[nodiscard]] std::vector<Group> groups(const PresentSet& set);
  /// Gives a group's points away; returns those that are nobody's.
  [[nodiscard]] Group shareGroup(PresentSet& set, const SceneModel& model, const Group& group) const;
  /// True for a point on or in a robot. What was taken for an unknown thing there was the robot, told at a wrong place.
  [[nodiscard]] static bool isOnRobot(const PresentSet& set, const SceneModel& model, const Eigen::Vector3f& point);
  /// The object (of those marked) whose body comes within reach of a point.
  [[nodiscard]] int hostOf(const PresentSet& set, const SceneModel& model, const Eigen::Vector3f& point,
                           const std::vector<char>& hosts) const;
  /// Objects without a known shape that a group of points reaches.
  [[nodiscard]] std::vector<int> shapelessNear(const PresentSet& set, const Group& group) const;

  AssociationParams params_;
  EuclideanClusters components_;
  UnknownTracker unknown_;
  ObjectTracks tracks_;
  std::vector<char> explained_;  // by a surface: of each point
  std::vector<std::uint32_t> rest_;
  std::vector<Eigen::Vector3f> rest_points_;
};

}  // namespace yarm::perception
