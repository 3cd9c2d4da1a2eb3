// Every number of the map maker: default, unit and meaning once.
#pragma once

#include <string>
#include <vector>

namespace yarm::slam {

/// Noise of the sensor and how a scan becomes points.
struct ScanParams {
  double sigma_base{0.006};    ///< m: standard deviation of a point along its ray is base + slope r^2
  double sigma_slope{0.0012};  ///< 1/m
  double bias_slope{0.0012};   ///< 1/m: ranges are lengthened by this times r^2: the nearest of noisy rows reads short
  double use_range{5.0};       ///< m: longer ranges are not matched
  int stride{4};               ///< every n-th beam becomes a point
  double line_radius{0.10};    ///< m: beams this near a point, and without a gap, are fitted with its line
  double line_gap{0.06};       ///< m: a step larger than this (plus four sigmas) between beams ends the line
  int line_points{7};          ///< fewer beams than this give no normal, and the point is left out
  double line_residual{2.0};   ///< sigmas: a line that fits worse (corners) is left out
  int least_points{20};        ///< fewer points than this are too little to match
};

/// Point-to-line matching of one scan against others.
struct MatchParams {
  double gate_first{0.25};           ///< m: farthest partner in the first iteration
  double gate_last{0.08};            ///< m: in the last iterations
  int iterations{10};                ///< most Gauss-Newton steps
  double normals_dot{0.8};           ///< partners' normals must agree by this cosine: a wall's two faces never pair
  double cauchy{2.0};                ///< sigmas: scale of the Cauchy weight
  double least_paired{0.5};          ///< share of the points in view that must have found a partner
  double information_divisor{10.0};  ///< neighbouring points err together: information counts this much less
};

/// Trust in odometry: standard deviations of a stretch of motion are base + per-metre and per-radian parts.
struct OdometryParams {
  double sigma_m{0.02};            ///< m
  double sigma_m_per_m{0.05};      ///< m a metre driven
  double sigma_rad{0.015};         ///< rad
  double sigma_rad_per_m{0.03};    ///< rad a metre driven
  double sigma_rad_per_rad{0.05};  ///< rad a radian turned
  double jump_m{1.0};              ///< m: a step larger than this between two scans is refused
  double jump_rad{1.5};            ///< rad: the same for the heading
};

/// Keyframes, their neighbours and the search after slips.
struct KeyframeParams {
  double distance{0.20};            ///< m: a match is due after this way
  double angle{0.175};              ///< rad: or after this turn
  double interval_s{-1.0};          ///< s: or after this time; negative: never by time alone
  int recent{4};                    ///< newest keyframes matched first
  int old{2};                       ///< older overlapping keyframes matched then
  double old_distance{1.5};         ///< m: how far an older one may be
  double old_overlap{0.4};          ///< share of the scan's points that must lie in its view
  double known_distance{0.15};      ///< m: an old keyframe this near makes a place known: no new keyframe
  double known_angle{0.175};        ///< rad: and turned no more than this
  double search_distance{0.35};     ///< m: half edge of the coarse search
  double search_angle{0.26};        ///< rad: half angle of the coarse search
  double search_step{0.05};         ///< m: step of the coarse search; also the edge of its raster
  double search_angle_step{0.035};  ///< rad
  double search_score{0.55};        ///< least mean likelihood of the coarse search's best place
};

/// The sparse optimisation.
struct GraphParams {
  int every{10};           ///< keyframes between two optimisations
  int iterations{4};       ///< most Gauss-Newton steps of each
  double cauchy{3.0};      ///< scale of the Cauchy weight on an edge's error, sigmas
  double converged{1e-4};  ///< m, rad: a step smaller than this ends it
};

/// The occupancy grid.
struct MapParams {
  double resolution{0.05};     ///< m: edge of a cell
  double max_range{4.0};       ///< m: longer ranges clear this far and mark nothing
  int every{3};                ///< every n-th scan is drawn
  int per_keyframe{30};        ///< most scans kept for one keyframe; later ones are not drawn
  double range_weight{0.012};  ///< m: a mark counts 1/(1 + (sigma/range_weight)^2)
  double occupied_hits{1.0};   ///< weight of hits above which a cell may be occupied
  double blur_share{0.1};  ///< a cell with less than this share of a neighbour's hits is blur of that neighbour's wall
  double occupied_share{0.25};  ///< share of hits among all marks above which it is
  double slip_m{0.04};          ///< m: scans since the last match are not drawn when the next one shows such a slip
  double slip_rad{0.025};       ///< rad: or such a one of the heading
  double move_m{0.004};         ///< m: a keyframe that has moved less since it was drawn stays as drawn
  double move_rad{0.002};       ///< rad: the same for its heading
  double x_min{0.0};            ///< m: the map reaches at least from here, even where nothing is known
  double y_min{0.0};            ///< m
  double x_max{0.0};            ///< m: and at least to here
  double y_max{0.0};            ///< m
  double margin{0.25};          ///< m: unknown border kept around what is known
};

/// All of them.
struct Params {
  ScanParams scan;
  MatchParams match;
  OdometryParams odometry;
  KeyframeParams keyframe;
  GraphParams graph;
  MapParams map;
  bool sync{true};  ///< optimise and draw in the caller's thread, repeatable byte for byte; false: in one of their own
};

/// The TurtleBot's scan: as the default, but for how far it reads short (docs/slam.md).
[[nodiscard]] ScanParams turtlebotScan();

/// The numbers of the TurtleBot: how far its scan reads short (bench/slam.md), a match however little odometry says
/// that it moved, since wheels slip, and a map that begins small around its origin and grows.
[[nodiscard]] Params turtlebotParams();

/// What is wrong with parameters, one sentence each; empty when nothing is.
[[nodiscard]] std::vector<std::string> faultsOf(const Params& params);

}  // namespace yarm::slam
