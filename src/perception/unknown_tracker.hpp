// Things nobody registered: they must show in several sets before they are believed.
#pragma once

#include "yarm/perception/association.hpp"

#include "object_tracks.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

namespace yarm::perception {

/// One thing that nobody registered.
struct UnknownThing {
  int number{0};                        ///< n of "unknown_<n>"; 0 = not yet believed
  std::uint32_t history{0};             ///< bit i = it showed i sets ago
  std::vector<std::uint32_t> source;    ///< its points in the present set; empty when it did not show
  std::vector<Eigen::Vector3f> points;  ///< its points when it last showed, metres, world; then those of absent cameras
  Eigen::AlignedBox3f box;              ///< around those points
  std::map<std::int32_t, std::vector<Eigen::Vector3f>> views;  ///< the same points by the camera that saw them last
};

/// Follows them from set to set. That a camera shows nothing counts only while it has a view: what an absent camera saw
/// of a thing is kept until the camera has a view again, unless the thing has moved off from it; and a thing of which
/// absent cameras saw more than the others does not age.
class UnknownTracker {
 public:
  explicit UnknownTracker(const AssociationParams& params) : params_(params) {}

  /// Hands over the groups of unexplained points of a set, indices into `points`, and the cameras without a view in it.
  void update(const std::vector<MergedPoint>& points, const std::vector<std::vector<std::uint32_t>>& groups,
              const std::vector<std::int32_t>& absent);
  /// Numbers the believed things that have no number: each as the track of its points, when no other thing has that.
  void name(ObjectTracks& tracks);
  /// Forgets things of which more than half of the points are `explained`: something registered stands there.
  void dissolve(const std::function<bool(const Eigen::Vector3f&)>& explained);
  /// Believed things, in the order they were first believed.
  [[nodiscard]] std::vector<const UnknownThing*> believed() const;
  /// True when a point lies on a believed thing, within `reach` metres of its last points.
  [[nodiscard]] bool covers(const Eigen::Vector3f& point, float reach) const;
  void reset();

 private:
  [[nodiscard]] bool isBelieved(const UnknownThing& thing) const;
  /// Index of the thing that a group of points continues, -1 = none.
  [[nodiscard]] int match(const std::vector<Eigen::Vector3f>& group) const;
  /// A thing that shows: its present points, and the absent cameras' old ones that still join them.
  void show(UnknownThing& thing, UnknownThing now, const std::vector<std::int32_t>& absent) const;
  /// A thing that does not show: ages, unless most of it was seen by absent cameras.
  void miss(UnknownThing& thing, const std::vector<std::int32_t>& absent) const;

  AssociationParams params_;
  std::vector<UnknownThing> things_;
};

}  // namespace yarm::perception
