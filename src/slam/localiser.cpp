#include "yarm/slam/localiser.hpp"

#include "yarm/slam/scan_points.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cstdio>
#include <stdexcept>

namespace yarm::slam {

namespace {

constexpr int kLeastFitted = 12;         // points: a scan that sees less says nothing
constexpr double kLeastVariance = 1e-8;  // m2, rad2
constexpr double kSlipM = 0.05;          // m: what a slip may have added since the submap's last keyframes
constexpr double kSlipRad = 0.1;         // rad
constexpr char kWhatHelps[] = "; turn or drive on, or give a pose";
constexpr double kPlaceSigma = 0.05;  // of scores: how much less likely a place with a lower one is shown

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char text[256];
  std::snprintf(text, sizeof(text), pattern, values...);
  return text;
}

double degrees(double radians) {
  return radians * 180.0 / M_PI;
}

const LocaliserParams& checked(const LocaliserParams& params) {
  std::string text;
  for (const std::string& fault : faultsOf(params)) {
    text += (text.empty() ? "" : "; ") + fault;
  }
  if (!text.empty()) {
    throw std::invalid_argument(text);
  }
  return params;
}

// The same covariance along axes that are turned.
Eigen::Matrix3d turned(const Eigen::Matrix3d& covariance, double yaw) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() << std::cos(yaw), -std::sin(yaw), std::sin(yaw), std::cos(yaw);
  return turn * covariance * turn.transpose();
}

double spreadOf(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix2d plane = covariance.topLeftCorner<2, 2>();
  return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(plane).eigenvalues().maxCoeff()));
}

Params submapParams(const LocaliserParams& params) {
  Params submap = params.submap;
  submap.sync = true;
  return submap;
}

}  // namespace

const char* toString(LocaliserState state) {
  switch (state) {
    case LocaliserState::kSearching:
      return "searching";
    case LocaliserState::kChecking:
      return "checking";
    case LocaliserState::kTracking:
      break;
  }
  return "tracking";
}

Localiser::Localiser(const LocaliserParams& params, const GridMap& map, const Pose2& T_map_grid)
    : params_(checked(params)), T_map_grid_(T_map_grid), field_(map, params.field) {
  if (!T_map_grid.isFinite()) {
    throw std::invalid_argument("the map's origin is not finite");
  }
  if (field_.surfaceCells() == 0 || field_.freeCells() == 0) {
    throw std::invalid_argument("the map has " + std::to_string(field_.surfaceCells()) + " cells of surfaces and " +
                                std::to_string(field_.freeCells()) + " free ones: nothing to find a place by");
  }
  forget();
}

void Localiser::begin(LocaliserState state) {
  state_ = state;
  submap_ = std::make_unique<Mapper>(submapParams(params_));
  search_ = {};
  wide_searches_ = 0;
  disagreeing_ = 0;
  seen_way_m_ = seen_turn_rad_ = searched_way_m_ = searched_turn_rad_ = way_m_ = turn_rad_ = 0.0;
}

void Localiser::forget() {
  begin(LocaliserState::kSearching);
  doubt_ = "no pose is known: turn round once, or give one";
}

void Localiser::restart() {
  begun_ = false;
  forget();
}

std::string Localiser::believe(const PoseBelief& belief) {
  const Eigen::Matrix3d& covariance = belief.covariance;
  if (!belief.pose.isFinite() || !covariance.allFinite()) {
    return "the pose given is not finite";
  }
  const Eigen::Matrix3d even = 0.5 * (covariance + covariance.transpose());
  if (Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(even).eigenvalues().minCoeff() < -kLeastVariance) {
    return "the covariance of the pose given has a negative direction";
  }
  begin(LocaliserState::kChecking);
  belief_.pose = T_map_grid_.inverse() * belief.pose;
  belief_.covariance = turned(even, -T_map_grid_.yaw) + kLeastVariance * Eigen::Matrix3d::Identity();
  doubt_ = "the pose given is not yet confirmed by scans: turn, or drive";
  return "";
}

std::string Localiser::faultOfScan(const Scan& scan) const {
  std::string fault = faultOf(scan);
  if (fault.empty() && begun_ && scan.stamp_ns <= stamp_ns_) {
    fault = format("the scan's stamp is %.3f s before or at the last one's; start afresh when time went back",
                   1e-9 * static_cast<double>(stamp_ns_ - scan.stamp_ns));
  }
  return fault;
}

LocaliserResult Localiser::addScan(const Scan& scan) {
  const std::string fault = faultOfScan(scan);
  if (!fault.empty()) {
    LocaliserResult refused;
    refused.dropped = true;
    refused.state = state_;
    refused.reason = fault;
    return refused;
  }
  updated_ = false;
  moveOn(scan);
  if (state_ == LocaliserState::kTracking) {
    track(scan);
  } else {
    seek(scan);
  }
  return resultFor(scan);
}

void Localiser::moveOn(const Scan& scan) {
  const Pose2 motion = begun_ ? T_odom_base_.inverse() * scan.T_odom_base : Pose2{};
  const double way = std::hypot(motion.x, motion.y);
  const double turn = std::abs(motion.yaw);
  begun_ = true;
  T_odom_base_ = scan.T_odom_base;
  stamp_ns_ = scan.stamp_ns;
  const OdometryParams& odometry = params_.submap.odometry;
  if (way > odometry.jump_m || turn > odometry.jump_rad) {
    if (state_ == LocaliserState::kTracking) {
      lose(format("odometry jumped by %.2f m and %.0f deg between two scans", way, degrees(turn)));
    }
    return;
  }
  way_m_ += way;
  turn_rad_ += turn;
  seen_way_m_ += way;
  seen_turn_rad_ += turn;
  if (state_ == LocaliserState::kSearching) {
    return;
  }
  // First-order propagation: the heading's deviation moves the position sideways.
  const Pose2& before = belief_.pose;
  const Pose2 after = before * motion;
  Eigen::Matrix3d carry = Eigen::Matrix3d::Identity();
  carry(0, 2) = -(after.y - before.y);
  carry(1, 2) = after.x - before.x;
  const TrackParams& track = params_.track;
  const double position = track.sigma_m_rootm * track.sigma_m_rootm * way;
  const double heading =
      track.sigma_rad_rootm * track.sigma_rad_rootm * way + track.sigma_rad_rootrad * track.sigma_rad_rootrad * turn;
  belief_.covariance = carry * belief_.covariance * carry.transpose();
  belief_.covariance.diagonal() += Eigen::Vector3d{position, position, heading};
  belief_.pose = after;
}

void Localiser::track(const Scan& scan) {
  const bool is_due = way_m_ >= params_.track.update_m || turn_rad_ >= params_.track.update_rad || fit_next_;
  if (!is_due) {
    return;
  }
  const auto points = seenPoints(scan, params_.submap.scan, params_.track.beams);
  if (static_cast<int>(points.size()) < kLeastFitted) {
    judge();
    return;
  }
  const double position = params_.track.sigma_m * params_.track.sigma_m;
  const double heading = params_.track.sigma_rad * params_.track.sigma_rad;
  belief_.covariance.diagonal() += Eigen::Vector3d{position, position, heading};
  const PosePrior prior{belief_.pose, belief_.covariance.inverse()};
  const FitResult fit = fitToField(points, belief_.pose, field_, prior, params_.fit);
  belief_.pose = fit.pose;
  belief_.covariance = (prior.information + fit.information).inverse();
  agreement_ = fit.share();
  disagreeing_ = agreement_ < params_.track.least_share ? disagreeing_ + 1 : 0;
  way_m_ = turn_rad_ = 0.0;
  fit_next_ = false;
  updated_ = true;
  judge();
  if (disagreeing_ >= params_.track.lost_updates) {
    lose(format("only %.0f %% of the points of %d scans in a row lie on surfaces of the map", 100.0 * agreement_,
                disagreeing_));
  }
}

std::string Localiser::spreadFault() const {
  const Eigen::Matrix3d covariance = toldCovariance();
  const double spread = spreadOf(covariance);
  const double heading = std::sqrt(covariance(2, 2));
  if (spread <= params_.track.spread_m && heading <= params_.track.spread_rad) {
    return "";
  }
  return format("the pose is only sure to %.2f m and %.1f deg, %.2f m and %.1f deg are needed", spread,
                degrees(heading), params_.track.spread_m, degrees(params_.track.spread_rad));
}

void Localiser::judge() {
  doubt_ = spreadFault();
  if (doubt_.empty() && disagreeing_ > params_.track.lost_updates / 2) {
    doubt_ = format("only %.0f %% of the scan's points lie on surfaces of the map", 100.0 * agreement_);
  }
}

void Localiser::lose(const std::string& why) {
  const double position = params_.track.lost_m * params_.track.lost_m;
  const double heading = params_.track.lost_rad * params_.track.lost_rad;
  begin(LocaliserState::kChecking);
  belief_.covariance += Eigen::Vector3d{position, position, heading}.asDiagonal();
  doubt_ = "lost: " + why + "; turn round, or give a pose";
  updated_ = true;
}

bool Localiser::widelyDue() const {
  const SearchParams& search = params_.search;
  const double turn = wide_searches_ == 0 ? search.first_turn : search.next_turn;
  const double way = wide_searches_ == 0 ? search.first_way : search.next_way;
  const double since_turn = wide_searches_ == 0 ? seen_turn_rad_ : seen_turn_rad_ - searched_turn_rad_;
  const double since_way = wide_searches_ == 0 ? seen_way_m_ : seen_way_m_ - searched_way_m_;
  return since_turn / turn + since_way / way >= 1.0;
}

bool Localiser::narrowlyDue() const {
  return (seen_turn_rad_ - searched_turn_rad_) / params_.search.window_turn +
             (seen_way_m_ - searched_way_m_) / params_.search.window_way >=
         1.0;
}

void Localiser::seek(const Scan& scan) {
  const ScanResult mapped = submap_->addScan(scan);
  const bool is_wide = widelyDue();
  if (state_ == LocaliserState::kChecking && (is_wide || narrowlyDue() || fit_next_)) {
    const double sigmas = params_.search.window_sigmas;
    const double step = params_.search.step;
    const double angle = std::min(M_PI, sigmas * std::sqrt(belief_.covariance(2, 2)));
    searchIn(SearchWindow{belief_.pose, std::max(step, sigmas * spreadOf(belief_.covariance)),
                          std::max(params_.search.angle_step, angle)},
             mapped.T_map_base, scan);
  }
  if (is_wide && state_ != LocaliserState::kTracking) {
    searchIn(std::nullopt, mapped.T_map_base, scan);
    ++wide_searches_;
  }
}

void Localiser::searchIn(const std::optional<SearchWindow>& window, const Pose2& T_submap_base, const Scan& scan) {
  searched_way_m_ = seen_way_m_;
  searched_turn_rad_ = seen_turn_rad_;
  fit_next_ = false;
  updated_ = true;
  search_ = searchPlace(surroundingsOf(*submap_, T_submap_base, params_.search), field_, window, params_);
  if (search_.found) {
    settle(search_.best, scan);
    return;
  }
  doubt_ = search_.reason + (window ? " (near the pose given)" : "") + kWhatHelps;
}

void Localiser::settle(const FitResult& place, const Scan& scan) {
  const PoseBelief before = belief_;
  const bool is_sure = place.information.determinant() > 0.0;
  belief_.covariance = is_sure ? Eigen::Matrix3d(place.information.inverse()) : 10.0 * Eigen::Matrix3d::Identity();
  // After a slip the submap may be right and the robot's place in it wrong: the present scan has the last word.
  const Eigen::Vector3d slip{kSlipM * kSlipM, kSlipM * kSlipM, kSlipRad * kSlipRad};
  const Eigen::Matrix3d loose = belief_.covariance + Eigen::Matrix3d(slip.asDiagonal());
  const PosePrior prior{place.pose, loose.inverse()};
  const auto points = seenPoints(scan, params_.submap.scan, params_.track.beams);
  const FitResult now = fitToField(points, place.pose, field_, prior, params_.fit);
  belief_.pose = now.pose;
  doubt_ = spreadFault();
  if (doubt_.empty() && now.points >= kLeastFitted && now.share() < params_.search.least_share) {
    doubt_ = format(
        "a place was found, but only %.0f %% of the present scan's points lie on surfaces there, at least "
        "%.0f %% are needed",
        100.0 * now.share(), 100.0 * params_.search.least_share);
  }
  if (!doubt_.empty()) {
    doubt_ += kWhatHelps;
    belief_ = before;
    return;
  }
  state_ = LocaliserState::kTracking;
  submap_.reset();
  agreement_ = now.share();
  disagreeing_ = 0;
  way_m_ = turn_rad_ = 0.0;
}

Eigen::Matrix3d Localiser::toldCovariance() const {
  Eigen::Matrix3d covariance = belief_.covariance;
  const double position = params_.track.floor_m * params_.track.floor_m;
  covariance.diagonal() += Eigen::Vector3d{position, position, params_.track.floor_rad * params_.track.floor_rad};
  return covariance;
}

LocaliserResult Localiser::resultFor(const Scan& scan) const {
  LocaliserResult result;
  result.state = state_;
  result.localised = state_ == LocaliserState::kTracking && doubt_.empty();
  result.reason = doubt_;
  result.has_pose = state_ != LocaliserState::kSearching;
  result.updated = updated_;
  result.T_map_base = T_map_grid_ * belief_.pose;
  result.T_map_odom = result.T_map_base * scan.T_odom_base.inverse();
  result.covariance = turned(toldCovariance(), T_map_grid_.yaw);
  result.agreement = agreement_;
  return result;
}

std::vector<Pose2> Localiser::sample(int count, std::mt19937_64& random) const {
  std::vector<Pose2> poses;
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> even(-M_PI, M_PI);
  if (state_ != LocaliserState::kSearching) {
    const Eigen::Matrix3d root = toldCovariance().llt().matrixL();
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d away = root * Eigen::Vector3d{normal(random), normal(random), normal(random)};
      const Pose2& mean = belief_.pose;
      poses.push_back(T_map_grid_ * Pose2{mean.x + away.x(), mean.y + away.y(), wrapAngle(mean.yaw + away.z())});
    }
    return poses;
  }
  if (!search_.places.empty()) {
    std::vector<double> weights;
    for (const Place& place : search_.places) {
      weights.push_back(std::exp((place.score - search_.places.front().score) / kPlaceSigma));
    }
    std::discrete_distribution<std::size_t> choose(weights.begin(), weights.end());
    for (int i = 0; i < count; ++i) {
      poses.push_back(T_map_grid_ * search_.places[choose(random)].pose);
    }
    return poses;
  }
  std::uniform_int_distribution<int> any(0, field_.width() * field_.height() - 1);
  while (static_cast<int>(poses.size()) < count) {
    int cell = any(random);
    while (!field_.isFreeCell(cell % field_.width(), cell / field_.width())) {  // the next free one: there is one
      cell = (cell + 1) % (field_.width() * field_.height());
    }
    const Eigen::Vector2d at = field_.centre(cell % field_.width(), cell / field_.width());
    poses.push_back(T_map_grid_ * Pose2{at.x(), at.y(), even(random)});
  }
  return poses;
}

}  // namespace yarm::slam
