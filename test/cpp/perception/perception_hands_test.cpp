// What hangs on a robot's hand is the robot's, and what is lost is debris again in the next set.
#include "scene_factory.hpp"

#include "yarm/perception/association.hpp"
#include "yarm/perception/merge.hpp"
#include "yarm/perception/occupancy.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>

namespace yarm::test {
namespace {

constexpr double kReach = 1.3;  // of the robot's tip from its middle, metres

/// Table, robots whose tips are over debris on it, and what the cell is told of them.
class Cell {
 public:
  Cell() {
    addTable(scene);
    addAnkurbot(scene, "ankurbot_1", -0.2 + kReach, 0.25, 3.14159265);
    addAnkurbot(scene, "ankurbot_2", -0.2 + kReach, -0.25, 3.14159265);
    addDebris(scene, "debris_1", -0.2, 0.25, 0.3);
    addDebris(scene, "debris_2", -0.2, -0.25, 0.3);
    step();
  }

  void step() {
    stamp_ += 33'333'333;
    factory_.render(scene);
    backend_->merge(factory_.clouds(stamp_), set_);
    const auto seeds = scene.seeds(stamp_);
    const auto knowledge = scene.knowledge();
    result_ = &associator_->associate({&set_, &seeds, &knowledge, &scene.poses, false, &grasping, timely});
    grid_ = &builder_.build(*result_);
  }

  void move(const std::string& name, double dx, double dy, double dz) {
    scene.poses[name] = Eigen::Translation3d(dx, dy, dz) * scene.poses[name];
  }

  [[nodiscard]] const pc::AssociatedObject& object(const std::string& name) const {
    return *std::find_if(result_->objects.begin(), result_->objects.end(),
                         [&](const auto& o) { return o.name == name; });
  }

  [[nodiscard]] std::vector<std::int32_t> cells(const std::string& name) const {
    return grid_->object_cells[static_cast<std::size_t>(&object(name) - result_->objects.data())];
  }

  /// Robot that carries a piece; empty for none.
  [[nodiscard]] std::string carrier(const std::string& name) const {
    const auto& carried = object(name).carried;
    return carried ? carried->robot : "";
  }

  Scene scene;
  std::set<std::string> grasping;
  bool timely{true};  ///< the poses are told as those of the set's time
  std::unique_ptr<pc::Associator>& associator() { return associator_; }

 private:
  SceneFactory factory_{3};
  std::unique_ptr<pc::MergeBackend> backend_ = pc::makeBackend("fused", {}, {});
  std::unique_ptr<pc::Associator> associator_ = pc::makeAssociator("yarm", {});
  pc::OccupancyBuilder builder_{pc::GridSpec{}};
  pc::MergedSet set_;
  pc::StampNs stamp_{0};
  const pc::AssociatedSet* result_{nullptr};
  const pc::OccupancyGrid* grid_{nullptr};
};

bool contains(const std::vector<std::int32_t>& cells, const std::vector<std::int32_t>& part) {
  return std::includes(cells.begin(), cells.end(), part.begin(), part.end());
}

TEST(Hands, WhatTheyHoldIsTheRobots) {
  Cell cell;
  const std::size_t alone = cell.object("ankurbot_1").hidden.size();
  const std::size_t load = cell.object("debris_1").hidden.size();
  const std::vector<std::int32_t> cells = cell.cells("debris_1");
  ASSERT_GT(load, 0U);
  ASSERT_GT(cells.size(), 0U);
  cell.grasping = {"ankurbot_1"};
  cell.step();
  const pc::AssociatedObject& piece = cell.object("debris_1");
  const pc::AssociatedObject& robot = cell.object("ankurbot_1");
  EXPECT_EQ(cell.carrier("debris_1"), "ankurbot_1");
  EXPECT_TRUE(piece.points.empty() && piece.source.empty() && piece.hidden.empty());
  EXPECT_EQ(robot.hidden.size(), alone + load);
  EXPECT_EQ(robot.points.size(), robot.source.size());
  EXPECT_TRUE(cell.cells("debris_1").empty());
  EXPECT_TRUE(contains(cell.cells("ankurbot_1"), cells));
  EXPECT_EQ(cell.carrier("debris_2"), "");
}

TEST(Hands, TheLoadsPoseIsToldAtTheTip) {
  Cell cell;
  cell.move("debris_1", 0.02, 0.01, 0.0);
  cell.grasping = {"ankurbot_1"};
  cell.step();
  ASSERT_TRUE(cell.object("debris_1").carried);
  const Eigen::Vector3d at_tip = cell.object("debris_1").carried->T_tip_piece.translation();
  EXPECT_NEAR(at_tip.x(), -0.02, 1e-6) << "the arm points along -x";
  EXPECT_NEAR(at_tip.y(), -0.01, 1e-6);
  EXPECT_NEAR(at_tip.z(), 0.75 - 0.89, 1e-6);
}

TEST(Hands, WhereAHandWouldTakeALoadIsNotTold) {
  Cell cell;
  addDebris(cell.scene, "debris_3", 0.3, 0.0, 0.3, 0.70);
  cell.scene.poses["ankurbot_2/ee"] = pose(0.3, 0.0, 0.89);  // only told to be there, so that it hides nothing
  cell.step();
  ASSERT_TRUE(cell.object("debris_3").piece);
  cell.grasping = {"ankurbot_2"};
  cell.step();
  EXPECT_EQ(cell.carrier("debris_3"), "ankurbot_2");
  EXPECT_FALSE(cell.object("debris_3").piece);
}

TEST(Hands, TheLoadMovesWithTheRobot) {
  Cell cell;
  cell.grasping = {"ankurbot_1"};
  cell.step();
  for (int k = 0; k < 20; ++k) {
    const double turn = 0.03 * k;
    moveAnkurbot(cell.scene, "ankurbot_1", -0.2 + kReach, 0.25 + 0.02 * k, 3.14159265 - turn);
    cell.scene.poses["debris_1"] = cell.scene.poses["ankurbot_1/ee"] * pose(0.0, 0.0, -0.12, 0.3);
    cell.step();
    EXPECT_EQ(cell.carrier("debris_1"), "ankurbot_1") << k;
  }
}

TEST(Hands, WhatTheyLetGoIsDebrisInTheNextSet) {
  Cell cell;
  const std::vector<std::int32_t> cells = cell.cells("debris_1");
  cell.grasping = {"ankurbot_1"};
  cell.step();
  ASSERT_EQ(cell.carrier("debris_1"), "ankurbot_1");
  cell.grasping.clear();
  cell.step();
  EXPECT_EQ(cell.carrier("debris_1"), "");
  EXPECT_EQ(cell.cells("debris_1"), cells);
  EXPECT_FALSE(cell.object("debris_1").points.empty());
}

TEST(Hands, WhatIsNoLongerThereIsDebrisWhateverTheySay) {
  for (const Eigen::Vector3d& off : {Eigen::Vector3d(0.12, 0.12, 0.0), Eigen::Vector3d(0.0, 0.0, -0.4)}) {
    Cell cell;
    cell.grasping = {"ankurbot_1"};
    cell.step();
    ASSERT_EQ(cell.carrier("debris_1"), "ankurbot_1");
    cell.move("debris_1", off.x(), off.y(), off.z());
    cell.step();
    EXPECT_EQ(cell.carrier("debris_1"), "") << off.transpose();
    EXPECT_FALSE(cell.cells("debris_1").empty());
  }
}

TEST(Hands, WhatPosesOfDifferentTimesShowElsewhereIsKeptForASecond) {
  Cell cell;
  cell.grasping = {"ankurbot_1"};
  cell.step();
  cell.timely = false;
  for (int again = 0; again < 2; ++again) {
    cell.move("debris_1", 0.0, 0.1, 0.0);
    for (int k = 0; k < 30; ++k) {
      cell.step();
      EXPECT_EQ(cell.carrier("debris_1"), "ankurbot_1") << k;
    }
    cell.move("debris_1", 0.0, -0.1, 0.0);
    cell.step();
    EXPECT_EQ(cell.carrier("debris_1"), "ankurbot_1") << "one set in which it is there, and the second begins anew";
  }
  cell.grasping.clear();
  cell.step();
  EXPECT_EQ(cell.carrier("debris_1"), "") << "what the hand says counts at once";
}

TEST(Hands, AfterThatSecondItIsDebris) {
  Cell cell;
  cell.grasping = {"ankurbot_1"};
  cell.step();
  cell.timely = false;
  cell.move("debris_1", 0.12, 0.12, 0.0);
  for (int k = 0; k < 31; ++k) {
    EXPECT_EQ(cell.carrier("debris_1"), "ankurbot_1") << k;
    cell.step();
  }
  EXPECT_EQ(cell.carrier("debris_1"), "");
}

TEST(Hands, PosesOfTheSetsOwnTimeEndADoubtAtOnce) {
  Cell cell;
  cell.grasping = {"ankurbot_1"};
  cell.step();
  cell.timely = false;
  cell.move("debris_1", 0.12, 0.12, 0.0);
  cell.step();
  ASSERT_EQ(cell.carrier("debris_1"), "ankurbot_1");
  cell.timely = true;
  cell.step();
  EXPECT_EQ(cell.carrier("debris_1"), "");
}

TEST(Hands, EachHoldsItsOwn) {
  Cell cell;
  cell.grasping = {"ankurbot_1", "ankurbot_2"};
  cell.step();
  EXPECT_EQ(cell.carrier("debris_1"), "ankurbot_1");
  EXPECT_EQ(cell.carrier("debris_2"), "ankurbot_2");
}

TEST(Hands, OfTwoPiecesTheOneUnderTheTipIsHeld) {
  Cell cell;
  cell.move("debris_2", 0.0, 0.42, 0.0);  // 8 cm beside debris_1, across its shorter side
  cell.grasping = {"ankurbot_1"};
  cell.step();
  EXPECT_EQ(cell.carrier("debris_1"), "ankurbot_1");
  EXPECT_EQ(cell.carrier("debris_2"), "");
}

TEST(Hands, OfTwoPiecesOnEachOtherTheUpperIsHeld) {
  Cell cell;
  cell.move("debris_2", 0.0, 0.5, 0.04);
  cell.grasping = {"ankurbot_1"};
  cell.step();
  EXPECT_EQ(cell.carrier("debris_2"), "ankurbot_1");
  EXPECT_EQ(cell.carrier("debris_1"), "");
}

TEST(Hands, OnePieceIsNotHeldTwice) {
  Cell cell;
  cell.scene.poses["ankurbot_2/ee"] = cell.scene.poses["ankurbot_1/ee"];
  cell.grasping = {"ankurbot_1", "ankurbot_2"};
  cell.step();
  EXPECT_EQ(cell.carrier("debris_1"), "ankurbot_1");
  EXPECT_EQ(cell.carrier("debris_2"), "");
}

TEST(Hands, WithNothingUnderTheTipNothingIsHeld) {
  Cell cell;
  cell.move("debris_1", 0.2, 0.0, 0.0);
  cell.grasping = {"ankurbot_1", "nobody"};
  cell.step();
  EXPECT_EQ(cell.carrier("debris_1"), "");
  EXPECT_EQ(cell.carrier("debris_2"), "");
}

TEST(Hands, APieceOfUnknownShapeIsHeldByItsSeed) {
  Cell cell;
  cell.scene.bodies[static_cast<std::size_t>(cell.scene.indexOf("debris_1"))].shape_known = false;
  cell.step();
  cell.grasping = {"ankurbot_1"};
  cell.step();
  EXPECT_EQ(cell.carrier("debris_1"), "ankurbot_1");
}

TEST(Hands, WhatLeavesTheCellIsHeldNoMore) {
  Cell cell;
  cell.grasping = {"ankurbot_1"};
  cell.step();
  cell.scene.remove("debris_1");
  cell.step();
  EXPECT_EQ(cell.carrier("debris_2"), "");
  cell.scene.remove("ankurbot_1");
  cell.step();
  EXPECT_EQ(cell.carrier("debris_2"), "");
}

TEST(Hands, AfterAResetTheyAreAskedAnew) {
  Cell cell;
  cell.grasping = {"ankurbot_1"};
  cell.step();
  cell.associator()->reset();
  cell.move("debris_1", 0.3, 0.0, 0.0);
  cell.move("debris_2", 0.0, 0.5, 0.0);
  cell.step();
  EXPECT_EQ(cell.carrier("debris_1"), "");
  EXPECT_EQ(cell.carrier("debris_2"), "ankurbot_1");
}

}  // namespace
}  // namespace yarm::test
