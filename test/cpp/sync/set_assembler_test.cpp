// Camera sets by capture time: order, tolerance, silence and return, lost and late clouds, restart.
#include "yarm/ros/set_assembler.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace {

using yarm::Admission;
using yarm::CameraSet;
using yarm::SetAssembler;
using yarm::SetAssemblerOptions;

constexpr std::int64_t kMs = 1'000'000;

SetAssemblerOptions options(std::size_t cameras) {
  SetAssemblerOptions made;
  made.cameras = cameras;
  made.tolerance_ns = 5 * kMs;
  made.timeout_ns = 200 * kMs;
  return made;
}

std::vector<bool> present(const CameraSet<int>& set) {
  std::vector<bool> made;
  for (const auto& item : set.items) {
    made.push_back(item.has_value());
  }
  return made;
}

TEST(SetAssembler, aSetLeavesWithItsLastCloud) {
  SetAssembler<int> sets(options(3));
  sets.add(0, 100 * kMs, 0, 10);
  sets.add(2, 102 * kMs, 1, 12);
  EXPECT_FALSE(sets.take(1));
  sets.add(1, 98 * kMs, 2, 11);
  const auto set = sets.take(2);
  ASSERT_TRUE(set);
  EXPECT_EQ(set->stamp_ns, 98 * kMs);
  EXPECT_EQ(*set->items[0], 10);
  EXPECT_EQ(*set->items[1], 11);
  EXPECT_EQ(*set->items[2], 12);
  EXPECT_FALSE(sets.take(2));
}

TEST(SetAssembler, stampsFurtherApartAreTwoSets) {
  SetAssembler<int> sets(options(2));
  sets.add(0, 100 * kMs, 0, 1);
  sets.add(1, 133 * kMs, 0, 2);
  const auto first = sets.take(0);  // camera 1 has sent a newer stamp: it has nothing for 100
  ASSERT_TRUE(first);
  EXPECT_EQ(first->stamp_ns, 100 * kMs);
  EXPECT_EQ(present(*first), (std::vector<bool>{true, false}));
  EXPECT_FALSE(sets.take(0));
  sets.add(0, 133 * kMs, 0, 3);
  ASSERT_TRUE(sets.take(0));
}

TEST(SetAssembler, aSilentCameraHoldsUpOneSetThenNone) {
  SetAssembler<int> sets(options(2));
  sets.add(0, 100 * kMs, 0, 1);
  sets.add(1, 100 * kMs, 0, 1);
  ASSERT_TRUE(sets.take(0));
  sets.add(0, 133 * kMs, 33 * kMs, 1);
  EXPECT_FALSE(sets.take(150 * kMs));
  EXPECT_FALSE(sets.isSilent(1, 150 * kMs));
  ASSERT_TRUE(sets.take(201 * kMs));
  EXPECT_TRUE(sets.isSilent(1, 201 * kMs));
  sets.add(0, 166 * kMs, 210 * kMs, 1);
  ASSERT_TRUE(sets.take(210 * kMs));  // no more waiting
}

TEST(SetAssembler, aCameraComesBackByItself) {
  SetAssembler<int> sets(options(2));
  sets.add(0, 100 * kMs, 0, 1);
  sets.take(500 * kMs);
  EXPECT_EQ(sets.add(1, 100 * kMs, 510 * kMs, 1), Admission::late);
  EXPECT_FALSE(sets.isSilent(1, 510 * kMs));
  sets.add(0, 133 * kMs, 520 * kMs, 1);
  EXPECT_FALSE(sets.take(520 * kMs));  // it is waited for again
  EXPECT_EQ(sets.add(1, 133 * kMs, 525 * kMs, 1), Admission::accepted);
  const auto set = sets.take(525 * kMs);
  ASSERT_TRUE(set);
  EXPECT_EQ(present(*set), (std::vector<bool>{true, true}));
}

TEST(SetAssembler, aSilentCameraIsGivenItsGrace) {
  SetAssemblerOptions patient = options(2);
  patient.silent_grace_ns = 20 * kMs;
  SetAssembler<int> sets(patient);
  sets.add(0, 100 * kMs, 0, 1);
  sets.take(500 * kMs);
  sets.add(0, 133 * kMs, 500 * kMs, 1);
  EXPECT_FALSE(sets.take(510 * kMs));
  EXPECT_TRUE(sets.take(520 * kMs));
}

TEST(SetAssembler, aSkippedCloudIsNotWaitedFor) {
  SetAssembler<int> sets(options(2));
  sets.add(0, 100 * kMs, 0, 1);
  sets.skip(1, 100 * kMs, 0);
  const auto set = sets.take(0);
  ASSERT_TRUE(set);
  EXPECT_EQ(present(*set), (std::vector<bool>{true, false}));
}

TEST(SetAssembler, aStampThatDoesNotGrowIsRefused) {
  SetAssembler<int> sets(options(1));
  EXPECT_EQ(sets.add(0, 100 * kMs, 0, 1), Admission::accepted);
  EXPECT_EQ(sets.add(0, 100 * kMs, 0, 2), Admission::backwards);
  EXPECT_EQ(sets.add(0, 50 * kMs, 0, 3), Admission::backwards);
  sets.reset();
  EXPECT_EQ(sets.add(0, 50 * kMs, 0, 4), Admission::accepted);
}

TEST(SetAssembler, twoCloudsOfOneCameraNeverShareASet) {
  SetAssembler<int> sets(options(2));
  sets.add(0, 100 * kMs, 0, 1);
  sets.add(0, 103 * kMs, 0, 2);
  EXPECT_EQ(sets.pending(), 2U);
}

TEST(SetAssembler, theHeapOfWaitingSetsIsBounded) {
  SetAssemblerOptions small = options(2);
  small.max_pending = 3;
  small.timeout_ns = 1'000'000 * kMs;
  SetAssembler<int> sets(small);
  int left = 0;
  for (int i = 0; i < 10; ++i) {
    sets.add(0, (100 + 33 * i) * kMs, i, i);
    left += sets.take(i) ? 1 : 0;
  }
  EXPECT_EQ(left, 7);
  EXPECT_EQ(sets.pending(), 3U);
}

// Whatever is lost, late or out of step: every accepted cloud leaves once, sets leave in order, nothing waits for ever.
TEST(SetAssembler, everyAcceptedCloudLeavesOnceAndInOrder) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    const std::size_t cameras = 1 + random() % 5;
    SetAssembler<int> sets(options(cameras));
    std::multimap<std::int64_t, std::pair<std::size_t, std::int64_t>> arrivals;  // wall -> camera, stamp
    for (std::int64_t frame = 0; frame < 40; ++frame) {
      for (std::size_t camera = 0; camera < cameras; ++camera) {
        if (random() % 10 != 0) {
          const std::int64_t stamp = (100 + 33 * frame) * kMs + static_cast<std::int64_t>(random() % 3) * kMs;
          const std::int64_t delay = static_cast<std::int64_t>(random() % (random() % 20 == 0 ? 300 : 20)) * kMs;
          arrivals.emplace(stamp + delay, std::make_pair(camera, stamp));
        }
      }
    }
    std::size_t accepted = 0;
    std::size_t left = 0;
    std::int64_t previous = 0;
    std::int64_t wall = 0;
    const auto drain = [&] {
      while (const auto set = sets.take(wall)) {
        EXPECT_GT(set->stamp_ns, previous);
        previous = set->stamp_ns;
        for (const auto& item : set->items) {
          left += item ? 1U : 0U;
        }
      }
    };
    for (const auto& [at, cloud] : arrivals) {
      wall = at;
      accepted += sets.add(cloud.first, cloud.second, wall, 0) == Admission::accepted ? 1U : 0U;
      drain();
    }
    wall += 1000 * kMs;
    drain();
    EXPECT_EQ(left, accepted) << "seed " << seed;
    EXPECT_EQ(sets.pending(), 0U);
    EXPECT_GT(accepted, arrivals.size() / 2);
  }
}

}  // namespace
