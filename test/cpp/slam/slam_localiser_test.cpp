// Finding and following a robot in a known map; doubt that must be told; input that is wrong.
#include "slam_world.hpp"
#include "yarm/slam/localiser.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace yarm::slam {
namespace {

using test::Arena;
using test::Moment;
using test::RunOptions;
using Tour = test::Run;

constexpr int kTurn = 160;  // scans of a full turn, and a few

PoseBelief rough(const Pose2& pose, double sigma_m = 0.5, double sigma_rad = M_PI / 12.0) {
  const Eigen::Vector3d variances{sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad};
  return {pose, variances.asDiagonal()};
}

struct End {
  LocaliserResult result;
  Moment moment;
  int scans{0};

  [[nodiscard]] double offM() const { return result.T_map_base.distanceTo(moment.T_arena_base); }
  [[nodiscard]] double offRad() const { return std::abs(wrapAngle(result.T_map_base.yaw - moment.T_arena_base.yaw)); }
};

// Plays scans until the robot is localised, or `most` are used up.
End playUntilFound(Tour& run, Localiser& localiser, int most) {
  End end;
  while (end.scans < most && !end.result.localised) {
    end.moment = run.next();
    end.result = localiser.addScan(end.moment.scan);
    ++end.scans;
    EXPECT_FALSE(end.result.dropped) << end.result.reason;
  }
  return end;
}

class InTenBoxes : public ::testing::TestWithParam<int> {
 protected:
  InTenBoxes()
      : arena_(Arena::withTenBoxes(GetParam())), map_(test::drawnMap(arena_, GetParam())), run_(arena_, GetParam()) {}

  Arena arena_;
  GridMap map_;
  Tour run_;
};

void expectRight(const End& end) {
  ASSERT_TRUE(end.result.localised) << end.result.reason;
  EXPECT_EQ(end.result.reason, "");
  EXPECT_EQ(end.result.state, LocaliserState::kTracking);
  EXPECT_LT(end.offM(), 0.05);
  EXPECT_LT(end.offRad(), 0.03);
  EXPECT_GT(end.result.agreement, 0.9);
}

TEST_P(InTenBoxes, FromNothingAfterOneTurn) {
  Localiser localiser({}, map_);
  const End end = playUntilFound(run_, localiser, kTurn);
  expectRight(end);
  EXPECT_GT(end.scans, 140) << "nothing is claimed before one turn";
  EXPECT_EQ(localiser.wideSearches(), 1);
  EXPECT_GT(localiser.lastSearch().margin, 0.1);
}

TEST_P(InTenBoxes, FromAPoseHalfAMetreAndThirtyDegreesOff) {
  Localiser localiser({}, map_);
  Tour twin(arena_, GetParam());
  const Pose2 truth = twin.next().T_arena_base;
  ASSERT_EQ(localiser.believe(rough({truth.x - 0.4, truth.y + 0.3, wrapAngle(truth.yaw + 0.52)})), "");
  const End end = playUntilFound(run_, localiser, kTurn);
  expectRight(end);
  EXPECT_EQ(localiser.wideSearches(), 0);
}

TEST_P(InTenBoxes, FollowedOnATour) {
  Localiser localiser({}, map_);
  End end = playUntilFound(run_, localiser, kTurn);
  double squares = 0.0;
  constexpr int kScans = 900;
  for (int i = 0; i < kScans; ++i) {
    end.moment = run_.next();
    end.result = localiser.addScan(end.moment.scan);
    ASSERT_TRUE(end.result.localised) << "scan " << i << ": " << end.result.reason;
    ASSERT_LT(end.offM(), 0.15) << "scan " << i;
    squares += end.offM() * end.offM();
    const Pose2 again = end.result.T_map_odom * end.moment.scan.T_odom_base;
    ASSERT_LT(again.distanceTo(end.result.T_map_base), 1e-9);
  }
  EXPECT_LT(std::sqrt(squares / kScans), 0.03);
  EXPECT_GT(run_.driven(), 3.0);
}

TEST_P(InTenBoxes, InAMapWithATurnedOrigin) {
  // The same grid, whose corner stands elsewhere and turned in the map's frame.
  const Pose2 T_map_arena{3.0, -2.0, 0.7};
  Localiser localiser({}, map_, T_map_arena);
  Localiser straight({}, map_);
  Tour twin(arena_, GetParam());
  const Pose2 truth = twin.next().T_arena_base;
  PoseBelief belief = rough(truth, 0.3, 0.2);
  belief.covariance(0, 0) = 0.2;
  belief.covariance(0, 1) = belief.covariance(1, 0) = 0.05;
  ASSERT_EQ(straight.believe(belief), "");
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T_map_arena.yaw).toRotationMatrix();
  belief.pose = T_map_arena * truth;
  belief.covariance = turn * belief.covariance * turn.transpose();
  ASSERT_EQ(localiser.believe(belief), "");
  for (int i = 0; i < kTurn; ++i) {
    const Moment moment = run_.next();
    const LocaliserResult result = localiser.addScan(moment.scan);
    const LocaliserResult expected = straight.addScan(moment.scan);
    ASSERT_LT((T_map_arena * expected.T_map_base).distanceTo(result.T_map_base), 1e-4);
    ASSERT_LT((turn * expected.covariance * turn.transpose() - result.covariance).norm(), 1e-4);
    ASSERT_EQ(expected.localised, result.localised);
  }
}

INSTANTIATE_TEST_SUITE_P(Rooms, InTenBoxes, ::testing::Range(1, 4));

// Doubt.

const Arena& emptySquare() {
  static const Arena square(
      {{{0.0, 0.0}, {6.0, 0.0}}, {{6.0, 0.0}, {6.0, 6.0}}, {{6.0, 6.0}, {0.0, 6.0}}, {{0.0, 6.0}, {0.0, 0.0}}});
  return square;
}

TEST(Doubt, AnEmptySquareLooksAlikeFromFourSides) {
  RunOptions options;
  options.first_turns = 3;
  Tour run(emptySquare(), 5, options);
  Localiser localiser({}, test::drawnMap(emptySquare(), 5));
  const End end = playUntilFound(run, localiser, 3 * kTurn);
  EXPECT_FALSE(end.result.localised);
  EXPECT_FALSE(end.result.has_pose);
  EXPECT_GE(localiser.wideSearches(), 5);
  EXPECT_NE(end.result.reason.find("two places fit what was seen nearly alike"), std::string::npos)
      << end.result.reason;
  EXPECT_NE(end.result.reason.find("give a pose"), std::string::npos) << end.result.reason;
  ASSERT_EQ(localiser.believe(rough(end.moment.T_arena_base)), "");
  expectRight(playUntilFound(run, localiser, 2 * kTurn));
}

TEST(Doubt, ABareWallIsNoPlaceHoweverWellItFits) {
  const Arena arena = Arena::withTenBoxes(5);
  RunOptions options;
  options.odometry = 2.0;
  Tour run(arena, 5012, options);
  Tour twin(arena, 5012, options);
  const Pose2 truth = twin.next().T_arena_base;
  Localiser localiser({}, test::drawnMap(arena, 5));
  ASSERT_EQ(localiser.believe(rough({truth.x - 0.1922, truth.y - 0.4616, truth.yaw - 0.5236})), "");
  const End end = playUntilFound(run, localiser, kTurn);
  expectRight(end);
  EXPECT_GT(end.scans, 20) << "the first 15 scans see a wall and hardly more";
}

TEST(Doubt, ASlipWhileTurningIsNotTakenForAPlace) {
  const Arena arena = Arena::withTenBoxes(4);
  RunOptions options;
  options.slip = 4.0;
  options.first_turns = 2;
  Tour run(arena, 4037, options);
  Localiser localiser({}, test::drawnMap(arena, 4));
  const End end = playUntilFound(run, localiser, 2 * kTurn);
  EXPECT_TRUE(!end.result.localised || end.offRad() < 0.15) << end.offRad();
}

TEST(Doubt, AnotherRoomsMapFindsNothing) {
  for (int seed = 1; seed <= 3; ++seed) {
    const Arena here = Arena::withTenBoxes(seed);
    Tour run(here, seed);
    Localiser localiser({}, test::drawnMap(Arena::withTenBoxes(seed + 10), seed));
    const End end = playUntilFound(run, localiser, kTurn);
    EXPECT_FALSE(end.result.localised) << "seed " << seed;
    EXPECT_EQ(localiser.wideSearches(), 1);
    EXPECT_NE(end.result.reason, "");
  }
}

TEST(Doubt, APoseGivenInTheWrongCornerIsNotBelieved) {
  const Arena arena = Arena::withTenBoxes(2);
  RunOptions options;
  options.first_turns = 2;
  Tour run(arena, 2, options);
  Localiser localiser({}, test::drawnMap(arena, 2));
  Tour twin(arena, 2, options);
  const Pose2 truth = twin.next().T_arena_base;
  const Pose2 wrong{truth.x < 3.0 ? truth.x + 2.5 : truth.x - 2.5, truth.y, wrapAngle(truth.yaw + 2.0)};
  ASSERT_EQ(localiser.believe(rough(wrong)), "");
  const End end = playUntilFound(run, localiser, 2 * kTurn);
  expectRight(end);  // found in the whole map, once the window was searched in vain
  EXPECT_GT(end.scans, 140);
}

TEST(Doubt, ARobotCarriedAwayIsNoticedAndFoundAgain) {
  const Arena arena = Arena::withTenBoxes(1);
  Localiser localiser({}, test::drawnMap(arena, 1));
  Tour before(arena, 1);
  expectRight(playUntilFound(before, localiser, kTurn));
  RunOptions options;
  options.first_turns = 3;
  Tour after(arena, 77, options);
  Pose2 T_odom_odom;
  std::int64_t stamp = 0;
  bool noticed = false;
  LocaliserResult result;
  Moment moment;
  const Moment last = before.next();
  for (int i = 0; i < 3 * kTurn; ++i) {
    moment = after.next();
    if (i == 0) {
      T_odom_odom = last.scan.T_odom_base * moment.scan.T_odom_base.inverse();
      stamp = last.scan.stamp_ns - moment.scan.stamp_ns;
    }
    moment.scan.T_odom_base = T_odom_odom * moment.scan.T_odom_base;
    moment.scan.stamp_ns += stamp;
    result = localiser.addScan(moment.scan);
    noticed = noticed || result.reason.find("lost") != std::string::npos;
  }
  EXPECT_TRUE(noticed);
  expectRight({result, moment, 0});
}

TEST(Surroundings, OfAMapThatIsEmptyYetAreNone) {
  Mapper submap(Params{});
  const Surroundings seen = surroundingsOf(submap, {}, {});
  EXPECT_TRUE(seen.points.empty());
  EXPECT_TRUE(seen.empty.empty());
  const DistanceField field(test::drawnMap(emptySquare(), 1), {});
  const PlaceSearch search = searchPlace(seen, field, std::nullopt, {});
  EXPECT_FALSE(search.found);
  EXPECT_NE(search.reason.find("only 0 points"), std::string::npos) << search.reason;
}

// Input.

TEST(Localiser, RefusesParametersAndMapsThatCannotBe) {
  LocaliserParams params;
  params.search.step = 0.0;
  params.track.beams = 1;
  params.submap.scan.stride = 0;
  try {
    Localiser localiser(params, test::drawnMap(emptySquare(), 1));
    FAIL() << "taken";
  } catch (const std::invalid_argument& error) {
    for (const char* name : {"search.step = 0", "track.beams = 1", "scan.stride = 0"}) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  }
  GridMap map = test::drawnMap(emptySquare(), 1);
  map.cells.assign(map.cells.size(), 0);
  EXPECT_THROW(Localiser({}, map), std::invalid_argument);
  map.cells.assign(map.cells.size(), 100);
  EXPECT_THROW(Localiser({}, map), std::invalid_argument);
  EXPECT_THROW(Localiser({}, test::drawnMap(emptySquare(), 1), {NAN, 0.0, 0.0}), std::invalid_argument);
}

TEST(Localiser, RefusesPosesThatAreNone) {
  Localiser localiser({}, test::drawnMap(emptySquare(), 1));
  PoseBelief belief = rough({std::numeric_limits<double>::infinity(), 0.0, 0.0});
  EXPECT_NE(localiser.believe(belief), "");
  belief = rough({1.0, 1.0, 0.0});
  belief.covariance(1, 1) = -0.5;
  EXPECT_NE(localiser.believe(belief), "");
  EXPECT_EQ(localiser.state(), LocaliserState::kSearching);
  belief.covariance = Eigen::Matrix3d::Zero();  // sure, as some senders have it
  EXPECT_EQ(localiser.believe(belief), "");
}

TEST(Localiser, RefusesSickScansAndGoesOn) {
  const Arena arena = Arena::withTenBoxes(1);
  Tour run(arena, 1);
  Localiser localiser({}, test::drawnMap(arena, 1));
  const std::vector<std::function<void(Scan&)>> sicknesses{
      [](Scan& scan) { scan.ranges.clear(); }, [](Scan& scan) { scan.angle_increment = 0.0; },
      [](Scan& scan) { scan.T_odom_base.x = NAN; }, [](Scan& scan) { scan.stamp_ns -= 1'000'000'000; }};
  End end;
  for (end.scans = 0; end.scans < kTurn && !end.result.localised; ++end.scans) {
    end.moment = run.next();
    if (end.scans > 0) {
      Scan sick = end.moment.scan;
      sicknesses[end.scans % sicknesses.size()](sick);
      const LocaliserResult refused = localiser.addScan(sick);
      EXPECT_TRUE(refused.dropped);
      EXPECT_NE(refused.reason, "");
    }
    end.result = localiser.addScan(end.moment.scan);
  }
  expectRight(end);
}

TEST(Localiser, ABlindSensorAddsDoubtWithTheWay) {
  const Arena arena = Arena::withTenBoxes(1);
  RunOptions options;
  options.speed = 0.3;
  Tour run(arena, 1, options);
  Localiser localiser({}, test::drawnMap(arena, 1));
  End end = playUntilFound(run, localiser, kTurn);
  expectRight(end);
  for (int i = 0; i < 600 && end.result.localised; ++i) {
    end.moment = run.next();
    std::fill(end.moment.scan.ranges.begin(), end.moment.scan.ranges.end(), NAN);
    end.result = localiser.addScan(end.moment.scan);
  }
  EXPECT_FALSE(end.result.localised);
  EXPECT_NE(end.result.reason.find("only sure to"), std::string::npos) << end.result.reason;
  EXPECT_TRUE(end.result.has_pose);
}

TEST(Localiser, SamplesWhatItBelieves) {
  const Arena arena = Arena::withTenBoxes(1);
  const GridMap map = test::drawnMap(arena, 1);
  Localiser localiser({}, map);
  std::mt19937_64 random(1);
  for (const Pose2& pose : localiser.sample(500, random)) {  // anywhere free
    EXPECT_TRUE(DistanceField(map, {}).isFree({pose.x, pose.y}));
  }
  ASSERT_EQ(localiser.believe(rough({2.0, 3.0, 1.0})), "");
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double variance = 0.0;
  for (const Pose2& pose : localiser.sample(4000, random)) {
    mean += Eigen::Vector2d{pose.x, pose.y} / 4000.0;
    variance += (pose.x - 2.0) * (pose.x - 2.0) / 4000.0;
  }
  EXPECT_LT((mean - Eigen::Vector2d{2.0, 3.0}).norm(), 0.05);
  EXPECT_NEAR(variance, 0.25, 0.03);
}

TEST(Localiser, TheSameInputGivesTheSamePoses) {
  const Arena arena = Arena::withTenBoxes(2);
  const GridMap map = test::drawnMap(arena, 2);
  std::vector<Pose2> first;
  for (int round = 0; round < 2; ++round) {
    Tour run(arena, 9);
    Localiser localiser({}, map);
    for (int i = 0; i < kTurn + 100; ++i) {
      const Pose2 pose = localiser.addScan(run.next().scan).T_map_base;
      if (round == 0) {
        first.push_back(pose);
      }
      ASSERT_EQ(pose.x, first[i].x);
      ASSERT_EQ(pose.yaw, first[i].yaw);
    }
  }
}

}  // namespace
}  // namespace yarm::slam
