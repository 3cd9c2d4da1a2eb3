// The rectangle of something small, from few points on it and beside it.
#include "footprint.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace yarm::test {
namespace {

namespace pc = yarm::perception;

constexpr float kPi = 3.14159265F;
constexpr float kPitch = 0.03F;

/// A lattice of points, turned and shifted at random, sorted by whether they meet a rectangle.
struct Pixels {
  std::vector<Eigen::Vector2f> on;
  std::vector<Eigen::Vector2f> beside;
};

Pixels pixelsOf(const pc::Footprint& truth, float spacing, std::mt19937& random) {
  std::uniform_real_distribution<float> uniform(0.F, 1.F);
  const Eigen::Rotation2Df lattice(kPi * uniform(random));
  const Eigen::Vector2f shift(spacing * uniform(random), spacing * uniform(random));
  const Eigen::Rotation2Df to_own(-truth.axis_rad);
  Pixels pixels;
  for (int i = -12; i <= 12; ++i) {
    for (int j = -12; j <= 12; ++j) {
      const Eigen::Vector2f place =
          lattice * (spacing * Eigen::Vector2f(static_cast<float>(i), static_cast<float>(j)) + shift);
      const Eigen::Vector2f own = to_own * place;
      const bool inside = std::abs(own.x()) < 0.5F * truth.length && std::abs(own.y()) < 0.5F * truth.width;
      (inside ? pixels.on : pixels.beside).push_back(place + truth.middle);
    }
  }
  return pixels;
}

TEST(Footprint, IsToldBetterThanThePointsLieApart) {
  std::mt19937 random(3);
  std::vector<float> middles;
  std::vector<float> lengths;
  std::vector<float> turns;
  for (int i = 0; i < 60; ++i) {
    const float axis = kPi * (static_cast<float>(i) / 60.F - 0.49F);
    const pc::Footprint truth{{0.2F, -0.1F}, axis, 0.15F, 0.06F};
    const Pixels pixels = pixelsOf(truth, 0.02F, random);
    const auto found = pc::footprintOf(pixels.on, pixels.beside, kPitch);
    ASSERT_TRUE(found);
    middles.push_back((found->middle - truth.middle).norm());
    lengths.push_back(std::abs(found->length - truth.length));
    turns.push_back(std::abs(std::remainder(found->axis_rad - axis, kPi)));
  }
  const auto worst = [](const std::vector<float>& v) { return *std::max_element(v.begin(), v.end()); };
  EXPECT_LT(worst(middles), 0.012F);
  EXPECT_LT(worst(lengths), 0.020F);
  EXPECT_LT(worst(turns), 0.26F);
}

TEST(Footprint, OfOnePointReachesHalfWayToTheNext) {
  const auto found = pc::footprintOf({{0.F, 0.F}}, {{0.02F, 0.F}, {-0.02F, 0.F}, {0.F, 0.02F}, {0.F, -0.02F}}, kPitch);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->length, 0.02F, 0.001F);
  EXPECT_NEAR(found->width, 0.02F, 0.001F);
}

TEST(Footprint, NeedsAPointOnIt) {
  EXPECT_FALSE(pc::footprintOf({}, {{0.F, 0.F}}, kPitch));
}

}  // namespace
}  // namespace yarm::test
