// Node database: the live occupancy grid, and what would collide if somebody stood elsewhere.
#pragma once

#include "yarm/perception/hiders.hpp"
#include "yarm/perception/occupancy.hpp"
#include "yarm/ros/cluster_assoc.hpp"
#include "yarm/ros/executor.hpp"
#include "yarm/ros/node_params.hpp"
#include "yarm/ros/report.hpp"

#include <ros/ros.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>
#include <yarm/AssociatedClusterVector.h>
#include <yarm/MapMetaData.h>
#include <yarm/PredictNewState.h>
#include <yarm/SeenCells.h>

#include <cstdint>
#include <deque>
#include <memory>

namespace yarm {

/// In: associated_clusters, seen_cells. Out: planning_metadata, collisions, occupancy, /diagnostics. Serves:
/// predict_new_state.
class Database : public PolledNode {
 public:
  /// The handles give the namespaces; callbacks run on the executor. Throws ParamError.
  Database(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle);
  ~Database() override;

  void poll() override;
  bool waiting() const override { return false; }

 private:
  void onAssociated(const yarm::AssociatedClusterVectorConstPtr& message);
  void onSeen(const yarm::SeenCellsConstPtr& message);
  void publishMetadata(const perception::OccupancyGrid& grid);
  /// Puts on the map what the cameras see of its cells, when that has come for its set.
  void addVisibility(const perception::OccupancyGrid& grid, yarm::MapMetaData& message);
  void publishMarkers(const perception::OccupancyGrid& grid);
  void publishOccupancy(const perception::OccupancyGrid& grid);
  /// A refused question is answered with collision = true: nothing was shown to be safe.
  bool onPredict(yarm::PredictNewState::Request& request, yarm::PredictNewState::Response& response);

  DatabaseParams params_;
  ros::NodeHandle handle_;
  boost::shared_ptr<AssociatedFrame> present_;
  Pool<AssociatedFrame> frames_pool_;
  std::unique_ptr<perception::OccupancyBuilder> builder_;
  std::unique_ptr<perception::HiderFinder> hiders_;
  perception::SeenCells seen_;
  std::deque<yarm::SeenCellsConstPtr> seen_inbox_;  ///< in the order of their sets
  perception::GridSpec builder_grid_;
  perception::UidRegistry uids_;
  ros::Subscriber associated_in_;
  ros::Subscriber seen_in_;
  ros::Publisher metadata_out_;
  ros::Publisher collisions_out_;
  ros::Publisher occupancy_out_;
  ros::ServiceServer predict_;
  ThrottledWarning warn_;
  HealthReport health_;
  std::int64_t last_set_ns_ = 0;   ///< wall time
  std::int64_t last_view_ns_ = 0;  ///< wall time
  int published_ = 0;
};

}  // namespace yarm
