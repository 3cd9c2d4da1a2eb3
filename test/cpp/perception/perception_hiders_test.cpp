// Who hides a cell: held against lines that are sampled finely, and against rendered sets.
#include "scene_factory.hpp"

#include "yarm/perception/association.hpp"
#include "yarm/perception/hiders.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace yarm::test {
namespace {

/// More cells than two bytes number, the same edges.
pc::GridSpec tallGrid() {
  pc::GridSpec spec;
  const double edge = spec.resolution(2);
  spec.size[2] = 30;
  spec.max[2] = spec.min[2] + 30 * edge;
  return spec;
}

/// A grid of objects in random boxes.
pc::OccupancyGrid randomGrid(std::mt19937_64& random, std::size_t objects, const pc::GridSpec& spec = {}) {
  pc::OccupancyGrid grid;
  grid.spec = spec;
  grid.object_cells.resize(objects);
  const auto draw = [&random](int most) { return std::uniform_int_distribution<int>(0, most)(random); };
  for (std::vector<std::int32_t>& cells : grid.object_cells) {
    const pc::Cell low{draw(45), draw(45), draw(16)};
    for (int i = 0; i < 4 * 4 * 3; ++i) {
      cells.push_back(grid.spec.indexOf(pc::Cell{low.x + i % 4, low.y + i / 4 % 4, low.z + i / 16}));
    }
  }
  return grid;
}

/// Everything hidden, behind something from the cameras of `behind`.
pc::SeenCells hidden(const std::vector<Eigen::Vector3d>& cameras, std::uint16_t behind, std::uint16_t unseen,
                     std::size_t count = pc::GridSpec{}.count()) {
  return {cameras, std::vector<pc::CellState>(count, pc::CellState::kHidden), std::vector<std::uint16_t>(count, behind),
          std::vector<std::uint16_t>(count, unseen)};
}

/// Bits of whoever has a cell within `reach` cells of a line, which is sampled every 2 cm.
std::uint32_t oracle(const pc::OccupancyGrid& grid, int from, const Eigen::Vector3d& camera, int reach) {
  const Eigen::Vector3d start = grid.spec.centre(grid.spec.cellOf(from));
  const int samples = static_cast<int>((camera - start).norm() / 0.02);
  std::uint32_t bits = 0;
  for (int k = 0; k < samples; ++k) {
    const Eigen::Vector3d p = start + (camera - start) * k / samples;
    const int index = grid.spec.indexOf(p.x(), p.y(), p.z());
    if (index < 0) {
      break;
    }
    const pc::Cell at = grid.spec.cellOf(index);
    for (std::size_t object = 0; object < grid.object_cells.size(); ++object) {
      for (const std::int32_t cell : grid.object_cells[object]) {
        const pc::Cell c = grid.spec.cellOf(cell);
        const int apart = std::max({std::abs(c.x - at.x), std::abs(c.y - at.y), std::abs(c.z - at.z)});
        bits |= apart <= reach ? 1U << std::min<std::size_t>(object, pc::kNamedHiders) : 0U;
      }
    }
  }
  return bits;
}

TEST(Hiders, AreWhoHasCellsOnTheLinesToTheCamerasOrBesideThem) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    std::mt19937_64 random(seed);
    const pc::OccupancyGrid grid = randomGrid(random, 8, seed < 4 ? pc::GridSpec{} : tallGrid());
    const std::vector<Eigen::Vector3d> cameras{{2.4, 2.4, 2.9}, {-2.5, 0.3, 1.1}};
    pc::HiderFinder finder(grid.spec);
    const pc::SeenCells seen = hidden(cameras, 3, 0, grid.spec.count());
    const std::vector<std::uint32_t>& found = finder.find(grid, seen);
    ASSERT_EQ(found.size(), grid.spec.count());
    int named = 0;
    for (int cell = static_cast<int>(seed); cell < static_cast<int>(found.size()); cell += 503) {
      std::uint32_t least = 0;
      std::uint32_t most = pc::kNoHider;
      const Eigen::Vector3d middle = grid.spec.centre(grid.spec.cellOf(cell));
      for (const Eigen::Vector3d& camera : cameras) {
        least |= oracle(grid, cell, camera, 1);
        most |= oracle(grid, cell, camera, 2) | oracle(grid, cell, 2.0 * middle - camera, 2);
      }
      const std::uint32_t bits = found[static_cast<std::size_t>(cell)];
      EXPECT_EQ(least & ~bits, 0U) << "seed " << seed << ", cell " << cell;
      EXPECT_EQ(bits & ~most, 0U) << "seed " << seed << ", cell " << cell;
      named += (bits & ~pc::kNoHider) != 0 ? 1 : 0;
    }
    EXPECT_GT(named, 10) << "seed " << seed;
  }
}

TEST(Hiders, AFinderThatHasServedOthersSaysTheSameAsANewOne) {
  std::mt19937_64 random(6);
  const std::vector<Eigen::Vector3d> here{{2.4, 2.4, 2.9}, {-2.5, 0.3, 1.1}};
  const std::vector<Eigen::Vector3d> moved{{2.4, 2.4, 2.9}, {-2.5, 0.4, 1.1}};
  pc::HiderFinder finder{pc::GridSpec{}};
  int set = 0;
  for (const auto& cameras : {here, here, moved, moved, here}) {
    const pc::OccupancyGrid grid = randomGrid(random, 8);
    pc::SeenCells seen = hidden(cameras, 3, 0);
    const std::uint64_t every = ++set == 3 ? 1 : 3;  // all cells at once have more on their lines than is kept
    for (pc::CellState& state : seen.states) {       // other cells each time
      state = random() % every == 0 ? state : pc::CellState::kFree;
    }
    pc::HiderFinder another{pc::GridSpec{}};
    EXPECT_EQ(finder.find(grid, seen), another.find(grid, seen));
  }
}

TEST(Hiders, ObjectsFromTheThirtyFirstOnShareABit) {
  std::mt19937_64 random(4);
  const pc::OccupancyGrid grid = randomGrid(random, 33);
  pc::HiderFinder finder(grid.spec);
  const std::vector<std::uint32_t> found = finder.find(grid, hidden({{0.0, 0.0, 3.0}}, 1, 0));
  for (const std::size_t object : {29U, 30U, 32U}) {
    const std::uint32_t bit = object == 29U ? 1U << 29 : pc::kOtherHiders;
    EXPECT_NE(found[static_cast<std::size_t>(grid.object_cells[object].front())] & bit, 0U) << object;
  }
}

TEST(Hiders, ACellThatNobodyHidesIsTold) {
  const pc::OccupancyGrid empty;
  pc::HiderFinder finder(empty.spec);
  const std::vector<Eigen::Vector3d> cameras{{0.0, 0.0, 3.0}, {1.0, 0.0, 3.0}};
  EXPECT_EQ(finder.find(empty, hidden(cameras, 1, 0)).front(), pc::kNoHider);  // what hides it is not on the map
  EXPECT_EQ(finder.find(empty, hidden(cameras, 0, 2)).front(), pc::kNoHider);  // camera 1 says nothing of it
  EXPECT_EQ(finder.find(empty, hidden(cameras, 0, 0)).front(), 0U);            // no camera would see it
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Eigen::Vector3d> one_to_come{cameras[0], {nan, nan, nan}};
  EXPECT_EQ(finder.find(empty, hidden(one_to_come, 0, 0)).front(), pc::kNoHider);  // who knows where camera 1 looks
  std::mt19937_64 random(5);
  const pc::OccupancyGrid grid = randomGrid(random, 1);
  const auto cell = static_cast<std::size_t>(grid.object_cells[0].front());
  EXPECT_EQ(finder.find(grid, hidden(cameras, 1, 0))[cell], 1U);
  EXPECT_EQ(finder.find(grid, hidden(cameras, 1, 2))[cell], 1U | pc::kNoHider);  // camera 1 says nothing of it
}

TEST(Hiders, WhatARobotAndAnUnknownBoxHideInARenderedSetIsPutDownToThem) {
  Scene scene = standardCell(1, 0);
  addBox(scene, "box", {0.5, 0.5, 0.6}, {1.6, -1.6, 0.31}, false);
  SceneFactory factory(9);
  factory.render(scene);
  const pc::MergeParams merge;
  const auto backend = pc::makeBackend("fused", merge, {});
  const auto associator = pc::makeAssociator("yarm", {});
  pc::VisibilityVoter voter(pc::GridSpec{}, merge, {}, 4);
  pc::VisibilityMap map;
  pc::MergedSet set;
  pc::CellVotes votes;
  pc::CellVotes coverage;
  pc::SeenCells seen;
  pc::OccupancyBuilder builder{pc::GridSpec{}};
  const pc::AssociatedSet* associated = nullptr;
  for (pc::StampNs stamp_ns = 1; stamp_ns < 8; ++stamp_ns) {  // until the box is believed
    const std::vector<pc::CameraCloud> clouds = factory.clouds(stamp_ns);
    backend->merge(clouds, set);
    backend->cluster(set);
    voter.vote(clouds, set, votes);
    const auto seeds = scene.seeds(stamp_ns);
    const auto knowledge = scene.knowledge();
    associated = &associator->associate({&set, &seeds, &knowledge, &scene.poses, stamp_ns < 2});
  }
  map.update(votes);
  voter.coverage(coverage);
  map.describe(votes, coverage, seen);
  for (std::size_t camera = 0; camera < 4; ++camera) {
    seen.cameras.push_back(voter.place(camera));
    EXPECT_NEAR(seen.cameras.back().z(), 2.0, 1e-3);
  }
  pc::HiderFinder finder(pc::GridSpec{});
  const std::vector<std::uint32_t>& found = finder.find(builder.build(*associated), seen);
  std::size_t at = 0;
  std::size_t by_nobody = 0;
  std::map<std::string, std::size_t> hides;
  for (std::size_t i = 0; i < seen.states.size(); ++i) {
    if (pc::isSeen(seen.states[i])) {
      continue;
    }
    by_nobody += seen.behind[at] != 0 && seen.unseen[at] == 0 && (found[at] & pc::kNoHider) != 0 ? 1U : 0U;
    for (std::size_t k = 0; k < associated->objects.size(); ++k) {
      hides[associated->objects[k].name] += found[at] >> k & 1U;
    }
    ++at;
  }
  ASSERT_EQ(at, found.size());
  EXPECT_LT(by_nobody, found.size() / 100) << "of " << found.size();
  EXPECT_LT(std::count(found.begin(), found.end(), 0U), 150);  // what no camera covers
  EXPECT_GT(std::count(found.begin(), found.end(), 0U), 50);
  EXPECT_GT(hides["ankurbot_1"], 50U);
  EXPECT_GT(hides[pc::unknownName(1)], 50U);
}

}  // namespace
}  // namespace yarm::test
