#include "yarm/ros/merge_clouds.hpp"

#include "yarm/ros/in_process.hpp"
#include "yarm/ros/side_object.hpp"

#include <algorithm>

namespace yarm {

namespace {

constexpr std::int64_t kConfirmRestartNs = 200'000'000;  // wall time the clock has to follow a stamp that went back
constexpr std::int64_t kMostAheadNs = 5'000'000'000;     // simulated time a stamp may be ahead of the clock
constexpr int kCloudQueue = 8;

std::int64_t ns(double seconds) {
  return static_cast<std::int64_t>(seconds * 1e9);
}

SetAssemblerOptions assemblerOptions(const MergeCloudsParams& params) {
  SetAssemblerOptions options;
  options.cameras = params.camera_topics.size();
  options.tolerance_ns = ns(params.sync_tolerance);
  options.timeout_ns = ns(params.sync ? kSyncWaitS : params.camera_timeout);
  options.free_running = !params.sync;
  options.silent_grace_ns = params.sync ? ns(0.02) : 0;
  return options;
}

bool isAhead(const sensor_msgs::PointCloud2& message) {
  const ros::Time now = ros::Time::now();
  return !now.isZero() && toNs(message.header.stamp) - toNs(now) > kMostAheadNs;
}

std::string percent(double share) {
  char text[16];
  std::snprintf(text, sizeof(text), "%.1f %%", 100.0 * share);
  return text;
}

MergeCloudsParams checked(MergeCloudsParams params, const std::string& where) {
  if (params.camera_topics.empty()) {
    throw ParamError(where + ": camera_topics: at least one is needed");
  }
  if (!params.camera_frames.empty() && params.camera_frames.size() != params.camera_topics.size()) {
    throw ParamError(where + ": camera_frames: " + std::to_string(params.camera_frames.size()) + " frames for " +
                     std::to_string(params.camera_topics.size()) + " topics; give one each, or []");
  }
  return params;
}

}  // namespace

MergeClouds::MergeClouds(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle)
    : params_(checked(loadParams<MergeCloudsParams>(private_handle), private_handle.getNamespace())),
      handle_(handle),
      backend_(perception::makeBackend(params_.backend, params_.mergeParams(), perception::ClusterParams())),
      tf_(TfSource::shared()),
      assembler_(assemblerOptions(params_)),
      view_(params_.view, params_.camera_topics.size()),
      pictures_(params_.pictures, params_.camera_topics.size()),
      cameras_(params_.camera_topics.size()),
      wait_ns_(ns(params_.sync ? kSyncWaitS : params_.tf_wait)),
      health_(handle, "merge_clouds: cameras"),
      visibility_(handle_, params_) {
  handle_.setCallbackQueue(&Executor::instance().queue());
  merged_ = handle_.advertise<sensor_msgs::PointCloud2>(names::MERGED_POINTS, 10);
  voxels_ = handle_.advertise<sensor_msgs::PointCloud2>(names::VOXELIZED_CLOUD, 10);
  for (std::size_t index = 0; index < cameras_.size(); ++index) {
    subscribe(index);
  }
  Executor::instance().add(*this);
}

MergeClouds::~MergeClouds() {
  Executor::instance().remove(*this);
}

void MergeClouds::subscribe(std::size_t index) {
  Camera& camera = cameras_[index];
  camera.topic = params_.camera_topics[index];
  camera.frame = params_.camera_frames.empty() ? "" : params_.camera_frames[index];
  ros::SubscribeOptions options;
  options.init<sensor_msgs::PointCloud2>(
      camera.topic, kCloudQueue,
      [this, index](const sensor_msgs::PointCloud2ConstPtr& message) { onCloud(index, message); },
      [this] { return clouds_.acquire(); });
  options.transport_hints = ros::TransportHints().tcpNoDelay();
  camera.subscriber = handle_.subscribe(options);
}

void MergeClouds::onCloud(std::size_t index, const sensor_msgs::PointCloud2ConstPtr& message) {
  Camera& camera = cameras_[index];
  camera.heard = true;
  const Read<perception::CameraCloud> view = viewOf(*message);
  if (!view.ok()) {
    drop(index, *message, view.reason);
  } else if (!camera.frame.empty() && message->header.frame_id != camera.frame) {
    refuseFrame(index, *message);
  } else if (isAhead(*message)) {
    const double ahead_s = (message->header.stamp - ros::Time::now()).toSec();
    drop(index, *message, "its stamp is " + std::to_string(ahead_s) + " s ahead of the clock");
  } else {
    camera.wrong_frame.clear();
    camera.picture = pictures_.judge(index, view.value);
    if (camera.picture.frozen) {
      char text[96];
      std::snprintf(text, sizeof(text), "frozen: it has been the same to the byte for %.1f s", camera.picture.same_s);
      drop(index, *message, text);
      return;
    }
    camera.inbox.push_back({message, view.value, steadyNow()});
  }
}

// A wrong frame stays wrong: it is said once, and again when it changes.
void MergeClouds::refuseFrame(std::size_t index, const sensor_msgs::PointCloud2& message) {
  Camera& camera = cameras_[index];
  const std::string& frame = message.header.frame_id;
  const std::string reason = "frame '" + frame + "', must be '" + camera.frame + "' (parameter camera_frames)";
  if (camera.wrong_frame != frame) {
    ROS_WARN_STREAM(camera.topic << ": every cloud is dropped: " << reason);
    camera.wrong_frame = frame;
  }
  leaveOut(index, message, reason);
}

void MergeClouds::drop(std::size_t index, const sensor_msgs::PointCloud2& message, const std::string& reason) {
  const std::string& topic = cameras_[index].topic;
  warn_(topic, topic + ": cloud dropped: " + reason);
  leaveOut(index, message, reason);
}

void MergeClouds::leaveOut(std::size_t index, const sensor_msgs::PointCloud2& message, const std::string& reason) {
  Camera& camera = cameras_[index];
  ++camera.dropped;
  camera.last_fault = reason;
  if (isAhead(message)) {
    return;
  }
  const std::int64_t stamp_ns = toNs(message.header.stamp);
  if (assembler_.skip(index, stamp_ns, steadyNow()) == Admission::accepted) {
    camera.newest_ns = stamp_ns;
  }
}

void MergeClouds::poll() {
  const std::int64_t now_ns = steadyNow();
  if (clock_.wentBack(toNs(ros::Time::now()))) {
    reset();
  }
  for (std::size_t index = 0; index < cameras_.size(); ++index) {
    while (!cameras_[index].inbox.empty() && settle(index, now_ns)) {
    }
  }
  release(now_ns);
  if (health_.due()) {
    diagnose(now_ns);
  }
  visibility_.diagnose();
}

bool MergeClouds::waiting() const {
  return assembler_.pending() > 0 ||
         std::any_of(cameras_.begin(), cameras_.end(), [](const Camera& camera) { return !camera.inbox.empty(); });
}

bool MergeClouds::settle(std::size_t index, std::int64_t now_ns) {
  Camera& camera = cameras_[index];
  Arrival& arrival = camera.inbox.front();
  const std::int64_t waited_ns = now_ns - arrival.arrived_ns;
  const std::int64_t stamp_ns = arrival.view.stamp_ns;
  if (camera.newest_ns != 0 && stamp_ns <= camera.newest_ns) {
    const std::int64_t back_ns = camera.newest_ns - stamp_ns;
    if (back_ns > kJumpBackNs && waited_ns < kConfirmRestartNs) {
      return false;
    }
    const Arrival old = std::move(arrival);
    camera.inbox.pop_front();
    drop(index, *old.message, "stamp went back by " + std::to_string(static_cast<double>(back_ns) * 1e-9) + " s");
    return true;
  }
  const Read<Eigen::Isometry3d> pose = tf_->at(arrival.message->header.frame_id, stamp_ns);
  if (!pose.ok() && waited_ns < wait_ns_ && !camera.lost) {
    return false;
  }
  camera.lost = !pose.ok();
  Arrival settled = std::move(arrival);
  camera.inbox.pop_front();
  if (!pose.ok()) {
    drop(index, *settled.message, "no transform: " + pose.reason);
    return true;
  }
  settled.view.T_world_camera = pose.value.cast<float>();
  camera.newest_ns = stamp_ns;
  if (assembler_.add(index, stamp_ns, now_ns, std::move(settled)) == Admission::late) {
    ++camera.late;
  }
  return true;
}

void MergeClouds::release(std::int64_t now_ns) {
  while (auto set = assembler_.take(now_ns)) {
    const auto gap_ns = ns(0.999 / params_.max_frequency);
    if (!published_ns_ || set->stamp_ns - *published_ns_ >= gap_ns) {
      published_ns_ = set->stamp_ns;
      process(*set);
    }
  }
}

void MergeClouds::process(CameraSet<Arrival>& set) {
  std::vector<perception::CameraCloud> clouds(cameras_.size());
  for (std::size_t index = 0; index < clouds.size(); ++index) {
    if (set.items[index]) {
      clouds[index] = set.items[index]->view;
    } else {
      clouds[index].stamp_ns = set.stamp_ns;
    }
  }
  const auto merged = sets_.acquire();
  backend_->merge(clouds, *merged);
  merged->stamp_ns = set.stamp_ns;
  if (judge(set, *merged)) {
    visibility_.add(clouds, *merged);  // first: the map waits for what it says
    publish(merged);
    return;
  }
  ++too_little_;
  warn_("view", "merge_clouds: too little view, no map: " + blindness());
}

bool MergeClouds::judge(const CameraSet<Arrival>& set, perception::MergedSet& merged) {
  for (std::size_t index = 0; index < cameras_.size(); ++index) {
    Camera& camera = cameras_[index];
    const perception::CameraReport& report = merged.cameras[index];
    camera.delivered = set.items[index].has_value();
    camera.view.sees = false;
    camera.view.share = 0.0;
    if (set.items[index]) {
      camera.view = view_.judge(index, report);
      camera.judged = true;
      camera.absurd += report.absurd > 0 ? 1 : 0;
    }
    if (report.dropped) {
      ++camera.dropped;
      camera.last_fault = std::to_string(report.absurd) + " of " + std::to_string(report.points) +
                          " points are infinite or absurd, at most " + percent(params_.merge.absurd_share) + " may be";
      warn_(camera.topic, camera.topic + ": cloud dropped: " + camera.last_fault);
    }
    if (!camera.view.sees) {
      merged.absent.push_back(static_cast<std::int32_t>(index));
    }
  }
  return cameras_.size() - merged.absent.size() >= view_.needed();
}

std::string MergeClouds::blindness() const {
  std::string seen;
  std::size_t seeing = 0;
  for (const Camera& camera : cameras_) {
    seeing += camera.view.sees ? 1U : 0U;
    if (!camera.view.sees) {
      seen += "; " + camera.topic +
              (camera.delivered ? " has no view (" + percent(camera.view.share) +
                                      " of its points are finite, usually " + percent(camera.view.usual) + ")"
                                : " gave no cloud for it");
    }
  }
  return std::to_string(seeing) + " of " + std::to_string(cameras_.size()) + " cameras see, at least " +
         std::to_string(view_.needed()) + " must" + seen;
}

void MergeClouds::publish(const boost::shared_ptr<perception::MergedSet>& set) {
  ++published_;
  std_msgs::Header header;
  header.stamp = toTime(set->stamp_ns);
  header.frame_id = names::WORLD_FRAME;
  if (voxels_.getNumSubscribers() > 0) {
    const auto message = boost::make_shared<sensor_msgs::PointCloud2>();
    message->header = header;
    fillVoxels(*set, *message);
    voxels_.publish(message);
  }
  if (merged_.getNumSubscribers() > 0) {
    auto message = std::make_unique<sensor_msgs::PointCloud2>();
    message->header = header;
    if (hasRemoteSubscribers(merged_)) {
      fillMergedPoints(*set, *message);
    }
    merged_.publish(withSide(std::move(message), set));
  }
}

void MergeClouds::reset() {
  ROS_WARN("merge_clouds: time went back; starting afresh");
  assembler_.reset();
  view_.reset();
  pictures_.reset();
  visibility_.reset();
  published_ns_.reset();
  for (Camera& camera : cameras_) {
    camera.newest_ns = 0;
  }
}

void MergeClouds::diagnose(std::int64_t now_ns) {
  if (too_little_ > 0) {
    health_.error("too little view, " + std::to_string(too_little_) + " sets are no maps: " + blindness());
  }
  for (std::size_t index = 0; index < cameras_.size(); ++index) {
    diagnoseCamera(index, now_ns);
  }
  health_.value("sets", published_);
  health_.value("sets with too little view", too_little_);
  health_.send(std::to_string(published_) + " sets");
  published_ = 0;
  too_little_ = 0;
}

void MergeClouds::diagnoseCamera(std::size_t index, std::int64_t now_ns) {
  Camera& camera = cameras_[index];
  const double silent_s = static_cast<double>(assembler_.silentFor(index, now_ns)) * 1e-9;
  if (!camera.heard) {
    health_.warn(camera.topic + ": nothing heard yet, " + std::to_string(camera.subscriber.getNumPublishers()) +
                 " publishers");
  } else if (assembler_.isSilent(index, now_ns)) {
    char text[64];
    std::snprintf(text, sizeof(text), ": silent for %.1f s", silent_s);
    health_.warn(camera.topic + text);
  }
  if (camera.dropped > 0) {
    health_.warn(camera.topic + ": " + std::to_string(camera.dropped) + " clouds dropped: " + camera.last_fault);
  } else if (camera.judged && !camera.view.sees) {
    health_.warn(camera.topic + ": blind: " + percent(camera.view.share) + " of its points are finite, usually " +
                 percent(camera.view.usual));
  }
  if (camera.picture.covered > 0.0) {
    health_.warn(camera.topic + ": " + percent(camera.picture.covered) + " of its image, around pixel " +
                 std::to_string(camera.picture.u) + ", " + std::to_string(camera.picture.v) +
                 ", used to have readings and has none: dirt on the lens, or something that swallows its light");
  }
  if (camera.absurd > 0) {
    health_.warn(camera.topic + ": infinite or absurd points in " + std::to_string(camera.absurd) + " clouds");
  }
  health_.value(camera.topic + " silent for, s", silent_s);
  health_.value(camera.topic + " dropped", camera.dropped);
  health_.value(camera.topic + " too late for their set", camera.late);
  health_.value(camera.topic + " view, share of finite points", camera.view.share);
  camera.dropped = 0;
  camera.late = 0;
  camera.absurd = 0;
  camera.judged = false;
}

}  // namespace yarm
