// Parameters of node amcl: AMCL's names first, then those of the search and the tracking.
#pragma once

#include "yarm/ros/params.hpp"
#include "yarm/slam/localiser_params.hpp"

#include <string>

namespace yarm {

/// AMCL's parameters that steer its particle filter, and its tools': taken, checked for their type, without effect.
struct AmclFilterParams {
  bool use_map_topic = true, do_beamskip = false, selective_resampling = false;
  int min_particles = 100, resample_interval = 2;
  double kld_err = 0.01, kld_z = 0.99, odom_alpha1 = 0.2, odom_alpha2 = 0.2, odom_alpha3 = 0.2, odom_alpha4 = 0.2,
         odom_alpha5 = 0.2;
  std::string odom_model_type = "diff", laser_model_type = "likelihood_field";
  double laser_z_hit = 0.95, laser_z_short = 0.1, laser_z_max = 0.05, laser_z_rand = 0.05, laser_sigma_hit = 0.2,
         laser_lambda_short = 0.1, laser_likelihood_max_dist = 2.0;
  double recovery_alpha_slow = 0.0, recovery_alpha_fast = 0.0, save_pose_rate = 0.5;
  double beam_skip_distance = 0.5, beam_skip_threshold = 0.3, beam_skip_error_threshold = 0.9;
  double std_warn_level_x = 0.2, std_warn_level_y = 0.2, std_warn_level_yaw = 0.1, bag_scan_period = -1.0;
  bool restore_defaults = false;

  /// Tells `visit` of each parameter: name, value, unit, what is allowed, meaning; docs/parameters.md is made of it.
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor& visit) {
    const Range any;
    const Choices text;
    visit("use_map_topic", p.use_map_topic, "", text, "the map is always taken from its topic, or by set_map");
    visit("min_particles", p.min_particles, "", any, kUnused);
    visit("resample_interval", p.resample_interval, "", any, kUnused);
    visit("selective_resampling", p.selective_resampling, "", text, kUnused);
    visit("kld_err", p.kld_err, "", any, kUnused);
    visit("kld_z", p.kld_z, "", any, kUnused);
    visit("odom_model_type", p.odom_model_type, "", text, kUnused);
    visit("odom_alpha1", p.odom_alpha1, "", any, kUnused);
    visit("odom_alpha2", p.odom_alpha2, "", any, kUnused);
    visit("odom_alpha3", p.odom_alpha3, "", any, kUnused);
    visit("odom_alpha4", p.odom_alpha4, "", any, kUnused);
    visit("odom_alpha5", p.odom_alpha5, "", any, kUnused);
    visit("laser_model_type", p.laser_model_type, "", text, kUnused);
    visit("laser_z_hit", p.laser_z_hit, "", any, kUnused);
    visit("laser_z_short", p.laser_z_short, "", any, kUnused);
    visit("laser_z_max", p.laser_z_max, "", any, kUnused);
    visit("laser_z_rand", p.laser_z_rand, "", any, kUnused);
    visit("laser_sigma_hit", p.laser_sigma_hit, "", any, kUnused);
    visit("laser_lambda_short", p.laser_lambda_short, "", any, kUnused);
    visit("laser_likelihood_max_dist", p.laser_likelihood_max_dist, "", any, kUnused);
    visit("recovery_alpha_slow", p.recovery_alpha_slow, "", any, kUnused);
    visit("recovery_alpha_fast", p.recovery_alpha_fast, "", any, kUnused);
    visit("save_pose_rate", p.save_pose_rate, "", any, kUnused);
    visit("do_beamskip", p.do_beamskip, "", text, kUnused);
    visit("beam_skip_distance", p.beam_skip_distance, "", any, kUnused);
    visit("beam_skip_threshold", p.beam_skip_threshold, "", any, kUnused);
    visit("beam_skip_error_threshold", p.beam_skip_error_threshold, "", any, kUnused);
    visit("std_warn_level_x", p.std_warn_level_x, "", any, kTools);
    visit("std_warn_level_y", p.std_warn_level_y, "", any, kTools);
    visit("std_warn_level_yaw", p.std_warn_level_yaw, "", any, kTools);
    visit("bag_scan_period", p.bag_scan_period, "", any, kTools);
    visit("restore_defaults", p.restore_defaults, "", text, kTools);
  }
  /// What is said of each of them.
  static constexpr char kUnused[] = "AMCL's particle filter; without effect here";
  static constexpr char kTools[] = "AMCL's diagnostics, bags and reconfiguring; without effect here";
};

/// Parameters of node amcl.
struct AmclParams {
  /// Name of the node.
  static constexpr char kNode[] = "amcl";

  std::string base_frame_id = "base_footprint";
  std::string global_frame_id = "map";
  std::string odom_frame_id = "odom";
  double transform_tolerance = 0.1;
  bool tf_broadcast = true;
  double gui_publish_rate = 2.0;
  int max_particles = 500;
  bool first_map_only = false;
  bool initial_pose_given = false;
  double initial_pose_x = 0.0, initial_pose_y = 0.0, initial_pose_a = 0.0;
  double initial_cov_xx = 0.25, initial_cov_yy = 0.25, initial_cov_aa = 0.0685;
  double laser_min_range = -1.0;
  double laser_max_range = 5.0;
  double tf_wait = 0.3;
  double scan_timeout = 1.0;
  slam::LocaliserParams localiser = slam::turtlebotLocaliser();
  AmclFilterParams unused;

  /// Tells `visit` of each parameter: name, value, unit, what is allowed, meaning; docs/parameters.md is made of it.
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor& visit) {
    describeNode(p, visit);
    describeStart(p, visit);
    describeScan(p, visit);
    describeTracking(p.localiser, visit);
    describeSearch(p.localiser.search, visit);
    AmclFilterParams::describe(p.unused, visit);
  }

 private:
  template <class Self, class Visitor>
  static void describeNode(Self& p, Visitor& visit) {
    const Choices text;
    visit("base_frame_id", p.base_frame_id, "", text, "the robot's frame");
    visit("global_frame_id", p.global_frame_id, "", text, "the map's frame");
    visit("odom_frame_id", p.odom_frame_id, "", text, "odometry's frame");
    visit("transform_tolerance", p.transform_tolerance, "s", Range{0.0, 5.0},
          "the transform map -> odom is stamped this far ahead");
    visit("tf_broadcast", p.tf_broadcast, "", text, "send that transform");
    visit("gui_publish_rate", p.gui_publish_rate, "Hz", Range{-1.0, 100.0},
          "most messages on particlecloud in a second; negative: one with each pose");
    visit("max_particles", p.max_particles, "", Range{1, 100000}, "poses in a message on particlecloud");
    visit("first_map_only", p.first_map_only, "", text, "maps that come after the first are left alone");
    visit("tf_wait", p.tf_wait, "s", Range{0.0, 10.0},
          "wall time a scan waits for its transforms before it is dropped");
    visit("scan_timeout", p.scan_timeout, "s", Range{0.1, 60.0}, "without a scan for this long, diagnostics say so");
  }

  template <class Self, class Visitor>
  static void describeStart(Self& p, Visitor& visit) {
    visit("initial_pose_given", p.initial_pose_given, "", Choices(),
          "begin at initial_pose_*; false: with no pose, as after global_localization");
    visit("initial_pose_x", p.initial_pose_x, "m", Range{-1e5, 1e5}, "where the robot is looked for first");
    visit("initial_pose_y", p.initial_pose_y, "m", Range{-1e5, 1e5}, "the same in y");
    visit("initial_pose_a", p.initial_pose_a, "rad", Range{-6.3, 6.3}, "and its heading");
    visit("initial_cov_xx", p.initial_cov_xx, "m2", Range{0.0, 100.0}, "variance of that x");
    visit("initial_cov_yy", p.initial_cov_yy, "m2", Range{0.0, 100.0}, "variance of that y");
    visit("initial_cov_aa", p.initial_cov_aa, "rad2", Range{0.0, 10.0}, "variance of that heading");
  }

  template <class Self, class Visitor>
  static void describeScan(Self& p, Visitor& visit) {
    auto& scan = p.localiser.submap.scan;
    visit("laser_min_range", p.laser_min_range, "m", Range{-1.0, 100.0},
          "shorter ranges count as nothing seen; negative: the scan's own limit");
    visit("laser_max_range", p.laser_max_range, "m", Range{-1.0, 100.0},
          "longer ranges count as nothing seen; negative: the scan's own limit");
    visit("laser_max_beams", p.localiser.track.beams, "", Range{12, 20000}, "beams of a scan that are fitted");
    visit("sigma_base", scan.sigma_base, "m", Range{1e-4, 1.0}, "a range's deviation is sigma_base + sigma_slope r^2");
    visit("sigma_slope", scan.sigma_slope, "1/m", Range{0.0, 1.0}, "its growth");
    visit("bias_slope", scan.bias_slope, "1/m", Range{-0.1, 0.1},
          "ranges are lengthened by bias_slope r^2: the nearest of ten noisy rows reads short");
  }

  template <class Self, class Visitor>
  static void describeTracking(Self& p, Visitor& visit) {
    auto& track = p.track;
    visit("update_min_d", track.update_m, "m", Range{0.0, 10.0}, "a scan is fitted after this way");
    visit("update_min_a", track.update_rad, "rad", Range{0.0, 3.14}, "or after this turn");
    visit("odom_sigma_rootm", track.sigma_m_rootm, "m", Range{0.0, 1.0},
          "odometry's deviation after a metre; it grows with the root of the way");
    visit("odom_sigma_rad_rootm", track.sigma_rad_rootm, "rad", Range{0.0, 1.0}, "the same of its heading");
    visit("odom_sigma_rad_rootrad", track.sigma_rad_rootrad, "rad", Range{0.0, 1.0},
          "and after a radian turned; it grows with the root of the turn");
    visit("sigma_map", p.fit.sigma_map, "m", Range{0.001, 1.0}, "a surface lies this far from its cell's centre");
    visit("spread_m", track.spread_m, "m", Range{0.001, 10.0}, "a pose less sure than this is no place known");
    visit("spread_rad", track.spread_rad, "rad", Range{0.001, 3.14}, "nor one with a heading less sure");
    visit("least_share", track.least_share, "", Range{0.0, 1.0}, "of a scan's points must agree with the map");
    visit("lost_updates", track.lost_updates, "", Range{1, 10000}, "fits in a row with fewer end the tracking");
  }

  template <class Self, class Visitor>
  static void describeSearch(Self& search, Visitor& visit) {
    visit("least_score", search.least_score, "", Range{0.0, 1.0}, "a place that fits worse is doubtful");
    visit("least_margin", search.least_margin, "", Range{0.0, 1.0}, "so is one that leads the next by less");
    visit("first_turn", search.first_turn, "rad", Range{0.1, 100.0},
          "turned before the whole map is searched for the first time");
    visit("first_way", search.first_way, "m", Range{0.1, 100.0}, "or driven");
    visit("next_turn", search.next_turn, "rad", Range{0.1, 100.0}, "turned between two searches of the whole map");
    visit("next_way", search.next_way, "m", Range{0.1, 100.0}, "or driven");
    visit("window_sigmas", search.window_sigmas, "", Range{0.5, 10.0},
          "a given pose is looked for within so many of its deviations");
    visit("window_turn", search.window_turn, "rad", Range{0.01, 100.0}, "turned between two searches around it");
    visit("window_way", search.window_way, "m", Range{0.01, 100.0}, "or driven");
  }
};

}  // namespace yarm
