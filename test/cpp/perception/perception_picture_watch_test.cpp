// A picture that stays the same is frozen; a hole that stays is a spot; nothing else is either.
#include "yarm/perception/picture_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace yarm::test {
namespace {

namespace pc = yarm::perception;

constexpr std::size_t kWidth = 320;
constexpr std::size_t kHeight = 240;
constexpr pc::StampNs kPeriodNs = 33'000'000;

/// A camera's depths with noise, 16 bytes a point.
class Lens {
 public:
  explicit Lens(std::uint32_t seed) : random_(seed), points_(4 * kWidth * kHeight, 0.F) { expose(); }

  void expose() {
    std::normal_distribution<float> noise(3.F, 0.01F);
    for (std::size_t i = 0; i < kWidth * kHeight; ++i) {
      points_[4 * i + 2] = noise(random_);
    }
  }
  /// Gives a square of the image another depth.
  void cover(std::size_t u0, std::size_t v0, std::size_t edge, float depth) {
    for (std::size_t v = v0; v < v0 + edge; ++v) {
      for (std::size_t u = u0; u < u0 + edge; ++u) {
        points_[4 * (v * kWidth + u) + 2] = depth;
      }
    }
  }
  [[nodiscard]] pc::CameraCloud cloud(pc::StampNs stamp_ns) const {
    pc::CameraCloud made;
    made.data = reinterpret_cast<const std::uint8_t*>(points_.data());
    made.width = kWidth;
    made.height = kHeight;
    made.stamp_ns = stamp_ns;
    return made;
  }

 private:
  std::mt19937 random_;
  std::vector<float> points_;
};

pc::PictureWatchParams watching() {
  pc::PictureWatchParams params;
  params.frozen_after = 0.5;
  params.spot_after = 2.0;
  return params;
}

TEST(PictureWatch, NoiseKeepsAPictureAlive) {
  pc::PictureWatch watch(watching(), 1);
  Lens lens(1);
  for (int k = 0; k < 200; ++k) {
    lens.expose();
    const pc::Picture found = watch.judge(0, lens.cloud(k * kPeriodNs));
    EXPECT_FALSE(found.frozen);
    EXPECT_EQ(found.covered, 0.0);
  }
}

TEST(PictureWatch, TheSameBytesWithNewStampsAreFrozenUntilTheyChange) {
  pc::PictureWatch watch(watching(), 2);
  Lens lens(2);
  int frozen = 0;
  for (int k = 0; k < 30; ++k) {
    const pc::Picture found = watch.judge(1, lens.cloud(k * kPeriodNs));
    frozen += found.frozen ? 1 : 0;
    EXPECT_EQ(found.frozen, k * kPeriodNs >= 500'000'000) << k;
  }
  EXPECT_GT(frozen, 10);
  EXPECT_FALSE(watch.judge(0, lens.cloud(30 * kPeriodNs)).frozen) << "the other camera has its own";
  lens.expose();
  EXPECT_FALSE(watch.judge(1, lens.cloud(30 * kPeriodNs)).frozen);
}

TEST(PictureWatch, NothingIsFrozenUnlessAsked) {
  pc::PictureWatch watch({}, 1);
  const Lens lens(3);
  for (int k = 0; k < 100; ++k) {
    EXPECT_FALSE(watch.judge(0, lens.cloud(k * kPeriodNs)).frozen);
  }
}

/// The last picture of a lens that is clean for three seconds and then has a square of another depth.
pc::Picture afterASpot(float depth, int clouds) {
  pc::PictureWatch watch(watching(), 1);
  Lens lens(4);
  pc::Picture found;
  for (int k = 0; k < 90 + clouds; ++k) {
    lens.expose();
    if (k >= 90) {
      lens.cover(144, 96, 48, depth);
    }
    found = watch.judge(0, lens.cloud(k * kPeriodNs));
  }
  return found;
}

TEST(PictureWatch, AHoleThatStaysIsASpotWhereItIs) {
  for (const float depth : {std::numeric_limits<float>::quiet_NaN(), 0.05F}) {
    EXPECT_EQ(afterASpot(depth, 50).covered, 0.0) << "not for so long yet";
    const pc::Picture found = afterASpot(depth, 80);
    EXPECT_NEAR(found.covered, 48.0 * 48.0 / (kWidth * kHeight), 1e-6);
    EXPECT_NEAR(found.u, 168, 1);
    EXPECT_NEAR(found.v, 120, 1);
    EXPECT_FALSE(found.frozen);
  }
}

TEST(PictureWatch, SomethingNearerThatIsSeenIsNoSpot) {
  EXPECT_EQ(afterASpot(1.0F, 120).covered, 0.0);
}

TEST(PictureWatch, WhatNeverHadReadingsIsNoSpot) {
  pc::PictureWatch watch(watching(), 1);
  Lens lens(5);
  for (int k = 0; k < 200; ++k) {
    lens.expose();
    lens.cover(0, 0, 100, std::numeric_limits<float>::quiet_NaN());
    EXPECT_EQ(watch.judge(0, lens.cloud(k * kPeriodNs)).covered, 0.0);
  }
}

TEST(PictureWatch, AfterARestartNothingIsKnown) {
  pc::PictureWatch watch(watching(), 1);
  const Lens lens(6);
  for (int k = 0; k < 30; ++k) {
    watch.judge(0, lens.cloud(k * kPeriodNs));
  }
  watch.reset();
  EXPECT_FALSE(watch.judge(0, lens.cloud(31 * kPeriodNs)).frozen);
}

}  // namespace
}  // namespace yarm::test
