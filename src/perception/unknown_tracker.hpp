// Things nobody registered: they must show in several sets before they are believed.
#pragma once

#include "yarm/perception/association.hpp"

#include <cstdint>
#include <vector>

namespace yarm::perception {

/// One thing that nobody registered.
struct UnknownThing {
  int number{0};                        ///< n of "unknown_<n>"; 0 = not yet believed
  std::uint32_t history{0};             ///< bit i = it showed i sets ago
  std::vector<std::uint32_t> source;    ///< its points in the present set; empty when it did not show
  std::vector<Eigen::Vector3f> points;  ///< its points when it last showed, metres, world
  Eigen::AlignedBox3f box;              ///< around those points
};

/// Follows them from set to set.
class UnknownTracker {
 public:
  explicit UnknownTracker(const AssociationParams& params) : params_(params) {}

  /// Hands over the groups of unexplained points of a set: indices into `points`.
  void update(const std::vector<MergedPoint>& points, const std::vector<std::vector<std::uint32_t>>& groups);
  /// Believed things, in the order they were first believed.
  [[nodiscard]] std::vector<const UnknownThing*> believed() const;
  /// True when a point lies on a believed thing, within `reach` metres of its last points.
  [[nodiscard]] bool covers(const Eigen::Vector3f& point, float reach) const;
  void reset();

 private:
  [[nodiscard]] bool isBelieved(const UnknownThing& thing) const;
  UnknownThing* match(const std::vector<Eigen::Vector3f>& group);

  AssociationParams params_;
  int next_number_{1};
  std::vector<UnknownThing> things_;
};

}  // namespace yarm::perception
