// Node slam_gmapping: a map and the robot's place in it from one planar scan and odometry, behind gmapping's names.
#pragma once

#include "yarm/ros/executor.hpp"
#include "yarm/ros/report.hpp"
#include "yarm/ros/scan_reader.hpp"
#include "yarm/ros/slam_gmapping_params.hpp"
#include "yarm/slam/mapper.hpp"
#include "yarm/sync/clock.hpp"

#include <nav_msgs/GetMap.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_ros/transform_broadcaster.h>

#include <memory>
#include <optional>
#include <string>

namespace yarm {

/// In: scan, tf odom -> base -> sensor. Out: map, map_metadata (latched), ~entropy, ~state, tf map -> odom,
/// dynamic_map, /diagnostics. When /clock goes back it forgets everything and starts afresh.
class SlamGmapping : public PolledNode {
 public:
  /// The handles give the namespaces; callbacks run on the executor. Throws ParamError, std::invalid_argument.
  SlamGmapping(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle);
  ~SlamGmapping() override;

  void poll() override;
  bool waiting() const override;

 private:
  void onScan(const sensor_msgs::LaserScanConstPtr& message);
  bool onGetMap(nav_msgs::GetMap::Request& request, nav_msgs::GetMap::Response& response);
  std::optional<slam::ScanResult> take(const slam::Scan& scan);
  void drop(const std::string& key, const std::string& reason);
  void sendTransform(const ros::Time& time);
  bool saidAgain(const slam::Scan& scan) const;  // in lock-step: somebody has not heard the answer
  void sendAgain();
  void sendEntropy(double entropy);
  void sendState(const slam::ScanResult& result);
  void updateMap();
  void reset();
  void diagnose();

  SlamGmappingParams params_;
  ros::NodeHandle handle_;
  std::unique_ptr<ScanReader> reader_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::unique_ptr<slam::Mapper> mapper_;
  std::optional<slam::Pose2> T_map_odom_;  // empty before the first scan
  ros::Time scan_stamp_;                   // of the last scan taken
  std::size_t scan_beams_ = 0;             // its beams
  ros::Time transform_sent_;               // time the last map -> odom was sent for
  ros::Time map_due_;
  std::shared_ptr<const slam::GridMap> map_;
  nav_msgs::OccupancyGrid grid_;
  int scans_seen_ = 0;
  int scans_dropped_ = 0;  // since the last diagnostics
  int scans_unmatched_ = 0;
  std::string last_fault_;
  ros::Publisher map_publisher_;
  ros::Publisher metadata_publisher_;
  ros::Publisher entropy_publisher_;
  ros::Publisher state_publisher_;
  ros::Subscriber scans_;
  ros::ServiceServer service_;
  ClockWatch clock_;
  ThrottledWarning warn_;
  HealthReport health_;
};

}  // namespace yarm
