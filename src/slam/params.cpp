#include "yarm/slam/params.hpp"

#include "limits.hpp"
#include "yarm/slam/types.hpp"

#include <cmath>

namespace yarm::slam {

namespace {

constexpr double kTurtlebotBias = 0.0024;   // 1/m
constexpr double kTurtlebotInterval = 0.5;  // s

void checkMatching(const Params& params, LimitChecker& check) {
  check("scan.sigma_base", params.scan.sigma_base, 1e-4, 1.0);
  check("scan.sigma_slope", params.scan.sigma_slope, 0.0, 1.0);
  check("scan.bias_slope", params.scan.bias_slope, -0.1, 0.1);
  check("scan.use_range", params.scan.use_range, 0.1, 100.0);
  check("scan.stride", params.scan.stride, 1, 100);
  check("scan.line_radius", params.scan.line_radius, 0.01, 1.0);
  check("scan.line_gap", params.scan.line_gap, 0.001, 1.0);
  check("scan.line_points", params.scan.line_points, 3, 100);
  check("scan.line_residual", params.scan.line_residual, 0.1, 100.0);
  check("scan.least_points", params.scan.least_points, 3, 10000);
  check("match.gate_last", params.match.gate_last, 0.001, 1.0);
  check("match.gate_first", params.match.gate_first, params.match.gate_last, 2.0);
  check("match.iterations", params.match.iterations, 1, 100);
  check("match.normals_dot", params.match.normals_dot, 0.0, 0.999);
  check("match.cauchy", params.match.cauchy, 0.1, 100.0);
  check("match.least_paired", params.match.least_paired, 0.0, 1.0);
  check("match.information_divisor", params.match.information_divisor, 0.1, 1000.0);
  check("odometry.sigma_m", params.odometry.sigma_m, 1e-4, 1.0);
  check("odometry.sigma_m_per_m", params.odometry.sigma_m_per_m, 0.0, 1.0);
  check("odometry.sigma_rad", params.odometry.sigma_rad, 1e-4, 1.0);
  check("odometry.sigma_rad_per_m", params.odometry.sigma_rad_per_m, 0.0, 1.0);
  check("odometry.sigma_rad_per_rad", params.odometry.sigma_rad_per_rad, 0.0, 1.0);
  check("odometry.jump_m", params.odometry.jump_m, 0.01, 100.0);
  check("odometry.jump_rad", params.odometry.jump_rad, 0.01, M_PI);
}

void checkGraphAndMap(const Params& params, LimitChecker& check) {
  check("keyframe.distance", params.keyframe.distance, 0.01, 10.0);
  check("keyframe.angle", params.keyframe.angle, 0.01, M_PI);
  check("keyframe.recent", params.keyframe.recent, 1, 100);
  check("keyframe.old", params.keyframe.old, 0, 100);
  check("keyframe.old_distance", params.keyframe.old_distance, 0.0, 100.0);
  check("keyframe.old_overlap", params.keyframe.old_overlap, 0.0, 1.0);
  check("keyframe.known_distance", params.keyframe.known_distance, 0.001, 10.0);
  check("keyframe.known_angle", params.keyframe.known_angle, 0.001, M_PI);
  check("keyframe.search_distance", params.keyframe.search_distance, 0.0, 5.0);
  check("keyframe.search_angle", params.keyframe.search_angle, 0.0, M_PI);
  check("keyframe.search_step", params.keyframe.search_step, 0.01, 1.0);
  check("keyframe.search_angle_step", params.keyframe.search_angle_step, 0.005, 1.0);
  check("keyframe.search_score", params.keyframe.search_score, 0.0, 1.0);
  check("graph.every", params.graph.every, 1, 1000);
  check("graph.iterations", params.graph.iterations, 1, 1000);
  check("graph.cauchy", params.graph.cauchy, 0.1, 1000.0);
  check("graph.converged", params.graph.converged, 0.0, 1.0);
  check("map.resolution", params.map.resolution, 0.005, 1.0);
  check("map.max_range", params.map.max_range, 0.1, 60.0);
  check("map.every", params.map.every, 1, 1000);
  check("map.per_keyframe", params.map.per_keyframe, 1, 10000);
  check("map.range_weight", params.map.range_weight, 1e-4, 10.0);
  check("map.occupied_hits", params.map.occupied_hits, 0.0, 1000.0);
  check("map.occupied_share", params.map.occupied_share, 0.0, 1.0);
  check("map.blur_share", params.map.blur_share, 0.0, 1.0);
  check("map.slip_m", params.map.slip_m, 0.0, 10.0);
  check("map.slip_rad", params.map.slip_rad, 0.0, M_PI);
  check("map.move_m", params.map.move_m, 0.0, 1.0);
  check("map.move_rad", params.map.move_rad, 0.0, 1.0);
  check("map.x_min", params.map.x_min, -200.0, 0.0);
  check("map.y_min", params.map.y_min, -200.0, 0.0);
  check("map.x_max", params.map.x_max, 0.0, 200.0);
  check("map.y_max", params.map.y_max, 0.0, 200.0);
  check("map.margin", params.map.margin, 0.0, 10.0);
}

}  // namespace

ScanParams turtlebotScan() {
  ScanParams scan;
  scan.bias_slope = kTurtlebotBias;
  return scan;
}

Params turtlebotParams() {
  Params params;
  params.scan = turtlebotScan();
  params.keyframe.interval_s = kTurtlebotInterval;
  params.map.x_min = params.map.y_min = -1.0;
  params.map.x_max = params.map.y_max = 1.0;
  return params;
}

std::vector<std::string> faultsOf(const Params& params) {
  LimitChecker check;
  checkMatching(params, check);
  checkGraphAndMap(params, check);
  return check.faults;
}

const char* toString(ScanStatus status) {
  switch (status) {
    case ScanStatus::kDropped:
      return "dropped";
    case ScanStatus::kPredicted:
      return "predicted";
    case ScanStatus::kMatched:
      return "matched";
    case ScanStatus::kKeyframe:
      return "keyframe";
    case ScanStatus::kUnmatched:
      break;
  }
  return "unmatched";
}

}  // namespace yarm::slam
