// The whole map maker on tours of simulated rooms, and with input that is wrong.
#include "slam_score.hpp"
#include "slam_world.hpp"
#include "yarm/slam/mapper.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

namespace yarm::slam {
namespace {

using test::Arena;
using test::Moment;
using test::PoseErrors;
using Tour = test::Run;
using test::RunOptions;

constexpr int kScans = 1200;  // two simulated minutes

struct Toured {
  test::MapScore map;
  test::PoseScore pose;
  test::PoseScore odometry;
  Statistics did;
  GridMap grid;
  std::vector<Pose2> poses;
};

Toured toured(int arena_seed, const RunOptions& options, const Params& params, int scans = kScans) {
  const Arena arena(arena_seed);
  Tour run(arena, arena_seed, options);
  Mapper mapper(params);
  test::SeenSurfaces surfaces(arena);
  PoseErrors errors;
  PoseErrors odometry;
  Toured result;
  Pose2 start;
  for (int i = 0; i < scans; ++i) {
    const Moment moment = run.next();
    if (i == 0) {
      start = moment.T_arena_base;
    }
    surfaces.add(moment, params.map.max_range);
    const ScanResult answer = mapper.addScan(moment.scan);
    EXPECT_NE(answer.status, ScanStatus::kDropped) << answer.reason;
    errors.add(start * answer.T_map_base, moment.T_arena_base);
    odometry.add(start * moment.scan.T_odom_base, moment.T_arena_base);
    result.poses.push_back(answer.T_map_base);
    if (i % 50 == 49) {
      mapper.requestMap();
    }
  }
  mapper.finish();
  EXPECT_TRUE(mapper.requestMap());
  mapper.finish();
  result.grid = *mapper.map();
  result.map = test::scoreMap(result.grid, arena, surfaces.seen(10), start, true);
  result.pose = errors.score();
  result.odometry = odometry.score();
  result.did = mapper.statistics();
  return result;
}

void expectGood(const Toured& tour, double mean_m, double rmse_m, double heading_rad) {
  EXPECT_LT(tour.map.mean, mean_m);
  EXPECT_LT(tour.map.spurious, 0.01);
  EXPECT_GT(tour.map.within_10cm, 0.97);
  EXPECT_LT(tour.pose.rmse, rmse_m);
  EXPECT_LT(tour.pose.heading_rms, heading_rad);
}

TEST(MapperTest, MapsARoom) {
  for (const int arena : {4, 5}) {
    SCOPED_TRACE("arena " + std::to_string(arena));
    expectGood(toured(arena, {}, Params()), 0.030, 0.045, 0.02);
  }
}

TEST(MapperTest, SurvivesBadOdometry) {
  RunOptions hard;
  hard.odometry = 2.0;
  hard.speed = 0.3;
  hard.turn_rate = 0.6;
  const Toured tour = toured(6, hard, Params());
  expectGood(tour, 0.040, 0.08, 0.035);
  EXPECT_LT(tour.pose.rmse, 0.5 * tour.odometry.rmse);
}

TEST(MapperTest, SurvivesBigSlips) {
  RunOptions slippery;
  slippery.slip = 4.0;
  expectGood(toured(7, slippery, Params()), 0.030, 0.10, 0.04);
}

TEST(MapperTest, TheSameInputGivesTheSameBytes) {
  const Toured a = toured(5, {}, Params(), 600);
  const Toured b = toured(5, {}, Params(), 600);
  EXPECT_TRUE(a.grid.cells == b.grid.cells);
  EXPECT_EQ(a.did.edges, b.did.edges);
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    ASSERT_EQ(a.poses[i].x, b.poses[i].x) << i;
    ASSERT_EQ(a.poses[i].yaw, b.poses[i].yaw) << i;
  }
}

TEST(MapperTest, AScanThatIsSaidTwiceChangesNoMap) {
  const Arena arena(5);
  std::vector<GridMap> maps;
  for (const int times : {1, 2}) {
    Tour run(arena, 5);
    Mapper mapper((Params()));
    for (int i = 0; i < 200; ++i) {
      const Moment moment = run.next();
      for (int j = 0; j < (i == 0 ? times : 1); ++j) {
        EXPECT_EQ(mapper.addScan(moment.scan).status == ScanStatus::kDropped, j > 0);
      }
    }
    EXPECT_TRUE(mapper.requestMap());
    maps.push_back(*mapper.map());
  }
  EXPECT_TRUE(maps[0].cells == maps[1].cells);
}

TEST(MapperTest, ItsOwnThreadMapsAsWell) {
  Params params;
  params.sync = false;
  expectGood(toured(4, {}, params), 0.030, 0.045, 0.02);
}

TEST(MapperTest, AKnownPlaceMakesNoNewKeyframes) {
  const Arena arena(4);
  Tour run(arena, 4);
  Mapper mapper((Params()));
  const Moment first = run.next();
  // Forty full turns on one spot: what one has shown, the others know.
  int after_first_turn = 0;
  for (int i = 0; i < 40 * 157; ++i) {
    const Pose2 turned{0.0, 0.0, wrapAngle(i * 0.04)};
    Scan scan = test::exactScan(arena, first.T_arena_base * turned * test::sensorMount());
    scan.stamp_ns += static_cast<std::int64_t>(i) * 100'000'000;
    scan.T_base_sensor = test::sensorMount();
    scan.T_odom_base = turned;
    mapper.addScan(scan);
    after_first_turn = i == 2 * 157 ? mapper.statistics().keyframes : after_first_turn;
  }
  EXPECT_GT(after_first_turn, 20);
  EXPECT_LE(mapper.statistics().keyframes, after_first_turn + 5);
}

// The base is stuck and its wheels spin: odometry creeps ahead, back, and ahead again, while the scan stays.
struct Spun {
  double worst_m{0};
  GridMap map;
};

Spun spun(const Params& params) {
  const Arena arena(4);
  Mapper mapper(params);
  Tour run(arena, 4);
  const Moment first = run.next();
  Spun result;
  double odometry_m = 0.0;
  for (int i = 0; i < 300; ++i) {
    odometry_m += i < 50 ? 0.0 : (i / 20 % 2 == 0 ? 0.005 : -0.003);
    Scan scan = test::exactScan(arena, first.T_arena_base * test::sensorMount());
    scan.stamp_ns += static_cast<std::int64_t>(i) * 100'000'000;
    scan.T_base_sensor = test::sensorMount();
    scan.T_odom_base = Pose2{odometry_m, 0.0, 0.0};
    const Pose2 believed = mapper.addScan(scan).T_map_base;
    result.worst_m = std::max(result.worst_m, std::hypot(believed.x, believed.y));
    if (i % 50 == 49) {
      mapper.requestMap();  // in the middle of a slip
    }
  }
  result.map = *mapper.map();
  return result;
}

std::vector<Pose2> occupied(const GridMap& map) {
  std::vector<Pose2> centres;
  for (int i = 0; i < map.width * map.height; ++i) {
    if (map.cells[i] == 100) {
      centres.push_back({map.origin_x + (i % map.width + 0.5) * map.resolution,
                         map.origin_y + (i / map.width + 0.5) * map.resolution, 0.0});
    }
  }
  return centres;
}

// Occupied cells that are more than one cell away from all of the others.
int astray(const GridMap& map, const GridMap& others) {
  const auto right = occupied(others);
  const auto cells = occupied(map);
  return static_cast<int>(std::count_if(cells.begin(), cells.end(), [&](const Pose2& cell) {
    return std::none_of(right.begin(), right.end(),
                        [&](const Pose2& other) { return cell.distanceTo(other) < 1.5 * map.resolution; });
  }));
}

TEST(MapperTest, WheelsThatSpinBendNeitherPlaceNorMap) {
  Params seldom = turtlebotParams();
  seldom.scan.bias_slope = 0.0;
  Params often = seldom;
  seldom.keyframe.interval_s = -1.0;
  const Spun by_way = spun(seldom);
  const Spun by_time = spun(often);
  EXPECT_GT(by_way.worst_m, 0.10) << "matched by the way alone, the slip is believed for long";
  EXPECT_LT(by_time.worst_m, 0.06);
  const Arena arena(4);
  Tour run(arena, 4);
  Scan still = test::exactScan(arena, run.next().T_arena_base * test::sensorMount());
  still.T_base_sensor = test::sensorMount();
  Mapper mapper(often);
  for (int i = 0; i < 300; ++i) {
    still.stamp_ns += 100'000'000;
    mapper.addScan(still);
  }
  mapper.requestMap();
  EXPECT_EQ(astray(by_time.map, *mapper.map()), 0);
}

// Whether an edge to a keyframe of an earlier visit says that the newest keyframe stands elsewhere.
bool isAstray(const Mapper& mapper, double sigmas) {
  const Keyframes& kept = mapper.keyframes();
  const int newest = kept.size() - 1;
  return std::any_of(mapper.edges().begin(), mapper.edges().end(), [&](const PoseEdge& edge) {
    return edge.to == newest && !edge.is_odometry && Keyframes::isAnotherVisit(edge.from, newest) &&
           squaredErrorOf(edge, kept.pose(edge.from), kept.pose(newest)) > sigmas * sigmas;
  });
}

TEST(MapperTest, APlaceSeenBeforeThatContradictsIsBelievedAtOnce) {
  const Arena arena(4);
  RunOptions options;
  options.slip = 4.0;
  options.turn_rate = 1.8;
  options.rate_hz = 20.0;
  Tour run(arena, 4, options);
  const Params params = turtlebotParams();
  Mapper mapper(params);
  int contradicted = 0;
  bool must_optimise = false;
  for (int i = 0; i < 3 * kScans; ++i) {
    const int before = mapper.statistics().optimisations;
    const bool is_keyframe = mapper.addScan(run.next().scan).status == ScanStatus::kKeyframe;
    if (must_optimise) {
      ASSERT_EQ(mapper.statistics().optimisations, before + 1) << "scan " << i;
    }
    must_optimise = is_keyframe && isAstray(mapper, params.graph.cauchy);
    contradicted += must_optimise ? 1 : 0;
  }
  EXPECT_GT(contradicted, 0);
  RecordProperty("contradicted", contradicted);
}

TEST(MapperTest, RefiningDoesNotHarm) {
  const Arena arena(6);
  Tour run(arena, 6);
  Mapper mapper((Params()));
  test::SeenSurfaces surfaces(arena);
  Pose2 start;
  for (int i = 0; i < kScans; ++i) {
    const Moment moment = run.next();
    start = i == 0 ? moment.T_arena_base : start;
    surfaces.add(moment, 4.0);
    mapper.addScan(moment.scan);
  }
  mapper.requestMap();
  const double before = test::scoreMap(*mapper.map(), arena, surfaces.seen(10), start, true).mean;
  EXPECT_EQ(mapper.refine(), "");
  mapper.requestMap();
  EXPECT_LT(test::scoreMap(*mapper.map(), arena, surfaces.seen(10), start, true).mean, before + 0.002);
}

// What is wrong with one scan in the middle of a run, and the word its answer must hold.
struct Fault {
  const char* name;
  std::function<void(Scan&)> spoil;
  const char* word;
};

TEST(MapperFaultTest, OneBadScanIsRefusedByNameAndForgotten) {
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Fault> faults{
      {"no beams", [](Scan& scan) { scan.ranges.clear(); }, "no beams"},
      {"odometry inf", [&](Scan& scan) { scan.T_odom_base.x = inf; }, "odometry"},
      {"odometry nan", [&](Scan& scan) { scan.T_odom_base.yaw = nan; }, "odometry"},
      {"sensor nan", [&](Scan& scan) { scan.T_base_sensor.y = nan; }, "sensor"},
      {"clock back", [](Scan& scan) { scan.stamp_ns -= 5'000'000'000; }, "stamp"},
      {"clock stands", [](Scan& scan) { scan.stamp_ns -= 100'000'000; }, "stamp"},
      {"limits", [&](Scan& scan) { scan.range_max = nan; }, "range_max"},
  };
  const Arena arena(5);
  for (const Fault& fault : faults) {
    SCOPED_TRACE(fault.name);
    Tour run(arena, 5);
    Mapper mapper((Params()));
    Mapper untouched((Params()));
    for (int i = 0; i < 200; ++i) {
      const Moment moment = run.next();
      if (i == 100) {
        Scan bad = moment.scan;
        fault.spoil(bad);
        const ScanResult answer = mapper.addScan(bad);
        EXPECT_EQ(answer.status, ScanStatus::kDropped);
        EXPECT_NE(answer.reason.find(fault.word), std::string::npos) << answer.reason;
        EXPECT_TRUE(answer.T_map_base.isFinite());
        untouched.addScan(bad);
      }
      EXPECT_EQ(mapper.addScan(moment.scan).T_map_base.x, untouched.addScan(moment.scan).T_map_base.x);
    }
    EXPECT_EQ(mapper.statistics().dropped, 1);
    EXPECT_GT(mapper.statistics().keyframes, 5);
  }
}

TEST(MapperFaultTest, OdometryThatJumpsIsNotBelievedAndThenGoesOn) {
  const Arena arena(5);
  Tour run(arena, 5);
  Mapper mapper((Params()));
  PoseErrors errors;
  Pose2 start;
  for (int i = 0; i < 600; ++i) {
    Moment moment = run.next();
    start = i == 0 ? moment.T_arena_base : start;
    if (i >= 300) {  // the base was switched off and on: its numbers start elsewhere
      moment.scan.T_odom_base = Pose2{40.0, -7.0, 2.0} * moment.scan.T_odom_base;
    }
    const ScanResult answer = mapper.addScan(moment.scan);
    errors.add(start * answer.T_map_base, moment.T_arena_base);
    if (i == 300) {
      EXPECT_NE(answer.reason.find("jumped"), std::string::npos) << answer.reason;
    }
  }
  EXPECT_EQ(mapper.statistics().odometry_jumps, 1);
  EXPECT_LT(errors.score().most, 0.15);
}

TEST(MapperFaultTest, BlindStretchesRunOnOdometryAndSayWhy) {
  const Arena arena(5);
  Tour run(arena, 5);
  Mapper mapper((Params()));
  PoseErrors errors;
  Pose2 start;
  bool said = false;
  for (int i = 0; i < 600; ++i) {
    Moment moment = run.next();
    start = i == 0 ? moment.T_arena_base : start;
    if (i > 200 && i < 240) {
      std::fill(moment.scan.ranges.begin(), moment.scan.ranges.end(), std::numeric_limits<float>::quiet_NaN());
    }
    const ScanResult answer = mapper.addScan(moment.scan);
    said =
        said || (answer.status == ScanStatus::kUnmatched && answer.reason.find("usable points") != std::string::npos);
    errors.add(start * answer.T_map_base, moment.T_arena_base);
  }
  EXPECT_TRUE(said);
  EXPECT_LT(errors.score().most, 0.3);
}

TEST(MapperFaultTest, WrongParametersAreRefusedAllAtOnce) {
  Params params;
  params.map.resolution = -1.0;
  params.match.iterations = 0;
  params.scan.sigma_base = std::numeric_limits<double>::quiet_NaN();
  try {
    const Mapper mapper(params);
    FAIL() << "must throw";
  } catch (const std::invalid_argument& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("map.resolution"), std::string::npos) << text;
    EXPECT_NE(text.find("match.iterations"), std::string::npos) << text;
    EXPECT_NE(text.find("scan.sigma_base"), std::string::npos) << text;
  }
  EXPECT_TRUE(faultsOf(Params()).empty());
}

TEST(MapperFaultTest, BeforeTheFirstScanThereIsNoMap) {
  const Mapper mapper((Params()));
  EXPECT_EQ(mapper.map(), nullptr);
}

}  // namespace
}  // namespace yarm::slam
