#include "yarm/ros/slam_gmapping.hpp"

#include "yarm/ros/names.hpp"
#include "yarm/ros/unused_params.hpp"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <nav_msgs/OccupancyGrid.h>
#include <std_msgs/Float64.h>

namespace yarm {

namespace {

constexpr std::size_t kScanQueue = 10;
constexpr std::uint32_t kStateQueue = 10;

}  // namespace

SlamGmapping::SlamGmapping(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle)
    : params_(loadParams<SlamGmappingParams>(private_handle)),
      handle_(handle),
      mapper_(std::make_unique<slam::Mapper>(params_.slam)),
      health_(handle, "slam_gmapping: mapping", "slam") {
  const std::string unused = changedNames(params_.unused);
  if (!unused.empty()) {
    ROS_INFO_STREAM("slam_gmapping: set, but without effect here (they steer gmapping's particle filter): " << unused);
  }
  handle_.setCallbackQueue(&Executor::instance().queue());
  ros::NodeHandle own(private_handle);
  own.setCallbackQueue(&Executor::instance().queue());
  reader_ = std::make_unique<ScanReader>(
      handle_, ScanReaderParams{params_.base_frame, params_.odom_frame, params_.tf_wait, 0.0, params_.max_range});
  map_publisher_ = handle_.advertise<nav_msgs::OccupancyGrid>(names::MAP, 1, true);
  metadata_publisher_ = handle_.advertise<nav_msgs::MapMetaData>(names::MAP_METADATA, 1, true);
  entropy_publisher_ = own.advertise<std_msgs::Float64>("entropy", 1, true);
  state_publisher_ = own.advertise<diagnostic_msgs::DiagnosticArray>("state", kStateQueue, true);
  scans_ = handle_.subscribe(names::SCAN, kScanQueue, &SlamGmapping::onScan, this, ros::TransportHints().tcpNoDelay());
  service_ = handle_.advertiseService(names::DYNAMIC_MAP, &SlamGmapping::onGetMap, this);
  Executor::instance().add(*this);
}

SlamGmapping::~SlamGmapping() {
  Executor::instance().remove(*this);
}

void SlamGmapping::onScan(const sensor_msgs::LaserScanConstPtr& message) {
  if (clock_.wentBack(static_cast<std::int64_t>(ros::Time::now().toNSec()))) {
    reset();
  }
  if (scans_seen_++ % params_.throttle_scans != 0) {
    return;
  }
  reader_->push(message);
}

bool SlamGmapping::onGetMap(nav_msgs::GetMap::Request& /*request*/, nav_msgs::GetMap::Response& response) {
  if (!map_) {
    return false;
  }
  response.map = grid_;
  return true;
}

void SlamGmapping::poll() {
  const ros::Time now = ros::Time::now();
  if (clock_.wentBack(static_cast<std::int64_t>(now.toNSec()))) {
    reset();
  }
  while (const auto next = reader_->next()) {
    if (next->fault.empty() && saidAgain(next->scan)) {
      sendAgain();
    } else if (next->fault.empty()) {
      const auto result = take(next->scan);
      updateMap();  // after each scan: what a map holds must not depend on how many have waited
      if (result) {
        sendState(*result);
      }
    } else {
      drop(next->topic, next->fault);
    }
  }
  updateMap();
  const double period = params_.transform_publish_period;
  if (T_map_odom_ && period > 0.0 && (now - transform_sent_).toSec() >= period) {
    sendTransform(now);
  }
  if (health_.due()) {
    diagnose();
  }
}

bool SlamGmapping::waiting() const {
  return reader_->waiting();
}

std::optional<slam::ScanResult> SlamGmapping::take(const slam::Scan& scan) {
  slam::ScanResult result = mapper_->addScan(scan);
  if (result.status == slam::ScanStatus::kDropped) {
    drop("scan", result.reason);
    return std::nullopt;
  }
  if (result.status == slam::ScanStatus::kUnmatched) {
    ++scans_unmatched_;
    last_fault_ = result.reason;
    warn_("unmatched", "slam_gmapping: the pose runs on odometry alone: " + result.reason);
  }
  const bool is_first = !T_map_odom_.has_value();
  T_map_odom_ = result.T_map_odom;
  scan_stamp_.fromNSec(static_cast<std::uint64_t>(scan.stamp_ns));
  scan_beams_ = scan.ranges.size();
  if (is_first) {
    map_due_ = scan_stamp_;
  }
  if (params_.transform_publish_period > 0.0) {
    sendTransform(scan_stamp_);
  }
  if (result.status == slam::ScanStatus::kMatched || result.status == slam::ScanStatus::kKeyframe) {
    sendEntropy(result.entropy);
  }
  return result;
}

void SlamGmapping::drop(const std::string& key, const std::string& reason) {
  ++scans_dropped_;
  last_fault_ = reason;
  warn_(key, "slam_gmapping: scan dropped: " + reason);
}

void SlamGmapping::sendTransform(const ros::Time& time) {
  if (time <= transform_sent_) {
    return;  // tf keeps the first of two with one stamp; the next period sends the newest
  }
  const ros::Time stamp = time + ros::Duration(params_.tf_delay);
  broadcaster_.sendTransform(planarTransform(params_.map_frame, params_.odom_frame, *T_map_odom_, stamp));
  transform_sent_ = time;
}

bool SlamGmapping::saidAgain(const slam::Scan& scan) const {
  return T_map_odom_ && static_cast<std::uint64_t>(scan.stamp_ns) == scan_stamp_.toNSec() &&
         scan.ranges.size() == scan_beams_;
}

void SlamGmapping::sendAgain() {
  if (params_.transform_publish_period > 0.0 && transform_sent_ == scan_stamp_) {
    const ros::Time stamp = scan_stamp_ + ros::Duration(params_.tf_delay);
    broadcaster_.sendTransform(planarTransform(params_.map_frame, params_.odom_frame, *T_map_odom_, stamp));
  }
}

void SlamGmapping::sendEntropy(double entropy) {
  std_msgs::Float64 message;
  message.data = entropy;
  entropy_publisher_.publish(message);
}

void SlamGmapping::sendState(const slam::ScanResult& result) {
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = scan_stamp_;
  message.header.frame_id = params_.map_frame;
  message.status.resize(1);
  diagnostic_msgs::DiagnosticStatus& status = message.status.front();
  const bool unmatched = result.status == slam::ScanStatus::kUnmatched;
  status.name = "slam_gmapping: scan";
  status.level = unmatched ? diagnostic_msgs::DiagnosticStatus::WARN : diagnostic_msgs::DiagnosticStatus::OK;
  status.message = result.reason;
  status.values.resize(1);
  status.values.front().key = "map stamp, ns";
  status.values.front().value = std::to_string(map_ ? grid_.header.stamp.toNSec() : 0);
  state_publisher_.publish(message);
}

void SlamGmapping::updateMap() {
  if (T_map_odom_ && scan_stamp_ >= map_due_ && mapper_->requestMap()) {
    map_due_ = scan_stamp_ + ros::Duration(params_.map_update_interval);
  }
  const auto newest = mapper_->map();
  if (!newest || newest == map_) {
    return;
  }
  map_ = newest;
  grid_.header.stamp = scan_stamp_;
  grid_.header.frame_id = params_.map_frame;
  grid_.info.map_load_time = grid_.header.stamp;
  grid_.info.resolution = static_cast<float>(map_->resolution);
  grid_.info.width = static_cast<std::uint32_t>(map_->width);
  grid_.info.height = static_cast<std::uint32_t>(map_->height);
  grid_.info.origin.position.x = map_->origin_x;
  grid_.info.origin.position.y = map_->origin_y;
  grid_.info.origin.orientation.w = 1.0;
  grid_.data = map_->cells;
  map_publisher_.publish(grid_);
  metadata_publisher_.publish(grid_.info);
}

void SlamGmapping::reset() {
  ROS_WARN("slam_gmapping: time went back; starting afresh with an empty map");
  mapper_ = std::make_unique<slam::Mapper>(params_.slam);
  reader_->clear();
  T_map_odom_.reset();
  map_.reset();
  scan_stamp_ = transform_sent_ = map_due_ = ros::Time();
}

void SlamGmapping::diagnose() {
  const std::string topic = scans_.getTopic();
  const double silent_s = (ros::Time::now() - scan_stamp_).toSec();
  if (scans_seen_ == 0) {
    health_.warn(topic + ": nothing heard yet, " + std::to_string(scans_.getNumPublishers()) + " publishers");
  } else if (scan_stamp_.isZero()) {
    health_.warn(topic + ": no scan could be taken yet");
  } else if (silent_s > params_.scan_timeout) {
    health_.warn(topic + ": silent for " + secondsText(silent_s) + ", at most " + secondsText(params_.scan_timeout) +
                 "; is the sensor running?");
  }
  if (scans_dropped_ > 0) {
    health_.warn(topic + ": " + std::to_string(scans_dropped_) + " scans dropped: " + last_fault_);
  }
  if (scans_unmatched_ > 0) {
    health_.warn(topic + ": " + std::to_string(scans_unmatched_) + " scans unmatched: " + last_fault_);
  }
  const slam::Statistics& did = mapper_->statistics();
  health_.value("scans", did.scans);
  health_.value("keyframes", did.keyframes);
  health_.value("matched", did.matched);
  health_.value("unmatched", did.unmatched);
  health_.value("searches after slips, taken", did.searches_taken);
  health_.value("odometry jumps", did.odometry_jumps);
  health_.send(std::to_string(did.scans) + " scans, " + std::to_string(did.keyframes) + " keyframes");
  scans_dropped_ = 0;
  scans_unmatched_ = 0;
}

}  // namespace yarm
