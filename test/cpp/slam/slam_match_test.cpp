// Scans as points, and matching them, against known transforms.
#include "slam_world.hpp"
#include "yarm/slam/coarse_search.hpp"
#include "yarm/slam/match.hpp"
#include "yarm/slam/scan_points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace yarm::slam {
namespace {

using test::Arena;
using test::exactScan;
using test::Segment;

constexpr double kExactM = 0.008;  // the weak pull towards the start included
constexpr double kExactRad = 0.003;

// For exact scans, which do not read short.
ScanParams unbiased() {
  ScanParams params;
  params.bias_slope = 0.0;
  return params;
}

ScanPoints pointsAt(const Arena& arena, const Pose2& pose) {
  return ScanPoints(exactScan(arena, pose), unbiased());
}

// A corner with a pillar: every direction is bound.
Arena corner() {
  return Arena(
      {{{3.0, -2.0}, {3.0, 1.2}}, {{3.0, 1.2}, {-1.0, 1.2}}, {{1.8, -0.6}, {2.0, -0.3}}, {{1.8, -0.6}, {2.1, -0.8}}});
}

TEST(ScanPointsTest, LieOnTheWallWithTheirNormalsTowardsTheSensor) {
  const Arena wall(std::vector<Segment>{{{2.0, -3.0}, {2.0, 3.0}}});
  const ScanPoints scan = pointsAt(wall, {});
  ASSERT_GT(scan.points().size(), 100U);
  for (const SurfacePoint& point : scan.points()) {
    EXPECT_NEAR(point.x, 2.0, 1e-3);
    EXPECT_NEAR(point.nx, -1.0, 1e-3);
    EXPECT_NEAR(point.ny, 0.0, 0.02);
  }
}

TEST(ScanPointsTest, BeamsMayRunClockwise) {
  const Arena arena = corner();
  const Scan left_handed = exactScan(arena, {});
  Scan clockwise = left_handed;
  std::reverse(clockwise.ranges.begin(), clockwise.ranges.end());
  clockwise.angle_min =
      left_handed.angle_min + (static_cast<double>(left_handed.ranges.size()) - 1.0) * left_handed.angle_increment;
  clockwise.angle_increment = -left_handed.angle_increment;
  const ScanPoints a(left_handed, unbiased());
  const ScanPoints b(clockwise, unbiased());
  ASSERT_EQ(a.points().size(), b.points().size());
  for (std::size_t i = 0; i < a.points().size(); ++i) {
    EXPECT_NEAR(a.points()[i].x, b.points()[i].x, 1e-3);
    EXPECT_NEAR(a.points()[i].y, b.points()[i].y, 1e-3);
  }
}

TEST(ScanPointsTest, NothingSeenGivesNoPoints) {
  Scan scan = exactScan(corner(), {});
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity(), -1.0F, 0.0F, 1e30F}) {
    std::fill(scan.ranges.begin(), scan.ranges.end(), bad);
    EXPECT_TRUE(faultOf(scan).empty());
    EXPECT_TRUE(ScanPoints(scan, ScanParams()).points().empty()) << bad;
  }
}

TEST(ScanPointsTest, FaultsOfAScanAreNamed) {
  const Scan good = exactScan(corner(), {});
  ASSERT_EQ(faultOf(good), "");
  Scan bad = good;
  bad.ranges.clear();
  EXPECT_NE(faultOf(bad).find("no beams"), std::string::npos);
  bad = good;
  bad.angle_increment = 0.0;
  EXPECT_NE(faultOf(bad).find("angle_increment"), std::string::npos);
  bad = good;
  bad.angle_increment = 0.1;  // 640 beams of it: ten rounds
  EXPECT_NE(faultOf(bad).find("more than once"), std::string::npos);
  bad = good;
  bad.angle_min = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(faultOf(bad).find("angle_min"), std::string::npos);
  bad = good;
  bad.range_max = bad.range_min;
  EXPECT_NE(faultOf(bad).find("range_max"), std::string::npos);
  bad = good;
  bad.T_odom_base.x = std::numeric_limits<double>::infinity();
  EXPECT_NE(faultOf(bad).find("odometry"), std::string::npos);
  bad = good;
  bad.ranges.resize(50000, 1.0F);
  EXPECT_NE(faultOf(bad).find("50000"), std::string::npos);
}

class KnownTransforms : public ::testing::TestWithParam<Pose2> {};

TEST_P(KnownTransforms, AreFoundFromTheWrongStart) {
  const Arena arena = corner();
  const Pose2 reference{0.1, -0.2, 0.1};
  const ScanPoints target = pointsAt(arena, reference);
  const Pose2 truth = reference * GetParam();
  const ScanPoints scan = pointsAt(arena, truth);
  const MatchResult match = matchScan(scan, reference, {{&target, reference}}, std::nullopt, MatchParams());
  ASSERT_TRUE(match.ok) << match.reason;
  EXPECT_NEAR(match.T_map_sensor.x, truth.x, kExactM);
  EXPECT_NEAR(match.T_map_sensor.y, truth.y, kExactM);
  EXPECT_NEAR(wrapAngle(match.T_map_sensor.yaw - truth.yaw), 0.0, kExactRad);
}

INSTANTIATE_TEST_SUITE_P(Motions, KnownTransforms,
                         ::testing::Values(Pose2{0.0, 0.0, 0.0}, Pose2{0.1, 0.0, 0.0}, Pose2{0.0, -0.1, 0.0},
                                           Pose2{-0.1, 0.05, 0.0}, Pose2{0.0, 0.0, 0.1}, Pose2{0.0, 0.0, -0.1},
                                           Pose2{0.12, 0.06, -0.06}, Pose2{-0.08, -0.08, 0.08}));

// 57 degrees: a turn shows new wall on one side. It must not pull the scan back on to the wall that is known.
TEST(MatchTest, UnseenSpaceDoesNotPullATurnBack) {
  const Arena wall({{{2.5, -1.0}, {2.5, 6.0}}, {{2.5, -1.0}, {0.5, -1.0}}});
  const ScanPoints target = pointsAt(wall, {});
  for (const double turn : {0.05, 0.1, 0.15}) {
    const Pose2 truth{0.0, 0.0, turn};
    const ScanPoints scan = pointsAt(wall, truth);
    const MatchResult match =
        matchScan(scan, {0.0, 0.0, turn - 0.03}, {{&target, Pose2()}}, std::nullopt, MatchParams());
    ASSERT_TRUE(match.ok) << match.reason;
    EXPECT_NEAR(match.T_map_sensor.yaw, turn, kExactRad);
  }
}

TEST(MatchTest, ABareWallBindsNothingAlongItself) {
  const Arena wall(std::vector<Segment>{{{2.0, -9.0}, {2.0, 9.0}}});
  const ScanPoints scan = pointsAt(wall, {});
  const PosePrior prior{{0.0, 0.1, 0.0}, Eigen::Vector3d(100.0, 100.0, 100.0).asDiagonal()};
  const MatchResult match = matchScan(scan, {0.05, 0.1, 0.0}, {{&scan, Pose2()}}, prior, MatchParams());
  ASSERT_TRUE(match.ok) << match.reason;
  EXPECT_NEAR(match.T_map_sensor.x, 0.0, kExactM);
  EXPECT_NEAR(match.T_map_sensor.y, 0.1, 0.01) << "only the prior speaks along the wall";
  EXPECT_LT(match.information(1, 1), 1e-3 * match.information(0, 0));
}

TEST(MatchTest, TheTwoFacesOfAThinWallNeverPair) {
  const std::vector<Segment> faces{{{2.0, -3.0}, {2.0, 3.0}}, {{2.1, -3.0}, {2.1, 3.0}}};
  const Arena wall(faces);
  const ScanPoints front = pointsAt(wall, {0.0, 0.0, 0.0});
  const Pose2 behind{4.0, 0.0, M_PI};
  const ScanPoints back = pointsAt(wall, behind);
  ASSERT_GT(front.points().size(), 100U);
  ASSERT_GT(back.points().size(), 100U);
  const MatchResult match = matchScan(back, behind, {{&front, Pose2()}}, std::nullopt, MatchParams());
  EXPECT_EQ(match.paired, 0);
  EXPECT_FALSE(match.ok);
  EXPECT_EQ(match.T_map_sensor.x, behind.x);
  MatchParams blind;
  blind.normals_dot = -1.0;  // what the rule is for: without it they do pair
  const MatchResult paired = matchScan(back, behind, {{&front, Pose2()}}, std::nullopt, blind);
  EXPECT_GT(paired.paired, 50);
}

TEST(MatchTest, NoTargetsIsAnAnswerNotAFault) {
  const ScanPoints scan = pointsAt(corner(), {});
  const MatchResult match = matchScan(scan, {1.0, 2.0, 3.0}, {}, std::nullopt, MatchParams());
  EXPECT_FALSE(match.ok);
  EXPECT_EQ(match.in_view, 0);
  EXPECT_EQ(match.T_map_sensor.x, 1.0);
}

TEST(MatchTest, OverlapIsFullInPlaceAndNoneBehind) {
  const Arena arena = corner();
  const ScanPoints scan = pointsAt(arena, {});
  EXPECT_GT(overlapOf(scan, {}, {&scan, {}}), 0.99);
  EXPECT_EQ(overlapOf(scan, {0.0, 0.0, M_PI}, {&scan, {}}), 0.0);
}

TEST(CoarseSearchTest, FindsTheScanAfterASlipThatAMatchCannotBridge) {
  const Arena arena = corner();
  const ScanPoints target = pointsAt(arena, {});
  const ScanPoints scan = pointsAt(arena, {});
  const Pose2 slipped{0.27, -0.22, 0.21};
  const SearchResult place = searchCoarsely(scan, slipped, {{&target, Pose2()}}, KeyframeParams());
  ASSERT_TRUE(place.found) << "score " << place.score;
  const MatchResult match = matchScan(scan, place.T_map_sensor, {{&target, Pose2()}}, std::nullopt, MatchParams());
  ASSERT_TRUE(match.ok) << match.reason;
  EXPECT_NEAR(match.T_map_sensor.x, 0.0, kExactM);
  EXPECT_NEAR(match.T_map_sensor.y, 0.0, kExactM);
  EXPECT_NEAR(match.T_map_sensor.yaw, 0.0, kExactRad);
}

TEST(CoarseSearchTest, FindsNothingWhereNothingIsAlike) {
  const ScanPoints target = pointsAt(corner(), {});
  const ScanPoints scan = pointsAt(corner(), {});
  EXPECT_FALSE(searchCoarsely(scan, {9.0, 9.0, 2.0}, {{&target, Pose2()}}, KeyframeParams()).found);
  EXPECT_FALSE(searchCoarsely(ScanPoints(), {}, {{&target, Pose2()}}, KeyframeParams()).found);
  EXPECT_FALSE(searchCoarsely(scan, {}, {}, KeyframeParams()).found);
}

}  // namespace
}  // namespace yarm::slam
