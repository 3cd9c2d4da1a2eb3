#include "yarm/ros/scan_reader.hpp"

#include "yarm/ros/executor.hpp"

#include <tf2/exceptions.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace yarm {

namespace {

constexpr std::size_t kMostWaiting = 50;
constexpr double kMostTilt = 0.05;  // rad: a scan plane or a base tilted more is not planar

// The field of view may be lopsided: every beam has its own bearing.
slam::Scan toScan(const sensor_msgs::LaserScan& message, const slam::Pose2& T_base_sensor, bool upside_down,
                  const slam::Pose2& T_odom_base, const ScanReaderParams& params) {
  slam::Scan scan;
  const double side = upside_down ? -1.0 : 1.0;
  scan.stamp_ns = static_cast<std::int64_t>(message.header.stamp.toNSec());
  scan.angle_min = side * message.angle_min;
  scan.angle_increment = side * message.angle_increment;
  scan.range_min = std::max<double>(message.range_min, params.least_range);
  scan.range_max = std::min<double>(message.range_max, params.most_range);
  scan.ranges = message.ranges;
  scan.T_base_sensor = T_base_sensor;
  scan.T_odom_base = T_odom_base;
  return scan;
}

std::optional<slam::Pose2> planar(const tf2::BufferCore& tf, const std::string& to, const std::string& from,
                                  const ros::Time& stamp, bool* upside_down, std::string* reason) {
  geometry_msgs::TransformStamped found;
  try {
    found = tf.lookupTransform(to, from, stamp);
  } catch (const tf2::TransformException& error) {
    *reason = "no transform " + to + " <- " + from + " at the scan's time: " + error.what() + "; who publishes it?";
    return std::nullopt;
  }
  const auto& t = found.transform.translation;
  const auto& r = found.transform.rotation;
  const Eigen::Quaterniond rotation(r.w, r.x, r.y, r.z);
  if (!std::isfinite(t.x + t.y + t.z) || !(std::abs(rotation.norm() - 1.0) < 1e-3)) {
    *reason =
        "the transform " + to + " <- " + from + " is no rigid motion (not finite, or its quaternion not of length 1)";
    return std::nullopt;
  }
  const Eigen::Matrix3d axes = rotation.toRotationMatrix();
  *upside_down = axes(2, 2) < 0.0;
  if (std::acos(std::min(1.0, std::abs(axes(2, 2)))) > kMostTilt) {
    *reason = "the transform " + to + " <- " + from + " is tilted by more than " + std::to_string(kMostTilt) +
              " rad: only a level scan can be used";
    return std::nullopt;
  }
  return slam::Pose2{t.x, t.y, std::atan2(axes(1, 0), axes(0, 0))};
}

}  // namespace

ScanOrFault readScan(const sensor_msgs::LaserScan& message, const tf2::BufferCore& tf, const ScanReaderParams& params) {
  ScanOrFault result;
  const ros::Time& stamp = message.header.stamp;
  if (stamp.sec > kLatestStamp) {
    result.fault = "its stamp is " + std::to_string(stamp.sec) + " s, at most " + std::to_string(kLatestStamp) +
                   " s: what is sent some time after it has no stamp; is its clock right?";
    result.topic = "stamp";
    return result;
  }
  bool upside_down = false;
  bool base_upside_down = false;
  const auto mount = planar(tf, params.base_frame, message.header.frame_id, stamp, &upside_down, &result.fault);
  const auto odometry =
      mount ? planar(tf, params.odom_frame, params.base_frame, stamp, &base_upside_down, &result.fault) : std::nullopt;
  if (odometry) {
    result.scan = toScan(message, *mount, upside_down, *odometry, params);
  } else {
    result.topic = "transform";
  }
  return result;
}

ScanReader::ScanReader(const ros::NodeHandle& handle, const ScanReaderParams& params)
    : params_(params), listener_(std::make_unique<TfListener>(tf_, handle)) {}

void ScanReader::push(const sensor_msgs::LaserScanConstPtr& message) {
  inbox_.push_back({message, steadyNow()});
  if (inbox_.size() > kMostWaiting) {
    inbox_.pop_front();
    overflowed_ = true;
  }
}

std::optional<ScanOrFault> ScanReader::next() {
  ScanOrFault result;
  if (overflowed_) {
    overflowed_ = false;
    result.fault = std::to_string(kMostWaiting) + " scans wait for their transforms; the oldest is given up";
    result.topic = "queue";
    return result;
  }
  if (inbox_.empty()) {
    return std::nullopt;
  }
  const Arrival& first = inbox_.front();
  result = readScan(*first.message, tf_, params_);
  const bool in_time = static_cast<double>(steadyNow() - first.arrived_ns) < params_.tf_wait * 1e9;
  if (result.topic == "transform" && in_time) {
    return std::nullopt;
  }
  inbox_.pop_front();
  return result;
}

void ScanReader::clear() {
  tf_.clear();
  inbox_.clear();
  overflowed_ = false;
}

geometry_msgs::TransformStamped planarTransform(const std::string& parent, const std::string& child,
                                                const slam::Pose2& pose, const ros::Time& stamp) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform.translation.x = pose.x;
  message.transform.translation.y = pose.y;
  message.transform.rotation.z = std::sin(0.5 * pose.yaw);
  message.transform.rotation.w = std::cos(0.5 * pose.yaw);
  return message;
}

std::string secondsText(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f s", value);
  return text;
}

}  // namespace yarm
