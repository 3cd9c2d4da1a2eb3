#include "yarm/ros/tf_source.hpp"

#include "yarm/ros/executor.hpp"
#include "yarm/ros/names.hpp"

#include <tf2/exceptions.h>

namespace yarm {

TfSource::TfSource() {
  handle_.setCallbackQueue(&Executor::instance().queue());
  listener_ = std::make_unique<TfListener>(buffer_, handle_);
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

Read<Eigen::Isometry3d> TfSource::at(const std::string& frame, std::int64_t stamp_ns) const {
  if (frame.empty() || !buffer_._frameExists(frame)) {
    return {Eigen::Isometry3d::Identity(), "frame '" + frame + "' is unknown to tf"};
  }
  try {
    return readTransform(buffer_.lookupTransform(names::WORLD_FRAME, frame, toTime(stamp_ns)).transform);
  } catch (const tf2::TransformException& error) {
    return {Eigen::Isometry3d::Identity(), error.what()};
  }
}

}  // namespace yarm
