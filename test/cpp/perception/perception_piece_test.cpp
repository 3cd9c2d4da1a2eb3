// Middle, top and axis of a piece from its points.
#include "yarm/perception/piece.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace yarm::test {
namespace {

namespace pc = yarm::perception;

constexpr double kPi = 3.14159265358979323846;

struct Block {
  double x{0.3};
  double y{-0.2};
  double yaw{0.0};
  double noise_m{0.0};
  float least_y{-1.0F};  ///< points with less y, in the block's frame, are left out
};

/// Points on the top (z = 0.77 m) of a block of 0.15 x 0.06 m, and down its sides by 0.04 m.
std::vector<Eigen::Vector3f> pointsOf(const Block& block, int count = 400) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<Eigen::Vector3f> points;
  while (static_cast<int>(points.size()) < count) {
    const bool side = points.size() % 4 == 0;
    const double u = side && points.size() % 8 == 0 ? std::copysign(0.075, uniform(random)) : 0.15 * uniform(random);
    const double v = side && points.size() % 8 == 4 ? std::copysign(0.03, uniform(random)) : 0.06 * uniform(random);
    const double z = side ? 0.75 + 0.04 * uniform(random) : 0.77;
    if (v < static_cast<double>(block.least_y)) {
      continue;
    }
    const double c = std::cos(block.yaw);
    const double s = std::sin(block.yaw);
    const Eigen::Vector3d point(block.x + c * u - s * v, block.y + s * u + c * v, z);
    const Eigen::Vector3d off(noise(random), noise(random), noise(random));
    points.emplace_back((point + block.noise_m * off).cast<float>());
  }
  return points;
}

double turnBetween(double a, double b) {
  return std::abs(std::remainder(a - b, kPi));
}

TEST(Piece, MiddleTopAndAxisAtEveryHeading) {
  for (double yaw = -3.1; yaw < 3.1; yaw += 0.2) {
    Block block;
    block.yaw = yaw;
    const auto view = pc::pieceOf(pointsOf(block));
    ASSERT_TRUE(view);
    EXPECT_EQ(view->points, 400U);
    EXPECT_NEAR(view->top.x(), block.x, 0.003);
    EXPECT_NEAR(view->top.y(), block.y, 0.003);
    EXPECT_NEAR(view->top.z(), 0.77, 1e-6);
    EXPECT_LT(turnBetween(view->axis_rad, yaw), 0.05);
    EXPECT_GT(view->axis_rad, -kPi / 2 - 1e-6);
    EXPECT_LE(view->axis_rad, kPi / 2 + 1e-6);
    EXPECT_NEAR(view->length, 0.15, 0.015);
    EXPECT_NEAR(view->width, 0.06, 0.006);
  }
}

TEST(Piece, NoiseOfACentimetreMovesTheMiddleByLittle) {
  Block block;
  block.yaw = 0.7;
  block.noise_m = 0.01;
  const auto view = pc::pieceOf(pointsOf(block));
  ASSERT_TRUE(view);
  EXPECT_LT(std::hypot(view->top.x() - block.x, view->top.y() - block.y), 0.006);
  EXPECT_NEAR(view->top.z(), 0.77, 0.012);
  EXPECT_LT(turnBetween(view->axis_rad, block.yaw), 0.1);
}

TEST(Piece, MorePointsOnOneEndDoNotDrawTheMiddleThere) {
  std::vector<Eigen::Vector3f> points = pointsOf({});
  const std::size_t whole = points.size();
  for (std::size_t i = 0; i < whole; ++i) {
    if (points[i].x() > 0.3F) {
      points.push_back(points[i]);
    }
  }
  const auto view = pc::pieceOf(points);
  ASSERT_TRUE(view);
  EXPECT_NEAR(view->top.x(), 0.3, 0.006);
}

TEST(Piece, AHiddenSideShowsInTheWidth) {
  Block block;
  block.least_y = 0.0F;
  const auto view = pc::pieceOf(pointsOf(block));
  ASSERT_TRUE(view);
  EXPECT_LT(view->width, 0.035);
}

TEST(Piece, TooLittleSaysNothing) {
  EXPECT_FALSE(pc::pieceOf({}));
  std::vector<Eigen::Vector3f> points = pointsOf({}, static_cast<int>(pc::kLeastPiecePoints));
  EXPECT_TRUE(pc::pieceOf(points));
  points.pop_back();
  EXPECT_FALSE(pc::pieceOf(points));
  EXPECT_FALSE(pc::pieceOf(std::vector<Eigen::Vector3f>(40, Eigen::Vector3f(0.1F, 0.2F, 0.7F))));
}

}  // namespace
}  // namespace yarm::test
