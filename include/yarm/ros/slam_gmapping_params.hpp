// Parameters of node slam_gmapping: gmapping's names first, then those of the keyframe graph.
#pragma once

#include "yarm/ros/params.hpp"
#include "yarm/slam/params.hpp"

#include <string>

namespace yarm {

/// gmapping's parameters that steer its particle filter: taken, checked for their type, and without effect.
struct ParticleFilterParams {
  int particles = 30;
  double minimum_score = 0.0, sigma = 0.05, lsigma = 0.075, ogain = 3.0, lstep = 0.05, astep = 0.05;
  int kernel_size = 1, lskip = 0, iterations = 5;
  double srr = 0.1, srt = 0.2, str = 0.1, stt = 0.2, resample_threshold = 0.5;
  double llsamplerange = 0.01, llsamplestep = 0.01, lasamplerange = 0.005, lasamplestep = 0.005;

  /// Tells `visit` of each parameter: name, value, unit, what is allowed, meaning; docs/parameters.md is made of it.
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor& visit) {
    const Range any;
    visit("particles", p.particles, "", any, kUnused);
    visit("minimumScore", p.minimum_score, "", any, kUnused);
    visit("sigma", p.sigma, "", any, kUnused);
    visit("kernelSize", p.kernel_size, "", any, kUnused);
    visit("lsigma", p.lsigma, "", any, kUnused);
    visit("ogain", p.ogain, "", any, kUnused);
    visit("lskip", p.lskip, "", any, kUnused);
    visit("lstep", p.lstep, "", any, kUnused);
    visit("astep", p.astep, "", any, kUnused);
    visit("iterations", p.iterations, "", any, kUnused);
    visit("srr", p.srr, "", any, kUnused);
    visit("srt", p.srt, "", any, kUnused);
    visit("str", p.str, "", any, kUnused);
    visit("stt", p.stt, "", any, kUnused);
    visit("resampleThreshold", p.resample_threshold, "", any, kUnused);
    visit("llsamplerange", p.llsamplerange, "", any, kUnused);
    visit("llsamplestep", p.llsamplestep, "", any, kUnused);
    visit("lasamplerange", p.lasamplerange, "", any, kUnused);
    visit("lasamplestep", p.lasamplestep, "", any, kUnused);
  }
  /// What is said of each of them.
  static constexpr char kUnused[] = "gmapping's particle filter; without effect here";
};

/// Parameters of node slam_gmapping.
struct SlamGmappingParams {
  /// Name of the node.
  static constexpr char kNode[] = "slam_gmapping";

  std::string base_frame = "base_footprint";
  std::string map_frame = "map";
  std::string odom_frame = "odom";
  int throttle_scans = 1;
  double transform_publish_period = 0.05;
  double map_update_interval = 5.0;
  double tf_delay = 0.05;
  double max_range = 10.0;
  double tf_wait = 0.3;
  double scan_timeout = 1.0;
  slam::Params slam = nodeDefaults();
  ParticleFilterParams unused;

  /// Tells `visit` of each parameter: name, value, unit, what is allowed, meaning; docs/parameters.md is made of it.
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor& visit) {
    describeNode(p, visit);
    describeMatching(p.slam, visit);
    describeGraph(p.slam, visit);
    describeMap(p.slam, visit);
    ParticleFilterParams::describe(p.unused, visit);
  }

 private:
  /// The library's numbers for the TurtleBot, but with the work beside the callbacks.
  static slam::Params nodeDefaults() {
    slam::Params params = slam::turtlebotParams();
    params.sync = false;
    return params;
  }

  template <class Self, class Visitor>
  static void describeNode(Self& p, Visitor& visit) {
    const Choices text;
    visit("base_frame", p.base_frame, "", text, "the robot's frame");
    visit("map_frame", p.map_frame, "", text, "the map's frame");
    visit("odom_frame", p.odom_frame, "", text, "odometry's frame");
    visit("throttle_scans", p.throttle_scans, "", Range{1, 100}, "every n-th scan is taken");
    visit("transform_publish_period", p.transform_publish_period, "s", Range{0.0, 10.0},
          "between two transforms map -> odom; 0: none is sent");
    visit("map_update_interval", p.map_update_interval, "s", Range{0.1, 600.0}, "between two maps");
    visit("tf_delay", p.tf_delay, "s", Range{0.0, 5.0}, "the transform is stamped this far ahead");
    visit("maxRange", p.max_range, "m", Range{0.1, 100.0}, "longer ranges count as nothing seen");
    visit("tf_wait", p.tf_wait, "s", Range{0.0, 10.0},
          "wall time a scan waits for its transforms before it is dropped");
    visit("scan_timeout", p.scan_timeout, "s", Range{0.1, 60.0}, "without a scan for this long, diagnostics say so");
  }

  template <class Self, class Visitor>
  static void describeMatching(Self& p, Visitor& visit) {
    visit("maxUrange", p.scan.use_range, "m", Range{0.1, 100.0}, "longer ranges are not matched");
    visit("sigma_base", p.scan.sigma_base, "m", Range{1e-4, 1.0},
          "a range's deviation is sigma_base + sigma_slope r^2");
    visit("sigma_slope", p.scan.sigma_slope, "1/m", Range{0.0, 1.0}, "its growth");
    visit("bias_slope", p.scan.bias_slope, "1/m", Range{-0.1, 0.1},
          "ranges are lengthened by bias_slope r^2: the nearest of ten noisy rows reads short");
    visit("beam_stride", p.scan.stride, "", Range{1, 100}, "every n-th beam is matched");
    visit("gate_first", p.match.gate_first, "m", Range{0.01, 2.0}, "farthest partner in a match's first iteration");
    visit("gate_last", p.match.gate_last, "m", Range{0.001, 1.0}, "in its last, at most gate_first");
    visit("normals_dot", p.match.normals_dot, "", Range{0.0, 0.999}, "partners' normals agree by this cosine");
    visit("least_paired", p.match.least_paired, "", Range{0.0, 1.0},
          "share of the points in view that must find partners");
    visit("odometry_sigma_m", p.odometry.sigma_m, "m", Range{1e-4, 1.0}, "odometry's deviation over any stretch");
    visit("odometry_sigma_m_per_m", p.odometry.sigma_m_per_m, "", Range{0.0, 1.0}, "its growth with the way");
    visit("odometry_sigma_rad", p.odometry.sigma_rad, "rad", Range{1e-4, 1.0}, "of the heading, over any stretch");
    visit("odometry_sigma_rad_per_m", p.odometry.sigma_rad_per_m, "rad/m", Range{0.0, 1.0}, "its growth with the way");
    visit("odometry_sigma_rad_per_rad", p.odometry.sigma_rad_per_rad, "", Range{0.0, 1.0}, "its growth with the turn");
    visit("odometry_jump_m", p.odometry.jump_m, "m", Range{0.01, 100.0},
          "a longer step between two scans is no motion");
    visit("odometry_jump_rad", p.odometry.jump_rad, "rad", Range{0.01, 3.14}, "nor is a larger turn");
  }

  template <class Self, class Visitor>
  static void describeGraph(Self& p, Visitor& visit) {
    visit("linearUpdate", p.keyframe.distance, "m", Range{0.01, 10.0}, "a scan is matched after this way");
    visit("angularUpdate", p.keyframe.angle, "rad", Range{0.01, 3.14}, "or after this turn");
    visit("temporalUpdate", p.keyframe.interval_s, "s", Range{-1.0, 3600.0},
          "or after this time; negative: not by time");
    visit("recent_keyframes", p.keyframe.recent, "", Range{1, 100}, "keyframes visited last that are matched first");
    visit("old_keyframes", p.keyframe.old, "", Range{0, 100}, "overlapping ones of earlier visits matched then");
    visit("known_distance", p.keyframe.known_distance, "m", Range{0.001, 10.0},
          "a keyframe this near makes a place known: no new one");
    visit("known_angle", p.keyframe.known_angle, "rad", Range{0.001, 3.14}, "and turned no more than this");
    visit("search_distance", p.keyframe.search_distance, "m", Range{0.0, 5.0}, "half edge of the search after a slip");
    visit("search_angle", p.keyframe.search_angle, "rad", Range{0.0, 3.14}, "half angle of that search");
    visit("optimize_every", p.graph.every, "", Range{1, 1000}, "keyframes between two optimisations");
    visit("sync", p.sync, "", Choices(), "optimise and draw within the scan's callback, so that runs repeat exactly");
  }

  template <class Self, class Visitor>
  static void describeMap(Self& p, Visitor& visit) {
    visit("delta", p.map.resolution, "m", Range{0.005, 1.0}, "edge of a cell");
    visit("occ_thresh", p.map.occupied_share, "", Range{0.0, 1.0}, "share of hits above which a cell is occupied");
    visit("xmin", p.map.x_min, "m", Range{-200.0, 0.0}, "the map reaches at least from here");
    visit("ymin", p.map.y_min, "m", Range{-200.0, 0.0}, "the same in y");
    visit("xmax", p.map.x_max, "m", Range{0.0, 200.0}, "and at least to here");
    visit("ymax", p.map.y_max, "m", Range{0.0, 200.0}, "the same in y");
    visit("map_range", p.map.max_range, "m", Range{0.1, 60.0}, "longer ranges clear this far and mark nothing");
    visit("map_scans", p.map.every, "", Range{1, 1000}, "every n-th scan is drawn");
  }
};

}  // namespace yarm
