// One tour of a simulated room through the map maker, scored against the truth; one line of CSV on standard output.
// bench/slam.py runs it over rooms and odometries and makes the table. `slam_bench --help` lists the options.
#include "bench_tools.hpp"
#include "slam_score.hpp"
#include "slam_world.hpp"
#include "yarm/slam/mapper.hpp"

#include <cstdio>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

namespace {

using namespace yarm;  // NOLINT: a program's own file

struct Options {
  int arena = 1;
  double seconds = 900.0;
  double odo = 1.0;
  double slip = 1.0;
  double v = 0.2;
  double w = 0.4;
  double map_every_s = 5.0;
  int refine = 0;
  int seen_scans = 10;
  int odometry_only = 0;
  int true_poses = 0;
  std::string picture;
  slam::Params params;
};

double residentMb() {
  std::ifstream statm("/proc/self/statm");
  long whole = 0;
  long resident = 0;
  statm >> whole >> resident;
  return static_cast<double>(resident) * 4096.0 / 1e6;
}

void declare(Options& o, bench::Options& by_name) {
  by_name.number("arena", o.arena);
  by_name.number("seconds", o.seconds);
  by_name.number("odo", o.odo);
  by_name.number("slip", o.slip);
  by_name.number("v", o.v);
  by_name.number("w", o.w);
  by_name.number("map_every_s", o.map_every_s);
  by_name.number("refine", o.refine);
  by_name.number("seen_scans", o.seen_scans);
  by_name.number("odometry_only", o.odometry_only);
  by_name.number("true_poses", o.true_poses);
  by_name.number("bias_slope", o.params.scan.bias_slope);
  by_name.number("sigma_base", o.params.scan.sigma_base);
  by_name.number("sigma_slope", o.params.scan.sigma_slope);
  by_name.number("stride", o.params.scan.stride);
  by_name.number("line_radius", o.params.scan.line_radius);
  by_name.number("line_residual", o.params.scan.line_residual);
  by_name.number("use_range", o.params.scan.use_range);
  by_name.number("gate_first", o.params.match.gate_first);
  by_name.number("gate_last", o.params.match.gate_last);
  by_name.number("iterations", o.params.match.iterations);
  by_name.number("normals_dot", o.params.match.normals_dot);
  by_name.number("cauchy", o.params.match.cauchy);
  by_name.number("information_divisor", o.params.match.information_divisor);
  by_name.number("sigma_m", o.params.odometry.sigma_m);
  by_name.number("sigma_rad", o.params.odometry.sigma_rad);
  by_name.number("distance", o.params.keyframe.distance);
  by_name.number("angle", o.params.keyframe.angle);
  by_name.number("interval_s", o.params.keyframe.interval_s);
  by_name.number("recent", o.params.keyframe.recent);
  by_name.number("old", o.params.keyframe.old);
  by_name.number("known_distance", o.params.keyframe.known_distance);
  by_name.number("known_angle", o.params.keyframe.known_angle);
  by_name.number("search_score", o.params.keyframe.search_score);
  by_name.number("graph_every", o.params.graph.every);
  by_name.number("graph_iterations", o.params.graph.iterations);
  by_name.number("graph_cauchy", o.params.graph.cauchy);
  by_name.number("map_every", o.params.map.every);
  by_name.number("per_keyframe", o.params.map.per_keyframe);
  by_name.number("max_range", o.params.map.max_range);
  by_name.number("range_weight", o.params.map.range_weight);
  by_name.number("occupied_hits", o.params.map.occupied_hits);
  by_name.number("occupied_share", o.params.map.occupied_share);
  by_name.number("blur_share", o.params.map.blur_share);
  by_name.number("slip_m", o.params.map.slip_m);
  by_name.number("slip_rad", o.params.map.slip_rad);
  by_name.number("move_m", o.params.map.move_m);
  by_name.text("picture", o.picture);
}

Options parse(int argc, char** argv) {
  Options options;
  bench::Options by_name;
  declare(options, by_name);
  by_name.parse(argc, argv);
  return options;
}

// The map as a plain text: first what it is, then cells, surfaces, for the picture.
void writePicture(const std::string& path, const slam::GridMap& map, const test::MapScore& score,
                  const test::Arena& arena) {
  std::ofstream out(path);
  out << "map " << map.width << ' ' << map.height << ' ' << map.resolution << ' ' << map.origin_x << ' ' << map.origin_y
      << ' ' << score.T_arena_map.x << ' ' << score.T_arena_map.y << ' ' << score.T_arena_map.yaw << '\n';
  for (const auto cell : map.cells) {
    out << static_cast<int>(cell) << ' ';
  }
  out << '\n';
  for (const test::Segment& surface : arena.surfaces()) {
    out << surface.a.x() << ' ' << surface.a.y() << ' ' << surface.b.x() << ' ' << surface.b.y() << '\n';
  }
}

struct Timing {
  std::vector<double> scan_ms;
  double map_s = 0.0;
  double refine_s = 0.0;
};

void tour(const Options& options, test::Run& run, slam::Mapper& mapper, test::SeenSurfaces& surfaces,
          test::PoseErrors& errors, Timing& timing, slam::Pose2& T_arena_map) {
  double next_map_s = options.map_every_s;
  const int scans = static_cast<int>(options.seconds * 10.0);
  slam::Pose2 T_arena_odom;
  for (int i = 0; i < scans; ++i) {
    test::Moment moment = run.next();
    if (i == 0) {
      T_arena_map = moment.T_arena_base;
      T_arena_odom = moment.T_arena_base * moment.scan.T_odom_base.inverse();
    }
    surfaces.add(moment, options.params.map.max_range);
    slam::Pose2 odometry = T_arena_odom * moment.scan.T_odom_base;
    if (options.true_poses != 0) {
      moment.scan.T_odom_base = T_arena_map.inverse() * moment.T_arena_base;
    }
    const double before = bench::cpuSeconds();
    const slam::ScanResult result = mapper.addScan(moment.scan);
    timing.scan_ms.push_back(1e3 * (bench::cpuSeconds() - before));
    errors.add(options.odometry_only != 0 ? odometry : T_arena_map * result.T_map_base, moment.T_arena_base);
    if (0.1 * i >= next_map_s) {
      next_map_s += options.map_every_s;
      const double begun = bench::cpuSeconds();
      mapper.requestMap();
      timing.map_s += bench::cpuSeconds() - begun;
    }
  }
}

int runBench(const Options& options) {
  const test::Arena arena(options.arena);
  test::RunOptions run_options;
  run_options.speed = options.v;
  run_options.turn_rate = options.w;
  run_options.odometry = options.odo;
  run_options.slip = options.slip;
  test::Run run(arena, options.arena, run_options);
  test::SeenSurfaces surfaces(arena);
  test::PoseErrors errors;
  Timing timing;
  slam::Pose2 T_arena_map;
  const double resident_before = residentMb();
  slam::Mapper mapper(options.params);
  tour(options, run, mapper, surfaces, errors, timing, T_arena_map);
  if (options.refine != 0) {
    const double begun = bench::cpuSeconds();
    mapper.refine();
    timing.refine_s = bench::cpuSeconds() - begun;
  }
  mapper.requestMap();
  const double resident = residentMb();
  const auto seen = surfaces.seen(options.seen_scans);
  const test::MapScore score = test::scoreMap(*mapper.map(), arena, seen, T_arena_map, true);
  const test::MapScore unaligned = test::scoreMap(*mapper.map(), arena, seen, T_arena_map, false);
  const test::PoseScore pose = errors.score();
  if (!options.picture.empty()) {
    writePicture(options.picture, *mapper.map(), score, arena);
  }
  double scan_s = 0.0;
  for (const double ms : timing.scan_ms) {
    scan_s += 1e-3 * ms;
  }
  const slam::Statistics& did = mapper.statistics();
  std::printf(
      "arena,odo,slip,driven_m,turned_deg,acc_mean_mm,acc_p95_mm,acc_max_mm,raw_mean_mm,raw_p95_mm,within_5cm_pct,"
      "within_10cm_pct,spur_pct,occupied,traj_rmse_m,traj_max_m,heading_rms_deg,heading_max_deg,scan_ms,scan_p99_ms,"
      "scan_max_ms,map_s,realtime_pct,refine_s,resident_before_mb,resident_mb,keyframes,edges,matched,unmatched,"
      "searches,"
      "searches_taken\n");
  std::printf(
      "%d,%g,%g,%.1f,%.0f,%.2f,%.1f,%.1f,%.2f,%.1f,%.3f,%.3f,%.3f,%d,%.4f,%.4f,%.3f,%.3f,%.4f,%.3f,%.1f,%.2f,%.3f,%.2f,"
      "%.1f,%.1f,%d,%d,%d,%d,%d,%d\n",
      options.arena, options.odo, options.slip, run.driven(), run.turned() * 180.0 / M_PI, 1e3 * score.mean,
      1e3 * score.p95, 1e3 * score.most, 1e3 * unaligned.mean, 1e3 * unaligned.p95, 1e2 * score.within_5cm,
      1e2 * score.within_10cm, 1e2 * score.spurious, score.occupied, pose.rmse, pose.most,
      pose.heading_rms * 180.0 / M_PI, pose.heading_most * 180.0 / M_PI,
      1e3 * scan_s / static_cast<double>(timing.scan_ms.size()), bench::percentile(timing.scan_ms, 0.99),
      bench::percentile(timing.scan_ms, 1.0), timing.map_s, 1e2 * (scan_s + timing.map_s) / options.seconds,
      timing.refine_s, resident_before, resident, did.keyframes, did.edges, did.matched, did.unmatched, did.searches,
      did.searches_taken);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return runBench(parse(argc, argv));
  } catch (const std::exception& error) {
    std::cerr << "slam_bench: " << error.what() << '\n';
    return 1;
  }
}
