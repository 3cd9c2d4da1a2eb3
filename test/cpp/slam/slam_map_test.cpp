// The drawing of scans into an occupancy grid.
#include "slam_world.hpp"
#include "yarm/slam/map_drawer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace yarm::slam {
namespace {

using test::Arena;
using test::Segment;
using Scans = std::vector<std::shared_ptr<const MapScan>>;

ScanParams unbiased() {
  ScanParams params;
  params.bias_slope = 0.0;
  return params;
}

std::shared_ptr<const MapScan> seenFrom(const Arena& arena, const Pose2& pose, int keyframe) {
  return std::make_shared<const MapScan>(toMapScan(test::exactScan(arena, pose), unbiased(), keyframe, Pose2()));
}

int at(const GridMap& map, double x, double y) {
  const int column = static_cast<int>(std::floor((x - map.origin_x) / map.resolution));
  const int row = static_cast<int>(std::floor((y - map.origin_y) / map.resolution));
  if (column < 0 || row < 0 || column >= map.width || row >= map.height) {
    return -1;
  }
  return map.cells[static_cast<std::size_t>(row) * map.width + column];
}

const Segment kWall{{2.02, -3.0}, {2.02, 3.0}};

MapParams eager() {
  MapParams params;
  params.occupied_hits = 0.1;
  return params;
}

TEST(MapDrawerTest, WallOccupiedWayFreeBehindUnknown) {
  const Arena arena(std::vector<Segment>{kWall});
  MapDrawer drawer(eager(), ScanParams());
  const GridMap map = drawer.draw({seenFrom(arena, {}, 0)}, {Pose2()});
  EXPECT_EQ(at(map, 2.02, 0.02), 100);
  EXPECT_EQ(at(map, 2.02, 0.82), 100);
  EXPECT_EQ(at(map, 1.0, 0.02), 0);
  EXPECT_EQ(at(map, 0.02, 0.02), 0);
  EXPECT_EQ(at(map, 2.3, 0.02), -1);
  EXPECT_EQ(at(map, 1.0, 1.2), -1) << "outside the field of view";
}

TEST(MapDrawerTest, NothingSeenClearsNothing) {
  Scan blind = test::exactScan(Arena(std::vector<Segment>{kWall}), {});
  std::fill(blind.ranges.begin(), blind.ranges.end(), std::numeric_limits<float>::quiet_NaN());
  MapDrawer drawer(eager(), ScanParams());
  const GridMap map = drawer.draw({std::make_shared<const MapScan>(toMapScan(blind, ScanParams(), 0, {}))}, {Pose2()});
  EXPECT_TRUE(std::all_of(map.cells.begin(), map.cells.end(), [](int cell) { return cell == -1; }));
}

TEST(MapDrawerTest, RangesBeyondTheLimitClearButDoNotMark) {
  const Arena arena(std::vector<Segment>{{{3.02, -3.0}, {3.02, 3.0}}});
  MapParams params = eager();
  params.max_range = 2.0;
  MapDrawer drawer(params, ScanParams());
  const GridMap map = drawer.draw({seenFrom(arena, {}, 0)}, {Pose2()});
  EXPECT_EQ(at(map, 1.8, 0.02), 0);
  EXPECT_EQ(at(map, 2.5, 0.02), -1);
  EXPECT_EQ(at(map, 3.02, 0.02), -1);
}

TEST(MapDrawerTest, AScanCountsOnceACell) {
  const Arena arena(std::vector<Segment>{{{0.52, -3.0}, {0.52, 3.0}}});  // near: many beams end in one cell
  MapParams params;
  params.occupied_hits = 2.0;
  MapDrawer drawer(params, ScanParams());
  Scans scans{seenFrom(arena, {}, 0)};
  EXPECT_EQ(at(drawer.draw(scans, {Pose2()}), 0.52, 0.02), -1) << "one scan is one mark: too little";
  for (int i = 0; i < 3; ++i) {
    scans.push_back(seenFrom(arena, {}, 0));
  }
  EXPECT_EQ(at(drawer.draw(scans, {Pose2()}), 0.52, 0.02), 100);
}

TEST(MapDrawerTest, UnprovedScansAreShownAndLeaveNothingBehind) {
  const Arena arena(std::vector<Segment>{kWall});
  const Scans proved{seenFrom(arena, {}, 0)};
  const Scans unproved{
      std::make_shared<const MapScan>(toMapScan(test::exactScan(arena, {}), unbiased(), 0, Pose2{-0.5, 0.0, 0.0}))};
  MapDrawer drawer(eager(), ScanParams());
  EXPECT_EQ(at(drawer.draw(proved, {Pose2()}, unproved), 1.52, 0.02), 100);
  MapDrawer fresh(eager(), ScanParams());
  const GridMap after = drawer.draw(proved, {Pose2()});
  const GridMap expected = fresh.draw(proved, {Pose2()});
  EXPECT_EQ(at(after, 1.52, 0.02), 0);
  EXPECT_EQ(at(after, 2.02, 0.02), 100);
  EXPECT_TRUE(after.cells == expected.cells);
}

TEST(MapDrawerTest, AKeyframeThatMovesTakesItsMarksAlong) {
  const Arena arena(std::vector<Segment>{kWall});
  const Scans scans{seenFrom(arena, {}, 0), seenFrom(arena, {}, 1)};
  MapDrawer moved(eager(), ScanParams());
  (void)moved.draw(scans, {Pose2(), Pose2{0.3, 0.2, 0.1}});
  const GridMap after = moved.draw(scans, {Pose2(), Pose2{-0.5, 0.0, 0.0}});
  MapDrawer fresh(eager(), ScanParams());
  const GridMap expected = fresh.draw(scans, {Pose2(), Pose2{-0.5, 0.0, 0.0}});
  EXPECT_EQ(after.width, expected.width);
  EXPECT_EQ(after.height, expected.height);
  EXPECT_EQ(after.origin_x, expected.origin_x);
  EXPECT_TRUE(after.cells == expected.cells) << "nothing may stay behind where the keyframe was";
}

TEST(MapDrawerTest, TheMapReachesAtLeastItsLimits) {
  MapParams params = eager();
  params.x_min = -1.0;
  params.y_min = -0.5;
  params.x_max = params.y_max = 1.0;
  MapDrawer drawer(params, ScanParams());
  const GridMap map = drawer.draw({}, {});
  EXPECT_EQ(map.width, 40);
  EXPECT_EQ(map.height, 30);
  EXPECT_NEAR(map.origin_x, -1.0, 1e-9);
  EXPECT_NEAR(map.origin_y, -0.5, 1e-9);
  const Arena arena(std::vector<Segment>{kWall});
  const GridMap grown = drawer.draw({seenFrom(arena, {}, 0)}, {Pose2()});
  EXPECT_GT(grown.width, 40);
}

TEST(MapDrawerTest, APoseFarAwayDoesNotEatTheMemory) {
  const Arena arena(std::vector<Segment>{kWall});
  MapDrawer drawer(eager(), ScanParams());
  const Scans scans{seenFrom(arena, {}, 0), seenFrom(arena, {}, 1)};
  const GridMap map = drawer.draw(scans, {Pose2(), Pose2{5000.0, 5000.0, 0.0}});
  EXPECT_EQ(at(map, 2.02, 0.02), 100);
  EXPECT_LT(map.cells.size(), 16'000'000U);
}

}  // namespace
}  // namespace yarm::slam
