// Transforms to the world, shared by the nodes of a process; fed on the executor's thread.
#pragma once

#include "yarm/ros/conversions.hpp"
#include "yarm/ros/tf_listener.hpp"

#include <ros/ros.h>
#include <tf2/buffer_core.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <string>

namespace yarm {

/// The transforms of the process: one listener for all nodes. Thread-safe.
class TfSource {
 public:
  /// The process's source; made with the first owner, gone with the last.
  static std::shared_ptr<TfSource> shared();

  /// World <- frame at a stamp, without waiting; or the reason why it cannot be known (yet).
  Read<Eigen::Isometry3d> at(const std::string& frame, std::int64_t stamp_ns) const;
  /// World <- frame at the newest time known, or the reason why there is none.
  Read<Eigen::Isometry3d> newest(const std::string& frame) const { return at(frame, 0); }

 private:
  TfSource();

  ros::NodeHandle handle_;
  tf2::BufferCore buffer_;
  std::unique_ptr<TfListener> listener_;
};

}  // namespace yarm
