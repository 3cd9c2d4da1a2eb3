// Localisation in rooms with ten boxes, scored against the truth; CSV on standard output, one line a start or tour.
// bench/localisation.py runs it over rooms and makes the tables. `localisation_bench --help` lists the options.
#include "bench_tools.hpp"
#include "slam_score.hpp"
#include "slam_world.hpp"
#include "yarm/slam/localiser.hpp"

#include <cstdio>
#include <exception>
#include <iostream>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace yarm;  // NOLINT: a program's own file

constexpr double kRightM = 0.2;  // a place found is right when it is off by no more
constexpr double kRightRad = 0.15;
constexpr double kLostM = 0.5;
constexpr double kDegree = M_PI / 180.0;

struct Settings {
  std::string mode = "start";  // start: from nothing; given: from a wrong pose; tour: following
  int arena = 1;
  int walls = 0;
  double cell = 0.05;  // m, of the map
  int first = 1;       // seed of the first start or tour
  int count = 50;      // starts or tours
  int turns = 1;       // in place, at most, before a start is given up
  double seconds = 300.0;
  double odo = 1.0;
  double slip = 1.0;
  double v = 0.3;
  double w = 0.4;
  double off_m = 0.5;
  double off_deg = 30.0;
  slam::LocaliserParams params;
};

Settings parse(int argc, char** argv) {
  Settings s;
  bench::Options by_name;
  by_name.text("mode", s.mode);
  by_name.number("arena", s.arena);
  by_name.number("walls", s.walls);
  by_name.number("cell", s.cell);
  by_name.number("first", s.first);
  by_name.number("count", s.count);
  by_name.number("turns", s.turns);
  by_name.number("seconds", s.seconds);
  by_name.number("odo", s.odo);
  by_name.number("slip", s.slip);
  by_name.number("v", s.v);
  by_name.number("w", s.w);
  by_name.number("off_m", s.off_m);
  by_name.number("off_deg", s.off_deg);
  by_name.number("bias_slope", s.params.submap.scan.bias_slope);
  by_name.number("step", s.params.search.step);
  by_name.number("angle_step", s.params.search.angle_step);
  by_name.number("points_first", s.params.search.points_first);
  by_name.number("candidates", s.params.search.candidates);
  by_name.number("least_score", s.params.search.least_score);
  by_name.number("least_margin", s.params.search.least_margin);
  by_name.number("window_turn", s.params.search.window_turn);
  by_name.number("beams", s.params.track.beams);
  by_name.number("update_m", s.params.track.update_m);
  by_name.number("update_rad", s.params.track.update_rad);
  by_name.number("sigma_m", s.params.track.sigma_m);
  by_name.number("sigma_rad", s.params.track.sigma_rad);
  by_name.number("sigma_m_rootm", s.params.track.sigma_m_rootm);
  by_name.number("sigma_rad_rootrad", s.params.track.sigma_rad_rootrad);
  by_name.number("sigma_map", s.params.fit.sigma_map);
  by_name.number("information_divisor", s.params.fit.information_divisor);
  by_name.number("gate_first", s.params.fit.gate_first);
  by_name.number("gate_last", s.params.fit.gate_last);
  by_name.number("cauchy", s.params.fit.cauchy);
  by_name.parse(argc, argv);
  return s;
}

test::Run runOf(const Settings& s, const test::Arena& arena, int seed) {
  test::RunOptions options;
  options.speed = s.v;
  options.turn_rate = s.w;
  options.odometry = s.odo;
  options.slip = s.slip;
  options.first_turns = s.turns;
  return test::Run(arena, 1000U * s.arena + seed, options);
}

// A pose that is off by so much, into directions drawn from the seed, with the spread that RViz gives such poses.
slam::PoseBelief wrongPose(const slam::Pose2& truth, const Settings& s, int seed) {
  std::mt19937_64 random(seed);
  const double bearing = std::uniform_real_distribution<double>(-M_PI, M_PI)(random);
  const double side = random() % 2 == 0 ? 1.0 : -1.0;
  slam::PoseBelief belief;
  belief.pose = {truth.x + s.off_m * std::cos(bearing), truth.y + s.off_m * std::sin(bearing),
                 slam::wrapAngle(truth.yaw + side * s.off_deg * kDegree)};
  belief.covariance = Eigen::Vector3d{0.25, 0.25, M_PI * M_PI / 144.0}.asDiagonal();
  return belief;
}

void start(const Settings& s, const test::Arena& arena, const slam::GridMap& map, int seed) {
  test::Run run = runOf(s, arena, seed);
  slam::Localiser localiser(s.params, map);
  const int most = static_cast<int>(std::ceil(s.turns * 2.0 * M_PI / s.w * 10.0)) + 2;
  slam::LocaliserResult result;
  test::Moment moment;
  double cpu = 0.0;
  int scans = 0;
  while (scans < most && !result.localised) {
    moment = run.next();
    if (scans == 0 && s.mode == "given") {
      localiser.believe(wrongPose(moment.T_arena_base, s, seed));
    }
    const double before = bench::cpuSeconds();
    result = localiser.addScan(moment.scan);
    cpu += bench::cpuSeconds() - before;
    ++scans;
  }
  const double off = result.T_map_base.distanceTo(moment.T_arena_base);
  const double turned = std::abs(slam::wrapAngle(result.T_map_base.yaw - moment.T_arena_base.yaw));
  const bool right = off <= kRightM && turned <= kRightRad;
  const auto& search = localiser.lastSearch();
  const double score = search.places.empty() ? 0.0 : search.places.front().score;
  std::printf("%d,%d,%d,%g,%s,%.4f,%.3f,%.3f,%.3f,%d,%.4f\n", s.arena, s.walls, seed, s.odo,
              !result.localised ? "doubtful"
              : right           ? "right"
                                : "wrong",
              off, turned / kDegree, score, search.margin, scans, cpu);
}

void tour(const Settings& s, const test::Arena& arena, const slam::GridMap& map, int seed) {
  test::Run run = runOf(s, arena, seed);
  slam::Localiser localiser(s.params, map);
  test::PoseErrors errors;
  std::vector<double> update_us;
  int doubtful = 0;
  int lost = 0;
  int found = 0;
  for (int i = 0; i < static_cast<int>(s.seconds * 10.0); ++i) {
    const test::Moment moment = run.next();
    if (i == 0) {
      localiser.believe({moment.T_arena_base, 1e-4 * Eigen::Matrix3d::Identity()});
    }
    const double before = bench::cpuSeconds();
    const slam::LocaliserResult result = localiser.addScan(moment.scan);
    const double us = 1e6 * (bench::cpuSeconds() - before);
    found += result.localised ? 1 : 0;
    if (found == 0) {
      continue;  // the first look around, told from the following
    }
    update_us.push_back(us);
    errors.add(result.T_map_base, moment.T_arena_base);
    doubtful += result.localised ? 0 : 1;
    lost += result.T_map_base.distanceTo(moment.T_arena_base) > kLostM ? 1 : 0;
  }
  const test::PoseScore score = errors.score();
  double sum = 0.0;
  for (const double us : update_us) {
    sum += us;
  }
  std::printf("%d,%d,%d,%g,%.4f,%.4f,%.4f,%.3f,%.3f,%.3f,%.1f,%.1f,%d,%d,%d,%.1f\n", s.arena, s.walls, seed, s.odo,
              score.rmse, score.p95, score.most, score.heading_rms / kDegree, score.heading_p95 / kDegree,
              score.heading_most / kDegree, sum / static_cast<double>(update_us.size()),
              bench::percentile(update_us, 0.99), found, doubtful, lost, run.driven());
}

int runBench(const Settings& s) {
  const test::Arena arena = test::Arena::withTenBoxes(s.arena, s.walls);
  const slam::GridMap map = test::drawnMap(arena, s.arena, s.cell);
  const bool is_tour = s.mode == "tour";
  std::puts(is_tour ? "arena,walls,seed,odo,rmse_m,p95_m,max_m,heading_rms_deg,heading_p95_deg,heading_max_deg,"
                      "update_us,update_p99_us,found,doubtful,lost,driven_m"
                    : "arena,walls,seed,odo,outcome,off_m,turned_deg,score,margin,scans,cpu_s");
  for (int seed = s.first; seed < s.first + s.count; ++seed) {
    is_tour ? tour(s, arena, map, seed) : start(s, arena, map, seed);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return runBench(parse(argc, argv));
  } catch (const std::exception& error) {
    std::cerr << "localisation_bench: " << error.what() << '\n';
    return 1;
  }
}
