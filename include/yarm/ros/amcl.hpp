// Node amcl: where a robot is in a known map, from one planar scan and odometry, behind AMCL's names.
#pragma once

#include "yarm/ros/amcl_params.hpp"
#include "yarm/ros/executor.hpp"
#include "yarm/ros/map_messages.hpp"
#include "yarm/ros/report.hpp"
#include "yarm/ros/scan_reader.hpp"
#include "yarm/slam/localiser.hpp"
#include "yarm/sync/clock.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/SetMap.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>
#include <std_srvs/Empty.h>
#include <tf2_ros/transform_broadcaster.h>

#include <memory>
#include <optional>
#include <random>
#include <string>

namespace yarm {

/// In: scan, map, initialpose, tf odom -> base -> sensor. Out: amcl_pose (latched), particlecloud (latched), ~localised
/// and ~reason (latched, on change), ~state (latched, each scan), tf map -> odom once a pose is believed, /diagnostics.
/// Services: global_localization, request_nomotion_update, set_map. When /clock goes back it starts afresh in the same
/// map.
class Amcl : public PolledNode {
 public:
  /// The handles give the namespaces; callbacks run on the executor. Throws ParamError, std::invalid_argument.
  Amcl(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle);
  ~Amcl() override;

  void poll() override;
  bool waiting() const override;

 private:
  void connect(ros::NodeHandle& own);
  void onScan(const sensor_msgs::LaserScanConstPtr& message);
  void onMap(const nav_msgs::OccupancyGridConstPtr& message);
  void onInitialPose(const geometry_msgs::PoseWithCovarianceStampedConstPtr& message);
  bool onGlobalLocalization(std_srvs::Empty::Request& request, std_srvs::Empty::Response& response);
  bool onNoMotionUpdate(std_srvs::Empty::Request& request, std_srvs::Empty::Response& response);
  bool onSetMap(nav_msgs::SetMap::Request& request, nav_msgs::SetMap::Response& response);
  // Why a map or a pose was not taken; empty when it was.
  std::string takeMap(const nav_msgs::OccupancyGrid& message);
  std::string takePose(const geometry_msgs::PoseWithCovarianceStamped& message);
  void beginAtStart();
  // Tells what is believed until the next scan, after the localiser was given a pose or none.
  void beginWith(const std::optional<slam::PoseBelief>& belief);
  void take(const slam::Scan& scan);
  // Notes that a map or a pose was refused; nothing when there is no fault.
  void refuse(const std::string& name, const std::string& fault);
  void drop(const std::string& key, const std::string& reason);
  void publishPose(const ros::Time& stamp);
  void publishCloud(const ros::Time& stamp);
  // What was made of the scan of a stamp: level OK when localised, its message why not; in the map's frame when the
  // transform of that stamp was sent too, else in none.
  void publishState(const ros::Time& stamp);
  void tell();
  void reset();
  void diagnose();

  AmclParams params_;
  ros::NodeHandle handle_;
  std::unique_ptr<ScanReader> reader_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::unique_ptr<slam::Localiser> localiser_;  // none before the first map
  slam::LocaliserResult result_;                // of the last scan
  std::mt19937_64 random_{1};
  ros::Time scan_stamp_;   // of the last scan taken
  ros::Time cloud_stamp_;  // of the last cloud sent
  bool told_localised_ = false;
  std::string told_reason_;
  int scans_seen_ = 0;
  int scans_dropped_ = 0;  // since the last diagnostics
  std::string last_fault_;
  std::string refused_;  // since the last diagnostics
  ros::Publisher pose_publisher_;
  ros::Publisher cloud_publisher_;
  ros::Publisher localised_publisher_;
  ros::Publisher reason_publisher_;
  ros::Publisher state_publisher_;
  ros::Subscriber scans_;
  ros::Subscriber maps_;
  ros::Subscriber poses_;
  ros::ServiceServer global_service_;
  ros::ServiceServer update_service_;
  ros::ServiceServer map_service_;
  ClockWatch clock_;
  ThrottledWarning warn_;
  HealthReport health_;
};

}  // namespace yarm
