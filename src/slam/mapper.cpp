#include "yarm/slam/mapper.hpp"

#include "yarm/slam/coarse_search.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace yarm::slam {

namespace {

constexpr int kLeastInView = 15;       // fewer points in view of the neighbours say nothing: new ground
constexpr double kSearchMargin = 0.1;  // share of pairs that a search's answer must win
constexpr double kGiveUpWays = 2.0;    // keyframe distances without a match after which odometry alone makes one
constexpr int kRefineRounds = 2;
constexpr int kRefineIterations = 20;
constexpr double kFirstSigma = 0.01;  // m, rad: the pose of the first keyframe is a convention, not a measurement

std::string joined(const std::vector<std::string>& faults) {
  std::string text;
  for (const std::string& fault : faults) {
    text += (text.empty() ? "" : "; ") + fault;
  }
  return text;
}

const Params& checked(const Params& params) {
  const auto faults = faultsOf(params);
  if (!faults.empty()) {
    throw std::invalid_argument(joined(faults));
  }
  return params;
}

// Turns information about (x, y, yaw) from the map's axes to those of a pose.
Eigen::Matrix3d alongPose(const Eigen::Matrix3d& information, double yaw) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() << std::cos(yaw), -std::sin(yaw), std::sin(yaw), std::cos(yaw);
  return turn.transpose() * information * turn;
}

double square(double value) {
  return value * value;
}

bool isNewGround(const MatchResult& match) {
  return match.in_view < kLeastInView;
}

}  // namespace

Mapper::Mapper(const Params& params, const Pose2& T_map_base)
    : params_(checked(params)),
      T_map_base_start_(T_map_base),
      keyframes_(params.keyframe),
      drawer_(params.map, params.scan),
      worker_(params.sync) {}

ScanResult Mapper::addScan(const Scan& scan) {
  ++statistics_.scans;
  ScanResult result;
  result.reason = faultOf(scan);
  if (result.reason.empty() && begun_ && scan.stamp_ns <= stamp_ns_) {
    result.reason = "the scan's stamp is " + std::to_string(1e-9 * static_cast<double>(stamp_ns_ - scan.stamp_ns)) +
                    " s before or at the last one's; start afresh when time went back";
  }
  if (!result.reason.empty()) {
    ++statistics_.dropped;
    return resultFor(scan, result);
  }
  takeOptimised();
  if (!begun_) {
    begin(scan);
    result.status = ScanStatus::kKeyframe;
    return resultFor(scan, result);
  }
  if (!moveOn(scan)) {
    ++statistics_.odometry_jumps;
    result.status = ScanStatus::kUnmatched;
    result.reason = "odometry jumped since the last scan: taken as a fault of the odometry, not as motion";
    return resultFor(scan, result);
  }
  result.status = ScanStatus::kPredicted;
  if (isDue(scan)) {
    takeMatch(scan, result);
  }
  keepForMap(scan);
  return resultFor(scan, result);
}

void Mapper::begin(const Scan& scan) {
  T_odom_base_ = scan.T_odom_base;
  T_odom_sensor_ = scan.T_odom_base * scan.T_base_sensor;
  stamp_ns_ = scan.stamp_ns;
  auto points = std::make_shared<const ScanPoints>(scan, params_.scan);
  const int first = keyframes_.add(std::move(points), T_map_base_start_ * scan.T_base_sensor);
  begun_ = true;
  statistics_.keyframes = 1;
  moveAnchor(first, keyframes_.pose(first), Eigen::Matrix3d::Identity() / (kFirstSigma * kFirstSigma));
  keepForMap(scan);
}

bool Mapper::moveOn(const Scan& scan) {
  const Pose2 T_odom_sensor = scan.T_odom_base * scan.T_base_sensor;
  const double way = scan.T_odom_base.distanceTo(T_odom_base_);
  const double turn = std::abs(wrapAngle(scan.T_odom_base.yaw - T_odom_base_.yaw));
  const bool believed = way <= params_.odometry.jump_m && turn <= params_.odometry.jump_rad;
  if (believed) {
    anchor_.way_m += way;
    anchor_.turn_rad += turn;
  } else {
    // The new numbers are believed from here on; the robot stands where it was.
    anchor_.T_odom_sensor = T_odom_sensor * (T_odom_sensor_.inverse() * anchor_.T_odom_sensor);
  }
  T_odom_base_ = scan.T_odom_base;
  T_odom_sensor_ = T_odom_sensor;
  stamp_ns_ = scan.stamp_ns;
  return believed;
}

bool Mapper::isDue(const Scan& scan) const {
  const KeyframeParams& limits = params_.keyframe;
  const Pose2 moved = anchor_.T_odom_sensor.inverse() * T_odom_sensor_;
  return std::hypot(moved.x, moved.y) >= limits.distance || std::abs(moved.yaw) >= limits.angle ||
         (limits.interval_s >= 0.0 &&
          1e-9 * static_cast<double>(scan.stamp_ns - anchor_.stamp_ns) >= limits.interval_s);
}

Pose2 Mapper::predicted() const {
  return keyframes_.pose(anchor_.keyframe) * anchor_.T_keyframe_sensor *
         (anchor_.T_odom_sensor.inverse() * T_odom_sensor_);
}

Eigen::Matrix3d Mapper::odometryCovariance() const {
  const OdometryParams& odometry = params_.odometry;
  const double along = odometry.sigma_m + odometry.sigma_m_per_m * anchor_.way_m;
  const double turn =
      odometry.sigma_rad + odometry.sigma_rad_per_m * anchor_.way_m + odometry.sigma_rad_per_rad * anchor_.turn_rad;
  return Eigen::Vector3d(along * along, along * along, turn * turn).asDiagonal();
}

PosePrior Mapper::prior() const {
  return {predicted(), odometryCovariance().inverse()};
}

MatchResult Mapper::locate(const ScanPoints& points, std::vector<int>& neighbours) {
  const PosePrior expected = prior();
  neighbours = keyframes_.recent();
  MatchResult near = matchScan(points, expected.pose, keyframes_.targets(neighbours), expected, params_.match);
  const bool near_holds = near.ok || isNewGround(near);
  const auto old = keyframes_.overlapping(points, near_holds ? near.T_map_sensor : expected.pose);
  neighbours.insert(neighbours.end(), old.begin(), old.end());
  if (!old.empty()) {
    const Pose2 start = near_holds ? near.T_map_sensor : expected.pose;
    const MatchResult all = matchScan(points, start, keyframes_.targets(neighbours), expected, params_.match);
    if (all.ok) {
      return all;
    }
  }
  if (near_holds) {
    near.ok = true;
    return near;
  }
  return search(points, neighbours, near);
}

MatchResult Mapper::search(const ScanPoints& points, const std::vector<int>& neighbours, const MatchResult& failed) {
  ++statistics_.searches;
  const auto targets = keyframes_.targets(neighbours);
  const SearchResult place = searchCoarsely(points, predicted(), targets, params_.keyframe);
  if (!place.found) {
    return failed;
  }
  MatchResult match = matchScan(points, place.T_map_sensor, targets, std::nullopt, params_.match);
  if (match.ok && !isNewGround(match) && match.share() > failed.share() + kSearchMargin) {
    ++statistics_.searches_taken;
    return match;
  }
  return failed;
}

void Mapper::takeMatch(const Scan& scan, ScanResult& result) {
  auto points = std::make_shared<const ScanPoints>(scan, params_.scan);
  if (static_cast<int>(points->points().size()) < params_.scan.least_points) {
    result.status = ScanStatus::kUnmatched;
    result.reason = "the scan has " + std::to_string(points->points().size()) + " usable points, at least " +
                    std::to_string(params_.scan.least_points) + " are needed: nothing but odometry";
    return;
  }
  std::vector<int> neighbours;
  MatchResult match = locate(*points, neighbours);
  if (!match.ok) {
    ++statistics_.unmatched;
    result.status = ScanStatus::kUnmatched;
    result.reason = match.reason;
    if (anchor_.way_m < kGiveUpWays * params_.keyframe.distance &&
        anchor_.turn_rad < kGiveUpWays * params_.keyframe.angle) {
      return;  // the next scan tries again
    }
    match = MatchResult();
    match.T_map_sensor = predicted();
    addKeyframe(std::move(points), match, {});
    return;
  }
  ++statistics_.matched;
  proveScans(match.T_map_sensor);
  const auto known = keyframes_.knownPlace(match.T_map_sensor);
  if (known) {
    result.status = ScanStatus::kMatched;
    moveAnchor(*known, match.T_map_sensor, match.information + prior().information);
    return;
  }
  result.status = ScanStatus::kKeyframe;
  addKeyframe(std::move(points), match, neighbours);
}

void Mapper::addKeyframe(std::shared_ptr<const ScanPoints> points, const MatchResult& match,
                         const std::vector<int>& neighbours) {
  const PosePrior expected = prior();
  PoseEdge odometry;
  odometry.is_odometry = true;
  odometry.from = anchor_.keyframe;
  odometry.T_from_to = anchor_.T_keyframe_sensor * (anchor_.T_odom_sensor.inverse() * T_odom_sensor_);
  odometry.information = alongPose(expected.information, match.T_map_sensor.yaw);
  odometry.to = keyframes_.add(std::move(points), match.T_map_sensor);
  keyframes_.addEdge(odometry);
  const bool astray = addEdges(odometry.to, neighbours);
  statistics_.keyframes = keyframes_.size();
  statistics_.edges = static_cast<int>(keyframes_.edges().size());
  moveAnchor(odometry.to, match.T_map_sensor, match.information + expected.information);
  ++since_optimised_;
  if (astray || since_optimised_ >= params_.graph.every) {
    optimizeSoon();
  }
}

std::optional<PoseEdge> Mapper::matchedEdge(int from, int to) const {
  const MatchResult match =
      matchScan(keyframes_.points(to), keyframes_.pose(to), {keyframes_.target(from)}, std::nullopt, params_.match);
  if (!match.ok || isNewGround(match)) {
    return std::nullopt;
  }
  return PoseEdge{from, to, keyframes_.pose(from).inverse() * match.T_map_sensor,
                  alongPose(match.information, match.T_map_sensor.yaw), false};
}

bool Mapper::addEdges(int keyframe, const std::vector<int>& neighbours) {
  bool astray = false;
  for (const int neighbour : neighbours) {
    if (const auto edge = matchedEdge(neighbour, keyframe)) {
      const double off = squaredErrorOf(*edge, keyframes_.pose(neighbour), keyframes_.pose(keyframe));
      astray = astray || (Keyframes::isAnotherVisit(neighbour, keyframe) && off > square(params_.graph.cauchy));
      keyframes_.addEdge(*edge);
    }
  }
  return astray;
}

void Mapper::moveAnchor(int keyframe, const Pose2& T_map_sensor, const Eigen::Matrix3d& information) {
  keyframes_.visit(keyframe);
  anchor_ = {keyframe,   keyframes_.pose(keyframe).inverse() * T_map_sensor, T_odom_sensor_, stamp_ns_, 0.0, 0.0,
             information};
  scans_of_keyframe_.resize(keyframes_.size(), 0);
}

void Mapper::keepForMap(const Scan& scan) {
  const auto taken = statistics_.scans - statistics_.dropped;  // a scan that is said twice must not shift the others
  if (taken % params_.map.every != 0 || scans_of_keyframe_[anchor_.keyframe] >= params_.map.per_keyframe) {
    return;
  }
  ++scans_of_keyframe_[anchor_.keyframe];
  const Pose2 T_keyframe_sensor = keyframes_.pose(anchor_.keyframe).inverse() * predicted();
  unproved_.push_back(
      std::make_shared<const MapScan>(toMapScan(scan, params_.scan, anchor_.keyframe, T_keyframe_sensor)));
}

void Mapper::proveScans(const Pose2& T_map_sensor) {
  const Pose2 off = predicted().inverse() * T_map_sensor;
  if (std::hypot(off.x, off.y) < params_.map.slip_m && std::abs(off.yaw) < params_.map.slip_rad) {
    scans_.insert(scans_.end(), unproved_.begin(), unproved_.end());
  }
  unproved_.clear();
}

void Mapper::optimizeSoon() {
  if (worker_.pending() > 0) {
    return;
  }
  since_optimised_ = 0;
  worker_.submit([this, poses = keyframes_.poses(), edges = keyframes_.edges(), params = params_.graph] {
    GraphResult result = optimize(poses, edges, params);
    const std::lock_guard<std::mutex> lock(mutex_);
    optimised_ = std::move(result);
  });
}

void Mapper::takeOptimised() {
  std::optional<GraphResult> result;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    result.swap(optimised_);
  }
  if (result && result->ok) {
    ++statistics_.optimisations;
    keyframes_.correct(result->poses);
  }
}

bool Mapper::requestMap() {
  if (worker_.pending() > 0) {
    return false;
  }
  takeOptimised();
  worker_.submit([this, scans = scans_, unproved = unproved_, poses = keyframes_.poses()] {
    auto map = std::make_shared<const GridMap>(drawer_.draw(scans, poses, unproved));
    const std::lock_guard<std::mutex> lock(mutex_);
    map_ = std::move(map);
  });
  return true;
}

std::shared_ptr<const GridMap> Mapper::map() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return map_;
}

std::string Mapper::refine() {
  finish();
  GraphParams to_the_end = params_.graph;
  to_the_end.iterations = kRefineIterations;
  for (int round = 0; round < kRefineRounds; ++round) {
    for (std::size_t i = 0; i < keyframes_.edges().size(); ++i) {
      const PoseEdge& edge = keyframes_.edges()[i];
      const auto again = edge.is_odometry ? std::nullopt : matchedEdge(edge.from, edge.to);
      if (again) {
        keyframes_.replaceEdge(i, *again);
      }
    }
    const GraphResult result = optimize(keyframes_.poses(), keyframes_.edges(), to_the_end);
    if (!result.ok) {
      return result.reason;
    }
    keyframes_.correct(result.poses);
  }
  return "";
}

void Mapper::finish() {
  worker_.wait();
  takeOptimised();
}

double Mapper::entropy() const {
  const Eigen::Matrix3d covariance = anchor_.information.inverse() + odometryCovariance();
  return 0.5 * (3.0 * std::log(2.0 * M_PI * M_E) + std::log(covariance.determinant()));
}

ScanResult Mapper::resultFor(const Scan& scan, ScanResult result) const {
  if (!begun_) {
    result.T_map_base = T_map_base_start_;
    return result;
  }
  const Pose2 T_map_odom = predicted() * T_odom_sensor_.inverse();
  result.T_map_odom = T_map_odom;
  result.T_map_base = T_map_odom * (scan.T_odom_base.isFinite() ? scan.T_odom_base : T_odom_base_);
  result.entropy = entropy();
  return result;
}

}  // namespace yarm::slam
