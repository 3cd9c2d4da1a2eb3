// MRPT's KLD particle filter in the rooms of bench/localisation.cpp, scored alike: the peer of our localisation. Built
// where MRPT is installed (libmrpt-slam-dev); nothing else needs it. `localisation_mrpt_bench --help` lists the
// options.
#include "bench_tools.hpp"
#include "slam_score.hpp"
#include "slam_world.hpp"
#include "yarm/slam/scan_points.hpp"

#include <mrpt/bayes/CParticleFilter.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/random.h>
#include <mrpt/slam/CMonteCarloLocalization2D.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace yarm;  // NOLINT: a program's own file

constexpr double kRightM = 0.2;  // as bench/localisation.cpp
constexpr double kRightRad = 0.15;
constexpr double kLostM = 0.5;
constexpr double kSureM = 0.10;  // it claims a place when it spreads less
constexpr double kDegree = M_PI / 180.0;
constexpr double kSureRad = 5.0 * kDegree;

struct Settings {
  std::string mode = "start";  // start: from nothing; tour: following
  int arena = 1;
  int walls = 0;
  int first = 1;   // seed of the first start or tour
  int count = 50;  // starts or tours
  int turns = 1;   // in place, then it is asked
  double seconds = 300.0;
  double odo = 1.0;
  double v = 0.3;
  double w = 0.4;
  double update_m = 0.05;  // it is updated after such a way
  double update_rad = 0.05;
  double power = 0.03;    // of the likelihood; 1 is far too sure of itself with 80 beams
  double sigma = 0.10;    // m: of the likelihood field
  int particles = 50000;  // at the start, and at most
  int least = 250;        // particles
  double bin_m = 0.10;
  double bin_deg = 5.0;
};

Settings parse(int argc, char** argv) {
  Settings s;
  bench::Options by_name;
  by_name.text("mode", s.mode);
  by_name.number("arena", s.arena);
  by_name.number("walls", s.walls);
  by_name.number("first", s.first);
  by_name.number("count", s.count);
  by_name.number("turns", s.turns);
  by_name.number("seconds", s.seconds);
  by_name.number("odo", s.odo);
  by_name.number("v", s.v);
  by_name.number("w", s.w);
  by_name.number("update_m", s.update_m);
  by_name.number("update_rad", s.update_rad);
  by_name.number("power", s.power);
  by_name.number("sigma", s.sigma);
  by_name.number("particles", s.particles);
  by_name.number("least", s.least);
  by_name.number("bin_m", s.bin_m);
  by_name.number("bin_deg", s.bin_deg);
  by_name.parse(argc, argv);
  return s;
}

// The peer behind the face that the scoring needs. Its frame has the map's corner as origin: MRPT rounds limits of
// maps.
class Peer {
 public:
  Peer(const Settings& s, const slam::GridMap& map)
      : settings_(s), corner_x_(map.origin_x), corner_y_(map.origin_y), grid_(gridOf(map)), pdf_(s.particles) {
    grid_->likelihoodOptions.likelihoodMethod = mrpt::maps::COccupancyGridMap2D::lmLikelihoodField_Thrun;
    grid_->likelihoodOptions.LF_stdHit = static_cast<float>(s.sigma);
    grid_->likelihoodOptions.LF_maxRange = 10.0F;
    grid_->likelihoodOptions.LF_decimation = 8;
    pdf_.options.metricMap = grid_;
    pdf_.options.KLD_params.KLD_minSampleSize = s.least;
    pdf_.options.KLD_params.KLD_maxSampleSize = s.particles;
    pdf_.options.KLD_params.KLD_binSize_XY = s.bin_m;
    pdf_.options.KLD_params.KLD_binSize_PHI = s.bin_deg * kDegree;
    filter_.m_options.adaptiveSampleSize = true;
    filter_.m_options.powFactor = s.power;
  }

  void spread() { pdf_.resetUniformFreeSpace(grid_.get(), 0.7, settings_.particles); }
  void believe(const slam::Pose2& pose) {
    pdf_.resetDeterministic({pose.x - corner_x_, pose.y - corner_y_, pose.yaw}, settings_.particles);
  }

  // Takes a scan in when the robot has moved enough; whether it did.
  bool add(const slam::Scan& scan) {
    const slam::Pose2 step = last_ ? last_->inverse() * scan.T_odom_base : slam::Pose2{};
    if (last_ && std::hypot(step.x, step.y) < settings_.update_m && std::abs(step.yaw) < settings_.update_rad) {
      return false;
    }
    last_ = scan.T_odom_base;
    mrpt::obs::CActionRobotMovement2D motion;
    motion.computeFromOdometry({step.x, step.y, step.yaw}, {});
    mrpt::obs::CActionCollection actions;
    actions.insert(motion);
    mrpt::obs::CSensoryFrame seen;
    seen.insert(observationOf(scan));
    filter_.executeOn(pdf_, &actions, &seen);
    return true;
  }

  // Where it believes to be, by the mean and odometry since the last update.
  [[nodiscard]] slam::Pose2 pose(const slam::Pose2& T_odom_base) const {
    const auto mean = std::get<1>(pdf_.getCovarianceAndMean());
    const slam::Pose2 then{mean.x() + corner_x_, mean.y() + corner_y_, mean.phi()};
    return last_ ? then * (last_->inverse() * T_odom_base) : then;
  }
  [[nodiscard]] bool isSure() const {
    const auto covariance = std::get<0>(pdf_.getCovarianceAndMean());
    return std::sqrt(covariance(0, 0)) < kSureM && std::sqrt(covariance(1, 1)) < kSureM &&
           std::sqrt(covariance(2, 2)) < kSureRad;
  }

 private:
  static mrpt::maps::COccupancyGridMap2D::Ptr gridOf(const slam::GridMap& map) {
    const auto resolution = static_cast<float>(map.resolution);
    auto grid = mrpt::maps::COccupancyGridMap2D::Create(0.0F, resolution * static_cast<float>(map.width), 0.0F,
                                                        resolution * static_cast<float>(map.height), resolution);
    for (int row = 0; row < map.height; ++row) {
      for (int column = 0; column < map.width; ++column) {
        const int cell = map.cells[static_cast<std::size_t>(row) * map.width + column];
        grid->setCell(column, row, cell < 0 ? 0.5F : cell >= 65 ? 0.01F : 0.99F);  // it stores how free a cell is
      }
    }
    return grid;
  }

  // The same beams as ours takes, their bias taken out as ours does it.
  static mrpt::obs::CObservation2DRangeScan::Ptr observationOf(const slam::Scan& scan) {
    const auto made = mrpt::obs::CObservation2DRangeScan::Create();
    auto& seen = *made;
    const slam::ScanParams params;
    const std::size_t beams = scan.ranges.size();
    seen.aperture = static_cast<float>(scan.angle_increment * static_cast<double>(beams - 1));
    seen.rightToLeft = true;
    seen.maxRange = static_cast<float>(scan.range_max);
    seen.sensorPose = {scan.T_base_sensor.x,
                       scan.T_base_sensor.y,
                       0.0,
                       scan.T_base_sensor.yaw + scan.angle_min + 0.5 * seen.aperture,
                       0.0,
                       0.0};
    seen.resizeScan(beams);
    for (std::size_t beam = 0; beam < beams; ++beam) {
      const auto range = slam::usableRange(scan, beam, params);
      const bool usable = range && *range <= params.use_range;
      seen.setScanRange(beam, usable ? static_cast<float>(*range) : 0.0F);
      seen.setScanRangeValidity(beam, usable);
    }
    return made;
  }

  Settings settings_;
  double corner_x_;
  double corner_y_;
  mrpt::maps::COccupancyGridMap2D::Ptr grid_;
  mrpt::slam::CMonteCarloLocalization2D pdf_;
  mrpt::bayes::CParticleFilter filter_;
  std::optional<slam::Pose2> last_;
};

test::Run runOf(const Settings& s, const test::Arena& arena, int seed) {
  test::RunOptions options;
  options.speed = s.v;
  options.turn_rate = s.w;
  options.odometry = s.odo;
  options.first_turns = s.turns;
  mrpt::random::getRandomGenerator().randomize(seed);
  return test::Run(arena, 1000U * s.arena + seed, options);
}

void start(const Settings& s, const test::Arena& arena, const slam::GridMap& map, int seed) {
  test::Run run = runOf(s, arena, seed);
  Peer peer(s, map);
  peer.spread();
  const int scans = static_cast<int>(std::ceil(s.turns * 2.0 * M_PI / s.w * 10.0)) + 2;
  test::Moment moment;
  const double before = bench::cpuSeconds();
  double world = 0.0;
  for (int i = 0; i < scans; ++i) {
    const double drawn = bench::cpuSeconds();
    moment = run.next();
    world += bench::cpuSeconds() - drawn;
    peer.add(moment.scan);
  }
  const double cpu = bench::cpuSeconds() - before - world;
  const slam::Pose2 pose = peer.pose(moment.scan.T_odom_base);
  const double off = pose.distanceTo(moment.T_arena_base);
  const double turned = std::abs(slam::wrapAngle(pose.yaw - moment.T_arena_base.yaw));
  const bool right = off <= kRightM && turned <= kRightRad;
  std::printf("%d,%d,%d,%g,%s,%.4f,%.3f,0,0,%d,%.4f\n", s.arena, s.walls, seed, s.odo,
              !peer.isSure() ? "doubtful"
              : right        ? "right"
                             : "wrong",
              off, turned / kDegree, scans, cpu);
}

void tour(const Settings& s, const test::Arena& arena, const slam::GridMap& map, int seed) {
  test::Run run = runOf(s, arena, seed);
  Peer peer(s, map);
  test::PoseErrors errors;
  std::vector<double> update_us;
  int doubtful = 0;
  int lost = 0;
  double sum = 0.0;
  for (int i = 0; i < static_cast<int>(s.seconds * 10.0); ++i) {
    const test::Moment moment = run.next();
    if (i == 0) {
      peer.believe(moment.T_arena_base);
    }
    const double before = bench::cpuSeconds();
    peer.add(moment.scan);
    const slam::Pose2 pose = peer.pose(moment.scan.T_odom_base);
    update_us.push_back(1e6 * (bench::cpuSeconds() - before));
    sum += update_us.back();
    errors.add(pose, moment.T_arena_base);
    doubtful += peer.isSure() ? 0 : 1;
    lost += pose.distanceTo(moment.T_arena_base) > kLostM ? 1 : 0;
  }
  const test::PoseScore score = errors.score();
  std::printf("%d,%d,%d,%g,%.4f,%.4f,%.4f,%.3f,%.3f,%.3f,%.1f,%.1f,%zu,%d,%d,%.1f\n", s.arena, s.walls, seed, s.odo,
              score.rmse, score.p95, score.most, score.heading_rms / kDegree, score.heading_p95 / kDegree,
              score.heading_most / kDegree, sum / static_cast<double>(update_us.size()),
              bench::percentile(update_us, 0.99), update_us.size(), doubtful, lost, run.driven());
}

int runBench(const Settings& s) {
  const test::Arena arena = test::Arena::withTenBoxes(s.arena, s.walls);
  const slam::GridMap map = test::drawnMap(arena, s.arena);
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
    std::cerr << "localisation_mrpt_bench: " << error.what() << '\n';
    return 1;
  }
}
