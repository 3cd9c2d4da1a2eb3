#include "yarm/ros/amcl.hpp"

#include "yarm/ros/names.hpp"
#include "yarm/ros/unused_params.hpp"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseArray.h>
#include <std_msgs/Bool.h>
#include <std_msgs/String.h>

#include <cstdint>
#include <exception>
#include <utility>

namespace yarm {

namespace {

constexpr std::size_t kScanQueue = 10;
constexpr std::size_t kQueue = 2;
constexpr double kMostRange = 100.0;  // m

void check(const slam::LocaliserParams& params) {
  std::string text;
  for (const std::string& fault : slam::faultsOf(params)) {
    text += (text.empty() ? "" : "; ") + fault;
  }
  if (!text.empty()) {
    throw ParamError("amcl: " + text);
  }
}

}  // namespace

Amcl::Amcl(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle)
    : params_(loadParams<AmclParams>(private_handle)), handle_(handle), health_(handle, "amcl: localisation", "slam") {
  params_.localiser.submap.scan.use_range = kMostRange;  // laser_max_range has cut the scans already
  check(params_.localiser);
  const std::string unused = changedNames(params_.unused);
  if (!unused.empty()) {
    ROS_INFO_STREAM("amcl: set, but without effect here (they are for AMCL's particle filter and tools): " << unused);
  }
  handle_.setCallbackQueue(&Executor::instance().queue());
  ros::NodeHandle own(private_handle);
  own.setCallbackQueue(&Executor::instance().queue());
  ScanReaderParams reading{params_.base_frame_id, params_.odom_frame_id, params_.tf_wait, params_.laser_min_range};
  if (params_.laser_max_range >= 0.0) {
    reading.most_range = params_.laser_max_range;
  }
  reader_ = std::make_unique<ScanReader>(handle_, reading);
  connect(own);
  Executor::instance().add(*this);
}

void Amcl::connect(ros::NodeHandle& own) {
  pose_publisher_ = handle_.advertise<geometry_msgs::PoseWithCovarianceStamped>(names::AMCL_POSE, kQueue, true);
  cloud_publisher_ = handle_.advertise<geometry_msgs::PoseArray>(names::PARTICLE_CLOUD, kQueue, true);
  localised_publisher_ = own.advertise<std_msgs::Bool>("localised", kQueue, true);
  reason_publisher_ = own.advertise<std_msgs::String>("reason", kQueue, true);
  state_publisher_ = own.advertise<diagnostic_msgs::DiagnosticArray>("state", kQueue, true);
  scans_ = handle_.subscribe(names::SCAN, kScanQueue, &Amcl::onScan, this, ros::TransportHints().tcpNoDelay());
  maps_ = handle_.subscribe(names::MAP, 1, &Amcl::onMap, this);
  poses_ = handle_.subscribe(names::INITIAL_POSE, kQueue, &Amcl::onInitialPose, this);
  global_service_ = handle_.advertiseService(names::GLOBAL_LOCALIZATION, &Amcl::onGlobalLocalization, this);
  update_service_ = handle_.advertiseService(names::REQUEST_NOMOTION_UPDATE, &Amcl::onNoMotionUpdate, this);
  map_service_ = handle_.advertiseService(names::SET_MAP, &Amcl::onSetMap, this);
  std_msgs::Bool localised;
  localised_publisher_.publish(localised);
  told_reason_ = "no map";
  std_msgs::String reason;
  reason.data = told_reason_;
  reason_publisher_.publish(reason);
}

Amcl::~Amcl() {
  Executor::instance().remove(*this);
}

void Amcl::onScan(const sensor_msgs::LaserScanConstPtr& message) {
  if (clock_.wentBack(static_cast<std::int64_t>(ros::Time::now().toNSec()))) {
    reset();
  }
  ++scans_seen_;
  reader_->push(message);
}

void Amcl::onMap(const nav_msgs::OccupancyGridConstPtr& message) {
  if (localiser_ && params_.first_map_only) {
    return;
  }
  refuse(maps_.getTopic(), takeMap(*message));
}

std::string Amcl::takeMap(const nav_msgs::OccupancyGrid& message) {
  if (message.header.frame_id != params_.global_frame_id) {
    return "its frame is '" + message.header.frame_id + "', expected global_frame_id, '" + params_.global_frame_id +
           "'";
  }
  std::string fault;
  const auto map = gridOf(message, &fault);
  if (!map) {
    return fault;
  }
  std::unique_ptr<slam::Localiser> found;
  try {
    found = std::make_unique<slam::Localiser>(params_.localiser, map->grid, map->T_map_grid);
  } catch (const std::exception& error) {
    return error.what();
  }
  const bool is_first = !localiser_;
  localiser_ = std::move(found);
  if (is_first) {
    beginAtStart();
  } else if (result_.has_pose) {
    // The robot has not moved because its map has changed.
    const slam::PoseBelief before{result_.T_map_base, result_.covariance};
    localiser_->believe(before);
    localiser_->fitNext();
    beginWith(before);
  }
  ROS_INFO("amcl: a map of %d x %d cells of %.3f m", map->grid.width, map->grid.height, map->grid.resolution);
  return "";
}

void Amcl::beginAtStart() {
  localiser_->forget();
  beginWith(std::nullopt);
  if (params_.initial_pose_given) {
    const Eigen::Vector3d variances{params_.initial_cov_xx, params_.initial_cov_yy, params_.initial_cov_aa};
    const slam::PoseBelief start{
        {params_.initial_pose_x, params_.initial_pose_y, slam::wrapAngle(params_.initial_pose_a)},
        variances.asDiagonal()};
    localiser_->believe(start);
    beginWith(start);
  }
}

void Amcl::beginWith(const std::optional<slam::PoseBelief>& belief) {
  result_ = {};
  result_.reason = localiser_->doubt();
  if (belief) {
    result_.has_pose = true;
    result_.T_map_base = belief->pose;
    result_.covariance = belief->covariance;
  }
  tell();
}

void Amcl::onInitialPose(const geometry_msgs::PoseWithCovarianceStampedConstPtr& message) {
  refuse(poses_.getTopic(), takePose(*message));
}

std::string Amcl::takePose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  if (!localiser_) {
    return "no map has come yet on " + maps_.getTopic();
  }
  if (message.header.frame_id != params_.global_frame_id) {
    return "its frame is '" + message.header.frame_id + "', expected global_frame_id, '" + params_.global_frame_id +
           "'";
  }
  std::string fault;
  const auto belief = beliefOf(message.pose, &fault);
  if (!belief) {
    return fault;
  }
  fault = localiser_->believe(*belief);
  if (fault.empty()) {
    beginWith(belief);
    ROS_INFO("amcl: looked for around %.2f, %.2f m, %.2f rad", belief->pose.x, belief->pose.y, belief->pose.yaw);
  }
  return fault;
}

bool Amcl::onGlobalLocalization(std_srvs::Empty::Request& /*request*/, std_srvs::Empty::Response& /*response*/) {
  if (localiser_) {
    localiser_->forget();
    beginWith(std::nullopt);
    ROS_INFO("amcl: the pose is forgotten; the whole map is searched once the robot has turned");
  }
  return localiser_ != nullptr;
}

bool Amcl::onNoMotionUpdate(std_srvs::Empty::Request& /*request*/, std_srvs::Empty::Response& /*response*/) {
  if (localiser_) {
    localiser_->fitNext();
  }
  return localiser_ != nullptr;
}

bool Amcl::onSetMap(nav_msgs::SetMap::Request& request, nav_msgs::SetMap::Response& response) {
  std::string fault = takeMap(request.map);
  if (fault.empty()) {
    fault = takePose(request.initial_pose);
  }
  refuse(map_service_.getService(), fault);
  response.success = fault.empty();
  return true;
}

void Amcl::poll() {
  if (clock_.wentBack(static_cast<std::int64_t>(ros::Time::now().toNSec()))) {
    reset();
  }
  while (const auto next = reader_->next()) {
    if (!next->fault.empty()) {
      drop(next->topic, next->fault);
    } else if (!localiser_) {
      drop("map", "no map has come yet on " + maps_.getTopic() + ", " + std::to_string(maps_.getNumPublishers()) +
                      " publishers");
    } else {
      take(next->scan);
    }
  }
  if (health_.due()) {
    diagnose();
  }
}

bool Amcl::waiting() const {
  return reader_->waiting();
}

void Amcl::take(const slam::Scan& scan) {
  const slam::LocaliserResult result = localiser_->addScan(scan);
  if (result.dropped) {
    drop("scan", result.reason);
    return;
  }
  result_ = result;
  scan_stamp_.fromNSec(static_cast<std::uint64_t>(scan.stamp_ns));
  if (result_.has_pose && params_.tf_broadcast) {
    const ros::Time stamp = scan_stamp_ + ros::Duration(params_.transform_tolerance);
    broadcaster_.sendTransform(
        planarTransform(params_.global_frame_id, params_.odom_frame_id, result_.T_map_odom, stamp));
  }
  if (result_.has_pose && result_.updated) {
    publishPose(scan_stamp_);
  }
  publishCloud(scan_stamp_);
  publishState(scan_stamp_);
  tell();
}

void Amcl::refuse(const std::string& name, const std::string& fault) {
  if (!fault.empty()) {
    refused_ = name + " refused: " + fault;
    warn_(name, "amcl: " + refused_);
  }
}

void Amcl::drop(const std::string& key, const std::string& reason) {
  ++scans_dropped_;
  last_fault_ = reason;
  warn_(key, "amcl: scan dropped: " + reason);
}

void Amcl::publishPose(const ros::Time& stamp) {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = params_.global_frame_id;
  message.pose = beliefMessage({result_.T_map_base, result_.covariance});
  pose_publisher_.publish(message);
}

void Amcl::publishCloud(const ros::Time& stamp) {
  const double rate = params_.gui_publish_rate;
  const bool is_due = rate < 0.0 ? result_.updated : rate > 0.0 && (stamp - cloud_stamp_).toSec() * rate >= 1.0;
  if (!is_due) {
    return;
  }
  cloud_stamp_ = stamp;
  geometry_msgs::PoseArray message;
  message.header.stamp = stamp;
  message.header.frame_id = params_.global_frame_id;
  for (const slam::Pose2& pose : localiser_->sample(params_.max_particles, random_)) {
    message.poses.push_back(poseMessage(pose));
  }
  cloud_publisher_.publish(message);
}

void Amcl::publishState(const ros::Time& stamp) {
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = stamp;
  message.header.frame_id = result_.has_pose && params_.tf_broadcast ? params_.global_frame_id : "";
  message.status.resize(1);
  diagnostic_msgs::DiagnosticStatus& status = message.status.front();
  status.name = "amcl: place";
  status.level = result_.localised ? diagnostic_msgs::DiagnosticStatus::OK : diagnostic_msgs::DiagnosticStatus::WARN;
  status.message = result_.reason;
  state_publisher_.publish(message);
}

void Amcl::tell() {
  if (result_.localised != told_localised_) {
    told_localised_ = result_.localised;
    std_msgs::Bool message;
    message.data = told_localised_;
    localised_publisher_.publish(message);
    const slam::Pose2& pose = result_.T_map_base;
    if (told_localised_) {
      ROS_INFO("amcl: localised at %.2f, %.2f m, %.2f rad", pose.x, pose.y, pose.yaw);
    } else {
      ROS_WARN_STREAM("amcl: not localised: " << result_.reason);
    }
  }
  if (result_.reason != told_reason_) {
    told_reason_ = result_.reason;
    std_msgs::String message;
    message.data = told_reason_;
    reason_publisher_.publish(message);
  }
}

void Amcl::reset() {
  ROS_WARN("amcl: time went back; starting afresh in the same map");
  reader_->clear();
  scan_stamp_ = cloud_stamp_ = ros::Time();
  if (localiser_) {
    localiser_->restart();
    beginAtStart();
  }
}

void Amcl::diagnose() {
  const std::string topic = scans_.getTopic();
  const double silent_s = (ros::Time::now() - scan_stamp_).toSec();
  if (!localiser_) {
    health_.warn(maps_.getTopic() + ": no map yet, " + std::to_string(maps_.getNumPublishers()) + " publishers");
  }
  if (scans_seen_ == 0) {
    health_.warn(topic + ": nothing heard yet, " + std::to_string(scans_.getNumPublishers()) + " publishers");
  } else if (localiser_ && scan_stamp_.isZero()) {
    health_.warn(topic + ": no scan could be taken yet");
  } else if (localiser_ && silent_s > params_.scan_timeout) {
    health_.warn(topic + ": silent for " + secondsText(silent_s) + ", at most " + secondsText(params_.scan_timeout) +
                 "; is the sensor running?");
  }
  if (scans_dropped_ > 0) {
    health_.warn(topic + ": " + std::to_string(scans_dropped_) + " scans dropped: " + last_fault_);
  }
  if (!refused_.empty()) {
    health_.warn(refused_);
  }
  if (localiser_ && !result_.localised) {
    health_.warn("not localised: " + result_.reason);
  }
  if (localiser_) {
    const slam::PlaceSearch& search = localiser_->lastSearch();
    health_.value("state", slam::toString(localiser_->state()));
    health_.value("agreement of the last scan", result_.agreement);
    health_.value("score of the last search", search.places.empty() ? 0.0 : search.places.front().score);
    health_.value("margin of the last search", search.margin);
  }
  health_.send("localised");
  scans_dropped_ = 0;
  refused_.clear();
}

}  // namespace yarm
