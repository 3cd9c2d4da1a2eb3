// Distances to a map's surfaces, and fitting points to them.
#include "slam_world.hpp"
#include "yarm/slam/field_fit.hpp"
#include "yarm/slam/scan_points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace yarm::slam {
namespace {

GridMap emptyMap(int width, int height, double resolution = 0.1) {
  GridMap map;
  map.width = width;
  map.height = height;
  map.resolution = resolution;
  map.origin_x = -1.0;
  map.origin_y = 2.0;
  map.cells.assign(static_cast<std::size_t>(width) * height, 0);
  return map;
}

// Distance to the nearest occupied cell that has a neighbour which is known and not occupied, cell by cell.
double bruteForce(const GridMap& map, int column, int row) {
  const auto open = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < map.width && y < map.height && map.cells[y * map.width + x] >= 0 &&
           map.cells[y * map.width + x] < 65;
  };
  double least = std::numeric_limits<double>::infinity();
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const bool faces = open(x - 1, y) || open(x + 1, y) || open(x, y - 1) || open(x, y + 1);
      if (map.cells[y * map.width + x] >= 65 && faces) {
        least = std::min(least, map.resolution * std::hypot(x - column, y - row));
      }
    }
  }
  return least;
}

TEST(DistanceField, IsThatOfBruteForce) {
  FieldParams params;
  params.reach = 0.8;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    GridMap map = emptyMap(5 + static_cast<int>(random() % 20), 5 + static_cast<int>(random() % 20));
    for (auto& cell : map.cells) {
      cell = random() % (2 + seed) == 0 ? 100 : random() % 5 == 0 ? -1 : 0;
    }
    const DistanceField field(map, params);
    for (int row = 0; row < map.height; ++row) {
      for (int column = 0; column < map.width; ++column) {
        ASSERT_NEAR(field.cell(column, row), std::min(0.8, bruteForce(map, column, row)), 1e-5) << "seed " << seed;
        ASSERT_EQ(field.isFreeCell(column, row), map.cells[row * map.width + column] == 0) << "seed " << seed;
        ASSERT_EQ(field.isFree(field.centre(column, row)), field.isFreeCell(column, row));
      }
    }
  }
}

TEST(DistanceField, IsLinearBetweenCellsAndItsGradientPointsAway) {
  GridMap map = emptyMap(20, 9);
  for (int row = 0; row < map.height; ++row) {
    map.cells[row * map.width + 4] = 100;  // a wall at x = -0.55
  }
  const DistanceField field(map, {});
  for (const double x : {-0.9, -0.7, -0.5, -0.31, 0.12}) {
    const FieldSample sample = field.at({x, 2.4});
    EXPECT_NEAR(sample.distance, std::abs(x + 0.55), 1e-5);
    EXPECT_NEAR(sample.gradient.x(), x < -0.55 ? -1.0 : 1.0, 1e-5);
    EXPECT_NEAR(sample.gradient.y(), 0.0, 1e-5);
  }
}

TEST(DistanceField, TheBackOfAWallIsNoSurface) {
  GridMap map = emptyMap(20, 9);
  for (int row = 0; row < map.height; ++row) {
    map.cells[row * map.width + 0] = map.cells[row * map.width + 1] = -1;   // behind the wall
    map.cells[row * map.width + 2] = map.cells[row * map.width + 3] = 100;  // two cells thick, its face at x = -0.65
  }
  const DistanceField field(map, {});
  EXPECT_EQ(field.surfaceCells(), map.height);
  EXPECT_NEAR(field.at({-0.75, 2.4}).distance, 0.1, 1e-5);
  EXPECT_NEAR(field.at({-0.65, 2.4}).distance, 0.0, 1e-5);
}

TEST(DistanceField, OutsideThereIsNothing) {
  const DistanceField field(emptyMap(10, 10), {});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Eigen::Vector2d& point : {Eigen::Vector2d{-5.0, 2.5}, {0.5, 9.0}, {1e12, -1e12}, {nan, 2.5}}) {
    EXPECT_EQ(field.at(point).distance, field.reach());
    EXPECT_EQ(field.at(point).gradient.norm(), 0.0);
    EXPECT_FALSE(field.isFree(point));
  }
  EXPECT_EQ(field.surfaceCells(), 0);
  EXPECT_EQ(field.freeCells(), 100);
}

TEST(DistanceField, RefusesMapsThatAreNone) {
  GridMap map = emptyMap(4, 4);
  map.cells.pop_back();
  EXPECT_THROW(DistanceField(map, {}), std::invalid_argument);
  EXPECT_THROW(DistanceField(GridMap{}, {}), std::invalid_argument);
  map = emptyMap(4, 4, 0.0);
  EXPECT_THROW(DistanceField(map, {}), std::invalid_argument);
}

class Fit : public ::testing::Test {
 protected:
  Fit() : arena_(test::Arena::withTenBoxes(3)), field_(test::drawnMap(arena_, 3, 0.02), {}) {}

  [[nodiscard]] std::vector<SeenPoint> seenFrom(const Pose2& pose) const {
    test::RunOptions round;
    round.angle_min = -3.1;
    round.angle_max = 3.1;
    return seenPoints(test::exactScan(arena_, pose, round), exact_, 200);
  }

  [[nodiscard]] Pose2 freePose(std::mt19937& random) const {
    std::uniform_real_distribution<double> place(0.5, 5.5);
    Pose2 pose;
    do {
      pose = {place(random), place(random), place(random)};
    } while (!arena_.isFree({pose.x, pose.y}, 0.3));
    return {pose.x, pose.y, wrapAngle(pose.yaw)};
  }

  ScanParams exact_{0.006, 0.0012, 0.0, 5.0};
  test::Arena arena_;
  DistanceField field_;
};

TEST_F(Fit, ComesBackFromPosesThatAreOff) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> off(-0.1, 0.1);
  for (int i = 0; i < 40; ++i) {
    const Pose2 truth = freePose(random);
    const Pose2 start{truth.x + off(random), truth.y + off(random), wrapAngle(truth.yaw + 0.5 * off(random))};
    const FitResult fit = fitToField(seenFrom(truth), start, field_, std::nullopt, {});
    EXPECT_LT(fit.pose.distanceTo(truth), 0.02) << "pose " << i;
    EXPECT_LT(std::abs(wrapAngle(fit.pose.yaw - truth.yaw)), 0.01) << "pose " << i;
    EXPECT_GT(fit.share(), 0.97);
  }
}

TEST_F(Fit, ThePriorHoldsWhatThePointsLeaveFree) {
  const test::Arena wall({{{0.0, 0.0}, {0.0, 6.0}}});
  const DistanceField field(test::drawnMap(wall, 1), {});
  std::vector<SeenPoint> points;
  for (double y = -1.0; y < 1.0; y += 0.02) {
    points.push_back({{1.0, y}, 0.01});
  }
  const PosePrior prior{{1.1, 3.0, M_PI}, Eigen::Vector3d{100.0, 100.0, 100.0}.asDiagonal()};
  const FitResult fit = fitToField(points, prior.pose, field, prior, {});
  EXPECT_NEAR(fit.pose.x, 1.0, 0.03);
  EXPECT_NEAR(fit.pose.y, 3.0, 0.01);
  EXPECT_LT(fit.information(1, 1), 0.01 * fit.information(0, 0));
}

TEST_F(Fit, ThingsThatTheMapDoesNotKnowPullNowhere) {
  std::mt19937 random(5);
  const Pose2 truth = freePose(random);
  std::vector<SeenPoint> points = seenFrom(truth);
  const std::size_t count = points.size();
  for (std::size_t i = 0; i < count; i += 3) {
    points[i].at *= 0.5;  // somebody stands before every third beam
  }
  const Pose2 start{truth.x + 0.05, truth.y - 0.05, truth.yaw};
  const FitResult fit = fitToField(points, start, field_, std::nullopt, {});
  EXPECT_LT(fit.pose.distanceTo(truth), 0.03);
  EXPECT_LT(fit.share(), 0.85);
}

TEST(SeenPoints, AreThoseOfTheRobotAndWithinLimits) {
  Scan scan;
  scan.angle_min = -0.2;
  scan.angle_increment = 0.1;
  scan.range_min = 0.45;
  scan.range_max = 5.0;
  scan.ranges = {1.0F, 0.1F, 2.0F, std::numeric_limits<float>::quiet_NaN(), 7.0F};
  scan.T_base_sensor = {0.5, 0.1, M_PI / 2.0};
  ScanParams params;
  params.bias_slope = 0.0;
  const auto points = seenPoints(scan, params, 100);
  ASSERT_EQ(points.size(), 2U);
  EXPECT_NEAR((points[1].at - Eigen::Vector2d{0.5, 2.1}).norm(), 0.0, 1e-9);
  EXPECT_NEAR(points[1].sigma, rangeSigma(params, 2.0), 1e-9);
  EXPECT_EQ(seenPoints(scan, params, 1).size(), 1U);
}

}  // namespace
}  // namespace yarm::slam
