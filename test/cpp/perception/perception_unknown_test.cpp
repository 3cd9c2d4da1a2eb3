// Things nobody registered, when cameras are away and when perception is told wrong poses for a while.
#include "scene_factory.hpp"
#include "unknown_tracker.hpp"

#include "yarm/perception/association.hpp"
#include "yarm/perception/merge.hpp"
#include "yarm/perception/occupancy.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace yarm::test {
namespace {

/// Merge, association and grid; what is seen and what is told are given apart.
class Cell {
 public:
  explicit Cell(std::uint64_t seed) : factory_(seed) {}

  void step(const Scene& true_scene, const Scene& told, const pc::Knowledge& knowledge, bool calibrating) {
    stamp_ += 33'333'333;
    factory_.render(true_scene);
    backend_->merge(factory_.clouds(stamp_), set_);
    const auto seeds = told.seeds(stamp_);
    result_ = &associator_->associate({&set_, &seeds, &knowledge, &told.poses, calibrating});
    grid_ = &builder_.build(*result_);
  }

  /// Cells of all unknown things.
  [[nodiscard]] int unknownCells() const {
    int cells = 0;
    for (std::size_t i = 0; i < result_->objects.size(); ++i) {
      const bool unknown = result_->objects[i].is_unknown;
      cells += unknown ? static_cast<int>(grid_->object_cells[i].size()) : 0;
    }
    return cells;
  }

 private:
  SceneFactory factory_;
  std::unique_ptr<pc::MergeBackend> backend_ = pc::makeBackend("fused", {}, {});
  std::unique_ptr<pc::Associator> associator_ = pc::makeAssociator("yarm", {});
  pc::OccupancyBuilder builder_{pc::GridSpec{}};
  pc::MergedSet set_;
  pc::StampNs stamp_{0};
  const pc::AssociatedSet* result_{nullptr};
  const pc::OccupancyGrid* grid_{nullptr};
};

/// The cell with robot 1 told to be elsewhere.
Scene misled(const Scene& scene, double by_x, double by_y) {
  Scene told = scene;
  for (const std::string& frame : scene.bodies[static_cast<std::size_t>(scene.indexOf("ankurbot_1"))].link_frames) {
    told.poses[frame] = Eigen::Translation3d(by_x, by_y, 0.0) * told.poses[frame];
  }
  const Body& robot = scene.bodies[static_cast<std::size_t>(scene.indexOf("ankurbot_1"))];
  if (std::find(robot.link_frames.begin(), robot.link_frames.end(), robot.seed_frame) == robot.link_frames.end()) {
    told.poses[robot.seed_frame] = Eigen::Translation3d(by_x, by_y, 0.0) * told.poses[robot.seed_frame];
  }
  return told;
}

TEST(WrongPoses, AreForgottenWithinASecond) {
  constexpr double kShrunk = 0.04;  // so that some of the robot is always beside its known shape
  for (const double off : {0.1, 0.5}) {
    const Scene scene = standardCell(2, 1);
    pc::Knowledge knowledge = scene.knowledge();
    for (pc::Solid& solid : knowledge["ankurbot_1"].solids) {
      solid.size -= Eigen::Vector3d::Constant(kShrunk).cwiseMin(0.5 * solid.size);
    }
    Cell cell(7);
    for (int k = 0; k < 5; ++k) {
      cell.step(scene, scene, knowledge, true);
    }
    int before = 0;
    for (int k = 0; k < 10; ++k) {
      cell.step(scene, scene, knowledge, false);
      before = std::max(before, cell.unknownCells());
    }
    for (int k = 0; k < 90; ++k) {
      cell.step(scene, misled(scene, off, off), knowledge, false);
    }
    const int during = cell.unknownCells();
    int after = 0;
    for (int k = 0; k < 20; ++k) {
      cell.step(scene, scene, knowledge, false);
      after = k < 10 ? 0 : std::max(after, cell.unknownCells());
    }
    EXPECT_GT(during, 100);
    EXPECT_LE(after, before) << "off by " << off << " m, shapes told " << kShrunk << " m too small";
  }
}

/// Points of a box's top as a camera sees them, shifted along x.
void addPoints(std::vector<pc::MergedPoint>& points, int camera, float x, int count) {
  for (int i = 0; i < count; ++i) {
    pc::MergedPoint p;
    p.x = x + 0.02F * static_cast<float>(i % 10);
    p.y = 0.02F * static_cast<float>(i / 10);
    p.z = 0.5F;
    p.camera = camera;
    points.push_back(p);
  }
}

/// Feeds a tracker with one group of all points of a set.
class Tracking {
 public:
  /// x of each camera's points; a camera that is not named shows nothing.
  void step(const std::map<int, float>& seen, const std::vector<std::int32_t>& absent, int count = 30) {
    std::vector<pc::MergedPoint> points;
    for (const auto& [camera, x] : seen) {
      addPoints(points, camera, x, count);
    }
    std::vector<std::vector<std::uint32_t>> groups(points.empty() ? 0 : 1);
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      groups[0].push_back(i);
    }
    tracker_.update(points, groups, absent);
  }
  [[nodiscard]] std::size_t points() const {
    std::size_t sum = 0;
    for (const pc::UnknownThing* thing : tracker_.believed()) {
      sum += thing->points.size();
    }
    return sum;
  }

 private:
  pc::UnknownTracker tracker_{pc::AssociationParams{}};
};

TEST(AbsentCameras, WhatOnlyTheyHaveSeenStays) {
  Tracking cell;
  for (int set = 0; set < 5; ++set) {
    cell.step({{2, 0.F}}, {});
  }
  for (int set = 0; set < 1000; ++set) {
    cell.step({}, {2});
    ASSERT_EQ(cell.points(), 30U) << set;
  }
  for (int set = 0; set < 3; ++set) {
    cell.step({}, {});  // it looks again, and nothing is there
  }
  EXPECT_EQ(cell.points(), 0U);
}

TEST(AbsentCameras, TheirShareOfAThingStaysUntilTheyLookAgain) {
  Tracking cell;
  for (int set = 0; set < 5; ++set) {
    cell.step({{1, 0.F}, {2, 0.1F}}, {});
  }
  cell.step({{1, 0.F}}, {2});
  EXPECT_EQ(cell.points(), 60U);
  cell.step({{1, 0.F}}, {});
  EXPECT_EQ(cell.points(), 30U);
}

TEST(AbsentCameras, AThingThatMovesOffLeavesTheirShareBehind) {
  Tracking cell;
  for (int set = 0; set < 5; ++set) {
    cell.step({{1, 0.F}, {2, 0.F}}, {});
  }
  for (int set = 1; set < 20; ++set) {
    cell.step({{1, 0.05F * static_cast<float>(set)}}, {2});
  }
  EXPECT_EQ(cell.points(), 30U);
}

TEST(AbsentCameras, OthersThatSawMostOfItAndSeeNothingNowDecide) {
  Tracking cell;
  for (int set = 0; set < 5; ++set) {
    cell.step({{0, 0.F}, {1, 0.F}, {2, 0.F}}, {});
  }
  for (int set = 0; set < 3; ++set) {
    cell.step({}, {2});
  }
  EXPECT_EQ(cell.points(), 0U);
}

TEST(AbsentCameras, NoiseInTheirLastSetIsNotKept) {
  Tracking cell;
  cell.step({{2, 0.F}}, {});
  for (int set = 0; set < 5; ++set) {
    cell.step({}, {2});
    EXPECT_EQ(cell.points(), 0U);
  }
}

/// Shows scenes to a chain, told as they are; the cells of all unknown things after the last of some sets.
int unknownAfter(Cell& cell, const Scene& scene, int sets) {
  for (int set = 0; set < sets; ++set) {
    cell.step(scene, scene, scene.knowledge(), false);
  }
  return cell.unknownCells();
}

TEST(HiddenThings, StayOnTheMapUntilTheirPlaceIsSeenToBeFree) {
  const Scene empty = standardCell(1, 0);
  Cell cell(7);
  for (int set = 0; set < 5; ++set) {
    cell.step(empty, empty, empty.knowledge(), true);
  }
  Scene box = empty;
  addBox(box, "box", {0.3, 0.3, 0.4}, {1.2, 0.0, 0.2}, false);
  const int seen = unknownAfter(cell, box, 5);
  ASSERT_GT(seen, 0);
  Scene hood = box;
  addBox(hood, "hood", {0.6, 0.6, 0.8}, {1.2, 0.0, 0.4}, true);
  for (int set = 0; set < 60; ++set) {
    EXPECT_GT(2 * unknownAfter(cell, hood, 1), seen) << set;
  }
  EXPECT_GT(unknownAfter(cell, box, 1), 0) << "it shows again, in every set";
  unknownAfter(cell, hood, 10);
  EXPECT_EQ(unknownAfter(cell, empty, 3), 0) << "hood and box are gone";
}

TEST(HiddenThings, WhatIsRegisteredAfterAllIsUnknownNoMore) {
  const Scene empty = standardCell(1, 0);
  Cell cell(8);
  for (int set = 0; set < 5; ++set) {
    cell.step(empty, empty, empty.knowledge(), true);
  }
  Scene box = empty;
  addBox(box, "box", {0.3, 0.3, 0.4}, {1.2, 0.0, 0.2}, false);
  ASSERT_GT(unknownAfter(cell, box, 5), 0);
  Scene told = empty;
  addBox(told, "box", {0.3, 0.3, 0.4}, {1.2, 0.0, 0.2}, true);
  EXPECT_EQ(unknownAfter(cell, told, 3), 0);
}

}  // namespace
}  // namespace yarm::test
