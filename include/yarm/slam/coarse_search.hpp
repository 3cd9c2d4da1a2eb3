// Finding a scan's pose again after the odometry slipped farther than a match can bridge.
//
// An exhaustive search over a likelihood raster, after E. Olson, "Real-time correlative scan matching", ICRA 2009.
#pragma once

#include "yarm/slam/match.hpp"
#include "yarm/slam/params.hpp"

#include <vector>

namespace yarm::slam {

/// Answer of a search.
struct SearchResult {
  bool found{false};
  Pose2 T_map_sensor;  ///< the best place of the window
  double score{0};     ///< mean likelihood of the scan's points there, 0 to 1
};

/// Tries every pose of a window around `start` against the targets' points; found when the best scores at least
/// KeyframeParams::search_score. O(poses x points).
[[nodiscard]] SearchResult searchCoarsely(const ScanPoints& scan, const Pose2& start,
                                          const std::vector<MatchTarget>& targets, const KeyframeParams& params);

}  // namespace yarm::slam
