// Scans with the transforms of their moments: what the nodes that map and that localise have in common.
#pragma once

#include "yarm/ros/tf_listener.hpp"
#include "yarm/slam/types.hpp"

#include <geometry_msgs/TransformStamped.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2/buffer_core.h>

#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <string>

namespace yarm {

/// Between which frames scans are placed, and how long they may wait for it.
struct ScanReaderParams {
  std::string base_frame;                                       ///< the robot's
  std::string odom_frame;                                       ///< odometry's
  double tf_wait = 0.3;                                         ///< s of wall time that a scan waits for its transforms
  double least_range = 0.0;                                     ///< m: shorter ranges count as nothing seen
  double most_range = std::numeric_limits<double>::infinity();  ///< m: and so do longer ones
};

/// A scan as the library wants it, or why it cannot be had.
struct ScanOrFault {
  slam::Scan scan;
  std::string fault;  ///< empty when the scan is good
  std::string topic;  ///< of the fault: "transform", "queue", "stamp"
};

/// A scan with the transforms of its moment, or what is wrong with it or them: "transform" may still come.
ScanOrFault readScan(const sensor_msgs::LaserScan& message, const tf2::BufferCore& tf, const ScanReaderParams& params);

/// Holds scans until their transforms are there. Not thread-safe.
class ScanReader {
 public:
  /// `handle` gives the callback queue of the transforms.
  ScanReader(const ros::NodeHandle& handle, const ScanReaderParams& params);

  /// Takes a scan in; it waits for its transforms.
  void push(const sensor_msgs::LaserScanConstPtr& message);
  /// The next scan in the order of arrival, with its transforms or with the fault that they did not come in time;
  /// nothing while the next must still wait.
  std::optional<ScanOrFault> next();
  [[nodiscard]] bool waiting() const { return !inbox_.empty(); }
  /// Forgets scans and transforms; for time that went back.
  void clear();

 private:
  struct Arrival {
    sensor_msgs::LaserScanConstPtr message;
    std::int64_t arrived_ns;  // wall time
  };
  ScanReaderParams params_;
  tf2::BufferCore tf_;
  std::unique_ptr<TfListener> listener_;
  std::deque<Arrival> inbox_;
  bool overflowed_ = false;
};

/// The transform of a planar pose.
geometry_msgs::TransformStamped planarTransform(const std::string& parent, const std::string& child,
                                                const slam::Pose2& pose, const ros::Time& stamp);

/// Seconds for a message, with two digits.
std::string secondsText(double value);

}  // namespace yarm
