// The scans that are kept, where they were taken, and what ties them together.
#pragma once

#include "yarm/slam/match.hpp"
#include "yarm/slam/params.hpp"
#include "yarm/slam/pose_graph.hpp"
#include "yarm/slam/scan_points.hpp"

#include <deque>
#include <memory>
#include <optional>
#include <vector>

namespace yarm::slam {

/// Keyframes with their poses (of the sensor), edges, and the trail of those visited last. Not thread-safe.
class Keyframes {
 public:
  explicit Keyframes(const KeyframeParams& params) : params_(params) {}

  /// Whether two keyframes are too far apart in number to belong to one visit of a place.
  [[nodiscard]] static bool isAnotherVisit(int a, int b);

  [[nodiscard]] int size() const { return static_cast<int>(poses_.size()); }
  [[nodiscard]] const std::vector<Pose2>& poses() const { return poses_; }
  [[nodiscard]] const Pose2& pose(int keyframe) const { return poses_[keyframe]; }
  [[nodiscard]] const ScanPoints& points(int keyframe) const { return *points_[keyframe]; }
  [[nodiscard]] const std::vector<PoseEdge>& edges() const { return edges_; }
  [[nodiscard]] MatchTarget target(int keyframe) const { return {points_[keyframe].get(), poses_[keyframe]}; }
  [[nodiscard]] std::vector<MatchTarget> targets(const std::vector<int>& keyframes) const;

  /// A new keyframe; gives its index.
  int add(std::shared_ptr<const ScanPoints> points, const Pose2& T_map_sensor);
  void addEdge(const PoseEdge& edge) { edges_.push_back(edge); }
  void replaceEdge(std::size_t index, const PoseEdge& edge) { edges_[index] = edge; }
  /// Takes over poses of the first keyframes; later ones follow the last of these rigidly.
  void correct(const std::vector<Pose2>& poses);

  /// Notes that the robot is at a keyframe.
  void visit(int keyframe);
  /// The keyframes visited last, newest first, at most KeyframeParams::recent.
  [[nodiscard]] std::vector<int> recent() const { return {trail_.begin(), trail_.end()}; }
  /// Up to KeyframeParams::old others that see most of what a scan sees, from different visits. O(keyframes).
  [[nodiscard]] std::vector<int> overlapping(const ScanPoints& scan, const Pose2& T_map_sensor) const;
  /// The keyframe that makes a pose a known place, if any. O(keyframes).
  [[nodiscard]] std::optional<int> knownPlace(const Pose2& T_map_sensor) const;

 private:
  KeyframeParams params_;
  std::vector<Pose2> poses_;
  std::vector<std::shared_ptr<const ScanPoints>> points_;
  std::vector<PoseEdge> edges_;
  std::deque<int> trail_;
};

}  // namespace yarm::slam
