// Camera sets by capture time: order, tolerance, silence and return, lost and late clouds, restart.
#include "yarm/sync/set_assembler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
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

// Cameras 0 to `sending` - 1 send a set every 100 ms, stamps 33 ms apart, for a second.
void sendForASecond(SetAssembler<int>& sets, std::size_t sending) {
  for (int frame = 0; frame <= 10; ++frame) {
    for (std::size_t camera = 0; camera < sending; ++camera) {
      sets.add(camera, (100 + 33 * frame) * kMs, 100 * frame * kMs, 1);
    }
    while (sets.take(100 * frame * kMs)) {
    }
  }
}

TEST(SetAssembler, aPauseOfAllCamerasIsNobodysSilence) {
  SetAssembler<int> sets(options(3));
  sendForASecond(sets, 2);  // camera 2 is never heard
  EXPECT_TRUE(sets.isSilent(1, 5000 * kMs));
  sets.add(0, 600 * kMs, 5000 * kMs, 1);
  EXPECT_FALSE(sets.isSilent(1, 5000 * kMs));
  EXPECT_TRUE(sets.isSilent(2, 5000 * kMs));
  EXPECT_FALSE(sets.take(5000 * kMs));
  sets.add(1, 600 * kMs, 5003 * kMs, 1);
  const auto set = sets.take(5003 * kMs);
  ASSERT_TRUE(set);
  EXPECT_EQ(present(*set), (std::vector<bool>{true, true, false}));
}

TEST(SetAssembler, aPauseAsLongAsTheTimeoutTakesNobodyOutOfTheNextSet) {
  const std::int64_t timeout_ms = options(3).timeout_ns / kMs;
  for (std::int64_t pause_ms = timeout_ms / 2; pause_ms <= timeout_ms; pause_ms += timeout_ms / 20) {
    SetAssembler<int> sets(options(3));
    for (std::size_t camera = 0; camera < 3; ++camera) {
      sets.add(camera, 100 * kMs, 0, 1);
    }
    ASSERT_TRUE(sets.take(0));
    sets.add(0, 200 * kMs, pause_ms * kMs, 1);
    sets.add(1, 200 * kMs, (pause_ms + 1) * kMs, 1);
    EXPECT_FALSE(sets.take((pause_ms + timeout_ms / 4) * kMs)) << pause_ms;
    EXPECT_TRUE(sets.take((pause_ms + timeout_ms) * kMs)) << pause_ms;
  }
}

TEST(SetAssembler, camerasThatAreSlowStillTellWhoIsSilent) {
  SetAssembler<int> sets(options(2));
  const std::int64_t gap_ms = options(2).timeout_ns / kMs * 3 / 4;
  sets.add(1, 100 * kMs, 0, 1);
  for (std::int64_t round = 0; round < 4; ++round) {
    sets.add(0, (100 + round * gap_ms) * kMs, round * gap_ms * kMs, 1);
  }
  EXPECT_FALSE(sets.isSilent(0, 3 * gap_ms * kMs));
  EXPECT_TRUE(sets.isSilent(1, 3 * gap_ms * kMs));
}

TEST(SetAssembler, aCloudWhoseStampWentBackEndsNoPause) {
  SetAssembler<int> sets(options(2));
  sendForASecond(sets, 2);
  const std::int64_t timeout_ms = options(2).timeout_ns / kMs;
  EXPECT_EQ(sets.add(0, 100 * kMs, (1000 + timeout_ms / 2) * kMs, 1), Admission::backwards);
  const std::int64_t again_ms = 1000 + timeout_ms + 10;
  sets.add(0, 600 * kMs, again_ms * kMs, 1);
  EXPECT_FALSE(sets.isSilent(1, again_ms * kMs));
  EXPECT_FALSE(sets.take(again_ms * kMs));
}

TEST(SetAssembler, aSilentCameraIsGivenItsGrace) {
  SetAssemblerOptions patient = options(2);
  patient.silent_grace_ns = 20 * kMs;
  SetAssembler<int> sets(patient);
  sendForASecond(sets, 1);
  sets.take(1050 * kMs);
  sets.add(0, 600 * kMs, 1100 * kMs, 1);
  EXPECT_FALSE(sets.take(1110 * kMs));
  EXPECT_TRUE(sets.take(1120 * kMs));
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

// Whatever is lost or late: sets leave in order, no cloud leaves twice, nearly every accepted one leaves, nothing waits
// for ever.
TEST(SetAssembler, acceptedCloudsLeaveOnceAndInOrder) {
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
    EXPECT_LE(left, accepted) << "seed " << seed;
    EXPECT_GE(left + 2 * cameras, accepted) << "seed " << seed;  // the period is learnt from the first few
    EXPECT_EQ(sets.pending(), 0U);
    EXPECT_GT(accepted, arrivals.size() / 2);
  }
}

struct Cloud {
  std::int64_t arrives_ns;
  std::size_t camera;
  std::int64_t stamp_ns;
  bool operator<(const Cloud& other) const { return arrives_ns < other.arrives_ns; }
};

constexpr std::int64_t kPeriod = 33'333'333;

// Clouds of cameras that run at one rate with these phases; jitter of each stamp, +- ns, and delay of up to 8 ms.
std::vector<Cloud> freeRunning(const std::vector<std::int64_t>& phases_ns, std::int64_t jitter_ns, int frames,
                               std::mt19937& random) {
  std::uniform_int_distribution<std::int64_t> jitter(-jitter_ns, jitter_ns);
  std::uniform_int_distribution<std::int64_t> delay(kMs, 8 * kMs);
  std::vector<Cloud> clouds;
  for (int frame = 0; frame < frames; ++frame) {
    for (std::size_t camera = 0; camera < phases_ns.size(); ++camera) {
      const std::int64_t stamp_ns = 1000 * kMs + frame * kPeriod + phases_ns[camera] + jitter(random);
      clouds.push_back({stamp_ns + delay(random), camera, stamp_ns});
    }
  }
  std::sort(clouds.begin(), clouds.end());
  return clouds;
}

struct Outcome {
  int sets = 0;
  int complete = 0;
  std::int64_t widest_ns = 0;
};

// Runs the default assembler over the clouds and looks at the sets after the first ten periods.
Outcome assemble(const std::vector<Cloud>& clouds, std::size_t cameras) {
  SetAssemblerOptions defaults;
  defaults.cameras = cameras;
  SetAssembler<std::int64_t> sets(defaults);
  Outcome outcome;
  std::int64_t previous_ns = 0;
  std::map<std::size_t, std::int64_t> last_used;
  for (const Cloud& cloud : clouds) {
    sets.add(cloud.camera, cloud.stamp_ns, cloud.arrives_ns, cloud.stamp_ns);
    while (const auto set = sets.take(cloud.arrives_ns)) {
      EXPECT_GT(set->stamp_ns, previous_ns);
      previous_ns = set->stamp_ns;
      std::int64_t oldest = std::numeric_limits<std::int64_t>::max();
      std::int64_t newest = 0;
      std::size_t there = 0;
      for (std::size_t camera = 0; camera < cameras; ++camera) {
        if (set->items[camera]) {
          EXPECT_GT(*set->items[camera], last_used[camera]) << "a cloud left twice";
          last_used[camera] = *set->items[camera];
          oldest = std::min(oldest, *set->items[camera]);
          newest = std::max(newest, *set->items[camera]);
          ++there;
        }
      }
      EXPECT_EQ(set->stamp_ns, oldest);
      if (set->stamp_ns > clouds.front().stamp_ns + 10 * kPeriod) {
        ++outcome.sets;
        outcome.complete += there == cameras ? 1 : 0;
        outcome.widest_ns = std::max(outcome.widest_ns, newest - oldest);
      }
    }
  }
  return outcome;
}

TEST(FreeRunningCameras, fourPhasesGiveOneCompleteSetAPeriod) {
  std::mt19937 random(1);
  const Outcome outcome = assemble(freeRunning({0, 5 * kMs, 17 * kMs, 25 * kMs}, 0, 100, random), 4);
  EXPECT_NEAR(outcome.sets, 89, 1);
  EXPECT_EQ(outcome.complete, outcome.sets);
  EXPECT_LE(outcome.widest_ns, kPeriod);
}

// A hundred cells of cameras with random phases and a jitter of up to 2 ms.
TEST(FreeRunningCameras, anyPhasesAndJitterGiveCompleteSetsAtTheirRate) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    const std::size_t cameras = 1 + random() % 6;
    std::vector<std::int64_t> phases_ns;
    for (std::size_t camera = 0; camera < cameras; ++camera) {
      phases_ns.push_back(static_cast<std::int64_t>(random() % kPeriod));
    }
    const std::int64_t jitter_ns = static_cast<std::int64_t>(random() % 3) * kMs;
    const Outcome outcome = assemble(freeRunning(phases_ns, jitter_ns, 300, random), cameras);
    EXPECT_NEAR(outcome.sets, 289, 9) << "seed " << seed;
    EXPECT_GE(outcome.complete, outcome.sets * 97 / 100) << "seed " << seed;
    EXPECT_LE(outcome.widest_ns, kPeriod * 5 / 4) << "seed " << seed;
  }
}

// Clocks that drift apart slide through every phase.
TEST(FreeRunningCameras, driftingClocksLoseAlmostNoSet) {
  std::vector<Cloud> clouds;
  for (std::int64_t frame = 0; frame < 3000; ++frame) {
    const std::int64_t steady_ns = 1000 * kMs + frame * kPeriod;
    const std::int64_t drifting_ns = 1000 * kMs + frame * 33'300'000;
    clouds.push_back({steady_ns + kMs, 0, steady_ns});
    clouds.push_back({drifting_ns + 2 * kMs, 1, drifting_ns});
  }
  std::sort(clouds.begin(), clouds.end());
  const Outcome outcome = assemble(clouds, 2);
  EXPECT_NEAR(outcome.sets, 2989, 15);
  EXPECT_GE(outcome.complete, outcome.sets - 10);
}

TEST(FreeRunningCameras, aLostCloudIsMissingOnceAndShiftsNothing) {
  std::mt19937 random(1);
  std::vector<Cloud> clouds = freeRunning({0, 9 * kMs, 20 * kMs}, 0, 60, random);
  const auto lost = std::find_if(clouds.begin(), clouds.end(),
                                 [](const Cloud& cloud) { return cloud.camera == 1 && cloud.stamp_ns > 2000 * kMs; });
  clouds.erase(lost);
  const Outcome outcome = assemble(clouds, 3);
  EXPECT_NEAR(outcome.sets, 49, 1);
  EXPECT_EQ(outcome.complete, outcome.sets - 1);
}

// Synchronised cameras whose trigger jitters: one set a trigger, none torn apart, whatever the order of arrival.
TEST(SynchronisedCameras, aTriggerThatJittersGivesOneSetEach) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    std::vector<Cloud> clouds;
    for (int frame = 0; frame < 200; ++frame) {
      const std::int64_t stamp_ns = 1000 * kMs + frame * kPeriod + static_cast<std::int64_t>(random() % 9) * kMs;
      for (std::size_t camera = 0; camera < 4; ++camera) {
        clouds.push_back({stamp_ns + static_cast<std::int64_t>(random() % 8) * kMs, camera, stamp_ns});
      }
    }
    std::stable_sort(clouds.begin(), clouds.end());
    const Outcome outcome = assemble(clouds, 4);
    EXPECT_NEAR(outcome.sets, 189, 1) << "seed " << seed;
    EXPECT_EQ(outcome.complete, outcome.sets) << "seed " << seed;
    EXPECT_EQ(outcome.widest_ns, 0) << "seed " << seed;
  }
}

TEST(SynchronisedCameras, lockStepKeepsToTheTolerance) {
  SetAssemblerOptions strict = options(2);
  strict.free_running = false;
  SetAssembler<int> sets(strict);
  for (int frame = 0; frame < 20; ++frame) {
    sets.add(0, (1000 + 33 * frame) * kMs, frame, 0);
    sets.add(1, (1016 + 33 * frame) * kMs, frame, 0);
    const auto set = sets.take(frame);
    ASSERT_TRUE(set);
    EXPECT_NE(set->items[0].has_value(), set->items[1].has_value());
  }
}

}  // namespace
