#include "yarm/ros/tf_source.hpp"

#include "yarm/ros/conversions.hpp"
#include "yarm/ros/executor.hpp"
#include "yarm/ros/names.hpp"

#include <tf2/exceptions.h>

namespace yarm {

TfSource::TfSource() {
  handle_.setCallbackQueue(&Executor::instance().queue());
  listener_ = std::make_unique<tf2_ros::TransformListener>(buffer_, handle_, false, ros::TransportHints().tcpNoDelay());
}

std::shared_ptr<TfSource> TfSource::shared() {
  static std::weak_ptr<TfSource> kept;
  std::shared_ptr<TfSource> source = kept.lock();
  if (!source) {
    source.reset(new TfSource());
    kept = source;
  }
  return source;
}

std::optional<Eigen::Isometry3d> TfSource::at(const std::string& frame, std::int64_t stamp_ns,
                                              std::string* reason) const {
  if (frame.empty() || !buffer_._frameExists(frame)) {
    *reason = "frame '" + frame + "' is unknown to tf";
    return std::nullopt;
  }
  try {
    const auto stamped = buffer_.lookupTransform(names::WORLD_FRAME, frame, toTime(stamp_ns));
    const Read<Eigen::Isometry3d> pose = readTransform(stamped.transform);
    *reason = pose.reason;
    return pose.ok() ? std::optional<Eigen::Isometry3d>(pose.value) : std::nullopt;
  } catch (const tf2::TransformException& error) {
    *reason = error.what();
    return std::nullopt;
  }
}

std::optional<Eigen::Isometry3d> TfSource::newest(const std::string& frame) const {
  std::string reason;
  return at(frame, 0, &reason);
}

}  // namespace yarm
