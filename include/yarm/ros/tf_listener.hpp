// /tf and /tf_static into a buffer. tf2_ros's listener lets tf2 throw at a stamp near the end of ROS's time, which
// would end the process.
#pragma once

#include <ros/ros.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <string>

namespace yarm {

/// The latest stamp, s, to which times of some seconds can be added.
constexpr std::uint32_t kLatestStamp = 0x7fffffff;

/// Puts transforms into a buffer; gives what is wrong with the first that cannot be taken, or nothing.
std::string takeTransforms(const tf2_msgs::TFMessage& message, bool is_static, tf2::BufferCore& buffer);

/// Feeds a buffer with what is published; forgets everything when time goes back.
class TfListener {
 public:
  /// `handle` gives the callback queue.
  TfListener(tf2::BufferCore& buffer, ros::NodeHandle handle);

 private:
  void onTransforms(const tf2_msgs::TFMessageConstPtr& message, bool is_static);

  tf2::BufferCore& buffer_;
  ros::Time newest_;  ///< time at the last message
  ros::Subscriber moving_;
  ros::Subscriber fixed_;
};

}  // namespace yarm
