// Part of node merge_clouds: what the cameras see of the grid's cells, for the map, RViz and diagnostics.
#pragma once

#include "yarm/perception/visibility.hpp"
#include "yarm/ros/node_params.hpp"
#include "yarm/ros/report.hpp"

#include <ros/ros.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace yarm {

/// Out: seen_cells, hidden_cells, coverage (latched), /diagnostics. Does nothing unless the parameter `visibility` says
/// so.
class CellVisibility {
 public:
  /// Throws ParamError when the grid of node `grid_node` is wrong, std::invalid_argument with too many cameras.
  CellVisibility(ros::NodeHandle& handle, const MergeCloudsParams& params);

  /// Takes on a set that is a map: its clouds, one a camera, and what they were merged to.
  void add(const std::vector<perception::CameraCloud>& clouds, const perception::MergedSet& set);
  /// Says how it stands, once a second.
  void diagnose();
  /// Forgets what was seen (the clock went back).
  void reset();

 private:
  void publishCoverage(perception::StampNs stamp_ns);
  void publishHidden(perception::StampNs stamp_ns);
  void publishSeen(perception::StampNs stamp_ns);

  std::vector<std::string> topics_;
  double rate_;
  double age_rate_;
  perception::GridSpec grid_;
  std::unique_ptr<perception::VisibilityVoter> voter_;  ///< none: switched off
  perception::CellVotes votes_;
  perception::CellVotes coverage_;
  perception::SeenCells seen_;
  perception::VisibilityMap map_;
  int views_ = 0;                               ///< of the coverage that was published
  std::size_t uncovered_ = 0;                   ///< cells
  std::int64_t shown_ns_ = 0;                   ///< wall time
  std::optional<perception::StampNs> aged_ns_;  ///< capture time of the last ages told
  ros::Publisher seen_out_;
  ros::Publisher hidden_out_;
  ros::Publisher coverage_out_;
  HealthReport health_;
};

}  // namespace yarm
