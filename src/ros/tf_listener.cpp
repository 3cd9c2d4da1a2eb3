#include "yarm/ros/tf_listener.hpp"

#include <tf2/exceptions.h>

namespace yarm {

namespace {
constexpr std::uint32_t kQueue = 100;
constexpr double kWarnPeriodS = 5.0;
}  // namespace

std::string takeTransforms(const tf2_msgs::TFMessage& message, bool is_static, tf2::BufferCore& buffer) {
  std::string fault;
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    std::string reason;
    if (transform.header.stamp.sec > kLatestStamp) {
      reason = "its stamp is " + std::to_string(transform.header.stamp.sec) + " s, at most " +
               std::to_string(kLatestStamp) + " s";
    } else {
      try {
        buffer.setTransform(transform, "tf", is_static);
      } catch (const tf2::TransformException& error) {
        reason = error.what();
      }
    }
    if (fault.empty() && !reason.empty()) {
      fault = transform.header.frame_id + " <- " + transform.child_frame_id + " is left out: " + reason;
    }
  }
  return fault;
}

TfListener::TfListener(tf2::BufferCore& buffer, ros::NodeHandle handle) : buffer_(buffer) {
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  moving_ = handle.subscribe<tf2_msgs::TFMessage>(
      "/tf", kQueue, [this](const tf2_msgs::TFMessageConstPtr& message) { onTransforms(message, false); },
      ros::VoidConstPtr(), hints);
  fixed_ = handle.subscribe<tf2_msgs::TFMessage>(
      "/tf_static", kQueue, [this](const tf2_msgs::TFMessageConstPtr& message) { onTransforms(message, true); },
      ros::VoidConstPtr(), hints);
}

void TfListener::onTransforms(const tf2_msgs::TFMessageConstPtr& message, bool is_static) {
  const ros::Time now = ros::Time::now();
  if (now < newest_) {
    ROS_WARN("time went back; the transforms of before are forgotten");
    buffer_.clear();
  }
  newest_ = now;
  const std::string fault = takeTransforms(*message, is_static, buffer_);
  if (!fault.empty()) {
    ROS_WARN_THROTTLE(kWarnPeriodS, "%s: %s", is_static ? "/tf_static" : "/tf", fault.c_str());
  }
}

}  // namespace yarm
