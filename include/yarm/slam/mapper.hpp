// Simultaneous localisation and mapping for one planar scan with a narrow field of view: a graph of keyframes.
#pragma once

#include "yarm/slam/keyframes.hpp"
#include "yarm/slam/map_drawer.hpp"
#include "yarm/slam/params.hpp"
#include "yarm/slam/types.hpp"
#include "yarm/slam/worker.hpp"

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace yarm::slam {

/// What has been done so far.
struct Statistics {
  int scans{0};      ///< given
  int dropped{0};    ///< refused
  int matched{0};    ///< matches that succeeded
  int unmatched{0};  ///< matches that were due and failed
  int keyframes{0};
  int edges{0};
  int searches{0};        ///< coarse searches begun
  int searches_taken{0};  ///< coarse searches whose answer was used
  int optimisations{0};   ///< that ended well
  int odometry_jumps{0};  ///< steps of the odometry that were not believed
};

/// Makes a map from scans and odometry. Scans must come in the order of their stamps, from one thread.
///
/// With Params::sync the optimisation and the drawing happen inside addScan() and requestMap(), and the same input
/// gives the same output byte for byte. Without it they happen in a thread of the mapper's own.
class Mapper {
 public:
  /// `T_map_base`: where the robot stands at its first scan. Throws std::invalid_argument naming every fault of params.
  explicit Mapper(const Params& params, const Pose2& T_map_base = {});

  /// Takes one scan. A fault of the scan is answered by kDropped with the reason, and changes nothing.
  ScanResult addScan(const Scan& scan);

  /// Has the map drawn from the scans so far; false when an earlier request is still being drawn.
  bool requestMap();
  /// The newest map drawn; empty before the first. Thread-safe.
  [[nodiscard]] std::shared_ptr<const GridMap> map() const;

  /// Matches every edge again at the present poses and optimises to the end, in the caller's thread; for the final map.
  /// Gives why it failed, or nothing.
  std::string refine();
  /// Waits until the mapper's own thread has done what it was given.
  void finish();

  [[nodiscard]] const Statistics& statistics() const { return statistics_; }
  [[nodiscard]] const Keyframes& keyframes() const { return keyframes_; }
  /// Poses of the keyframes' sensors, map frame.
  [[nodiscard]] const std::vector<Pose2>& keyframePoses() const { return keyframes_.poses(); }
  [[nodiscard]] const std::vector<PoseEdge>& edges() const { return keyframes_.edges(); }

 private:
  /// Where the robot was at the last match, and what odometry has said since.
  struct Anchor {
    int keyframe{0};
    Pose2 T_keyframe_sensor;
    Pose2 T_odom_sensor;  ///< at that match
    std::int64_t stamp_ns{0};
    double way_m{0};                                           ///< driven since
    double turn_rad{0};                                        ///< turned since
    Eigen::Matrix3d information{Eigen::Matrix3d::Identity()};  ///< of that match
  };

  void begin(const Scan& scan);
  [[nodiscard]] bool moveOn(const Scan& scan);
  [[nodiscard]] bool isDue(const Scan& scan) const;
  [[nodiscard]] Pose2 predicted() const;
  [[nodiscard]] Eigen::Matrix3d odometryCovariance() const;
  [[nodiscard]] PosePrior prior() const;
  void takeMatch(const Scan& scan, ScanResult& result);
  [[nodiscard]] MatchResult locate(const ScanPoints& points, std::vector<int>& neighbours);
  [[nodiscard]] MatchResult search(const ScanPoints& points, const std::vector<int>& neighbours,
                                   const MatchResult& failed);
  void addKeyframe(std::shared_ptr<const ScanPoints> points, const MatchResult& match,
                   const std::vector<int>& neighbours);
  /// Ties a keyframe to its neighbours; true when one of an earlier visit says that the robot is elsewhere.
  bool addEdges(int keyframe, const std::vector<int>& neighbours);
  [[nodiscard]] std::optional<PoseEdge> matchedEdge(int from, int to) const;
  void moveAnchor(int keyframe, const Pose2& T_map_sensor, const Eigen::Matrix3d& information);
  void keepForMap(const Scan& scan);
  void proveScans(const Pose2& T_map_sensor);
  void optimizeSoon();
  void takeOptimised();
  [[nodiscard]] double entropy() const;
  [[nodiscard]] ScanResult resultFor(const Scan& scan, ScanResult result) const;

  Params params_;
  Pose2 T_map_base_start_;
  Keyframes keyframes_;
  MapDrawer drawer_;
  Anchor anchor_;
  Pose2 T_odom_base_;         ///< of the last scan
  Pose2 T_odom_sensor_;       ///< of the last scan
  std::int64_t stamp_ns_{0};  ///< of the last scan
  bool begun_{false};
  int since_optimised_{0};  ///< keyframes since the last optimisation was begun
  std::vector<std::shared_ptr<const MapScan>> scans_;
  std::vector<std::shared_ptr<const MapScan>> unproved_;  ///< placed by odometry since the last match
  std::vector<int> scans_of_keyframe_;
  Statistics statistics_;

  mutable std::mutex mutex_;  ///< guards the two below
  std::shared_ptr<const GridMap> map_;
  std::optional<GraphResult> optimised_;
  Worker worker_;  ///< last: its thread uses what stands above
};

}  // namespace yarm::slam
