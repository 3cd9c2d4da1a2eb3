// From associated points to the map: grid, owners, unknown things, prediction; and the geometry below.
#include "association_score.hpp"
#include "scene_model.hpp"

#include "yarm/perception/predict.hpp"
#include "yarm/perception/solids.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <stdexcept>

namespace yarm::test {
namespace {

using Shape = pc::Solid::Shape;
constexpr std::array<Shape, 4> kShapes{Shape::kBox, Shape::kSphere, Shape::kCylinder, Shape::kCapsule};

TEST(Grid, ACellIsTheFloorAndOutsideThereIsNone) {
  const pc::GridSpec grid;
  EXPECT_EQ(grid.count(), 50000U);
  EXPECT_EQ(grid.indexOf(-2.5, -2.5, 0.01), 0);
  EXPECT_EQ(grid.cellOf(grid.indexOf(0.05, -0.05, 0.73)), (pc::Cell{25, 24, 11}));
  for (const double outside : {2.5, -2.5001, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(grid.indexOf(outside, 0.0, 0.5), -1) << outside;
  }
  EXPECT_EQ(grid.indexOf(0.0, 0.0, 1.3), -1);
  EXPECT_EQ(grid.indexOf(0.0, 0.0, 0.0099), -1);
  for (int i = 0; i < 50000; i += 37) {
    const Eigen::Vector3d c = grid.centre(grid.cellOf(i));
    EXPECT_EQ(grid.indexOf(c.x(), c.y(), c.z()), i);
    EXPECT_EQ(grid.indexOf(grid.cellOf(i)), i);
  }
}

Eigen::Vector3f randomVector(std::mt19937_64& random, float reach) {
  std::uniform_real_distribution<float> u(-reach, reach);
  return {u(random), u(random), u(random)};
}

TEST(Solids, TheNormalLeadsToTheSurface) {
  std::mt19937_64 random(1);
  for (const Shape shape : kShapes) {
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3f size(0.3F, 0.5F, 0.8F);
      const Eigen::Vector3f p = randomVector(random, 1.5F);
      const pc::SurfaceDistance s = pc::surfaceDistance(shape, size, p);
      EXPECT_NEAR(s.normal.norm(), 1.F, 1e-4F);
      EXPECT_NEAR(pc::surfaceDistance(shape, size, p - s.distance * s.normal).distance, 0.F, 1e-4F) << "try " << i;
    }
  }
}

/// The nearest of an object's solids that a point may lie on, by the definition: one point, one solid at a time.
int nearestSolid(const pc::AssociationParams& params, const std::vector<pc::Solid>& solids, const pc::MergedPoint& p,
                 float& distance) {
  int best = -1;
  distance = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const Eigen::Isometry3f T = solids[i].T_frame_solid.cast<float>();
    const pc::SurfaceDistance s = pc::surfaceDistance(solids[i].shape, solids[i].size.cast<float>(),
                                                      T.inverse() * Eigen::Vector3f(p.x, p.y, p.z));
    const float across = std::abs(Eigen::Vector3f(p.ux, p.uy, p.uz).dot(T.linear() * s.normal));
    const double limit = std::min(0.12, params.shape_tolerance + params.noise_sigmas * p.sigma * across);
    if (s.distance <= limit && std::abs(s.distance) < std::abs(distance)) {
      best = static_cast<int>(i);
      distance = s.distance;
    }
  }
  return best;
}

TEST(SceneModel, TheNearestSolidOfAnObjectExplainsAPoint) {
  const pc::AssociationParams params;
  std::mt19937_64 random(3);
  std::vector<pc::Solid> solids;
  for (int i = 0; i < 24; ++i) {
    pc::Solid solid;
    solid.shape = kShapes[static_cast<std::size_t>(i) % kShapes.size()];
    solid.size = {0.1, 0.2, 0.3};
    solid.T_frame_solid = Eigen::Translation3d(randomVector(random, 0.5F).cast<double>() + Eigen::Vector3d(0, 0, 0.6)) *
                          Eigen::AngleAxisd(0.3 * i, randomVector(random, 1.F).cast<double>().normalized());
    solids.push_back(solid);
  }
  pc::SceneModel model(params);
  for (const pc::Solid& solid : solids) {
    model.add(0, solid, solid.T_frame_solid);
  }
  model.index();
  std::vector<pc::MergedPoint> points;
  for (int i = 0; i < 3001; ++i) {
    const Eigen::Vector3f p = randomVector(random, 0.6F) + Eigen::Vector3f(0.F, 0.F, 0.6F);
    const Eigen::Vector3f ray = randomVector(random, 1.F).normalized();
    points.push_back({p.x(), p.y(), p.z(), 0.01F, ray.x(), ray.y(), ray.z(), 0});
  }
  const std::vector<pc::Explanation>& explained = model.explain(points);
  int hits = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    float distance;
    const int expected = nearestSolid(params, solids, points[i], distance);
    hits += expected >= 0 ? 1 : 0;
    ASSERT_EQ(explained[i].piece >= 0, expected >= 0) << "point " << i;
    if (expected >= 0) {
      EXPECT_NEAR(std::abs(explained[i].distance), std::abs(distance), 1e-5F) << "point " << i;
    }
  }
  EXPECT_GT(hits, 300);
}

TEST(Solids, SamplesLieOnTheSurfaceAndLeaveNoGap) {
  std::mt19937_64 random(2);
  for (const Shape shape : kShapes) {
    const Eigen::Vector3f size(0.2F, 0.3F, 0.4F);
    const auto samples = pc::sampleSurface(shape, size, 0.05F);
    for (const Eigen::Vector3f& p : samples) {
      EXPECT_NEAR(pc::surfaceDistance(shape, size, p).distance, 0.F, 1e-4F);
    }
    for (int i = 0; i < 300; ++i) {
      Eigen::Vector3f p = randomVector(random, 1.F);
      for (int k = 0; k < 3; ++k) {
        const auto s = pc::surfaceDistance(shape, size, p);
        p -= s.distance * s.normal;
      }
      float gap = 1e9F;
      for (const Eigen::Vector3f& q : samples) {
        gap = std::min(gap, (p - q).norm());
      }
      EXPECT_LT(gap, 0.05F);
    }
  }
}

TEST(Solids, RaysEnterOnTheSurface) {
  std::mt19937_64 random(3);
  int entered = 0;
  for (const Shape shape : kShapes) {
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3f size(0.3F, 0.5F, 0.8F);
      const Eigen::Vector3f origin = 3.F * randomVector(random, 1.F).normalized();
      const Eigen::Vector3f direction = (randomVector(random, 0.4F) - origin).normalized();
      const float t = pc::rayEntry(shape, size, origin, direction);
      bool meets = false;
      for (float s = 0.F; s < 6.F; s += 0.01F) {
        meets = meets || pc::surfaceDistance(shape, size, origin + s * direction).distance < -0.01F;
      }
      if (std::isfinite(t)) {
        ++entered;
        EXPECT_NEAR(pc::surfaceDistance(shape, size, origin + t * direction).distance, 0.F, 2e-3F);
      } else {
        EXPECT_FALSE(meets) << "try " << i;
      }
    }
  }
  EXPECT_GT(entered, 500);
}

pc::AssociatedObject object(const std::string& name, pc::ObjectKind kind, std::vector<Eigen::Vector3f> points) {
  pc::AssociatedObject o;
  o.name = name;
  o.object = kind;
  o.is_static = kind == pc::ObjectKind::kObstacle;
  o.points = std::move(points);
  return o;
}

TEST(Occupancy, CellsOfRobotsThatMeetAreCollisionsRestingThingsShareInPeace) {
  const Eigen::Vector3f here(0.05F, 0.05F, 0.75F);
  pc::OccupancyBuilder builder{pc::GridSpec{}};
  const pc::GridSpec grid;
  const int cell = grid.indexOf(here.x(), here.y(), here.z());
  pc::AssociatedSet set;
  set.objects = {object("table", pc::ObjectKind::kObstacle, {here}),
                 object("debris_1", pc::ObjectKind::kDebris, {here})};
  const pc::OccupancyGrid& peace = builder.build(set);
  EXPECT_EQ(peace.cells[static_cast<std::size_t>(cell)], 1);
  EXPECT_TRUE(peace.collisions.empty());
  EXPECT_TRUE(peace.object_cells[0].empty());
  EXPECT_EQ(peace.object_cells[1], std::vector<std::int32_t>{cell});

  set.objects.push_back(object("ankurbot_1", pc::ObjectKind::kMobile, {here, {1.F, 1.F, 0.5F}}));
  const pc::OccupancyGrid& clash = builder.build(set);
  EXPECT_EQ(clash.cells[static_cast<std::size_t>(cell)], 2);
  EXPECT_EQ(clash.collisions, std::vector<std::int32_t>{cell});
  EXPECT_EQ(clash.object_cells[0].size() + clash.object_cells[1].size() + clash.object_cells[2].size(), 4U);

  set.objects.resize(1);
  set.objects.push_back(object("hc10_barc", pc::ObjectKind::kManipulator, {here}));
  EXPECT_EQ(builder.build(set).collisions.size(), 1U);
  set.objects[1].attached_to = {"table"};
  EXPECT_TRUE(builder.build(set).collisions.empty());
}

TEST(Occupancy, PointsOutsideHaveNoCellAndHiddenOnesCount) {
  pc::OccupancyBuilder builder{pc::GridSpec{}};
  pc::AssociatedSet set;
  set.objects = {
      object("a", pc::ObjectKind::kObstacle, {{9.F, 0.F, 0.5F}, {0.F, 0.F, std::nanf("")}, {0.F, 0.F, -0.1F}})};
  set.objects[0].hidden = {{0.F, 0.F, 0.5F}, {0.001F, 0.001F, 0.501F}};
  const pc::OccupancyGrid& grid = builder.build(set);
  EXPECT_EQ(grid.object_cells[0].size(), 1U);
  EXPECT_EQ(std::count(grid.cells.begin(), grid.cells.end(), 1), 1);
}

TEST(Uids, AreNeverUsedTwice) {
  pc::UidRegistry uids;
  const auto first = uids.update({"a", "b"});
  EXPECT_NE(first[0], first[1]);
  EXPECT_EQ(uids.update({"b", "a"}), (std::vector<std::int32_t>{first[1], first[0]}));
  EXPECT_EQ(uids.update({"a"})[0], first[0]);
  const auto again = uids.update({"a", "b", "c"});
  EXPECT_EQ(again[0], first[0]);
  EXPECT_GT(again[1], first[1]);
  EXPECT_GT(again[2], again[1]);
}

TEST(Map, NoCellOfTwoAfterCalibration) {
  for (std::uint64_t seed = 40; seed < 44; ++seed) {
    AssociationRun run("yarm", seed);
    run.run({"still", standardCell(3, 3), 5, [](Scene&, int) {}}, [&](const Scene&, const ScoredSet& set) {
      if (!set.calibrating) {
        EXPECT_TRUE(set.grid->collisions.empty()) << "seed " << seed << " set " << set.k;
      }
    });
  }
}

TEST(Map, VisibleCellsAreMarkedAndEmptyOnesAreNot) {
  MapScore total;
  int debris_seen = 0;
  int debris_mapped = 0;
  std::uint64_t seed = 45;
  for (const Sequence& sequence : scoredSequences()) {
    AssociationRun run("yarm", seed++);
    run.run(sequence, [&](const Scene& scene, const ScoredSet& set) {
      if (set.calibrating || set.k % 12 != 6) {
        return;
      }
      const MapScore score = scoreMap(scene, set);
      total.visible_cells += score.visible_cells;
      total.missed += score.missed;
      total.marked_cells += score.marked_cells;
      total.phantom += score.phantom;
      for (std::size_t o = 0; o < set.result->objects.size(); ++o) {
        if (set.result->objects[o].object == pc::ObjectKind::kDebris) {
          ++debris_seen;
          debris_mapped += set.grid->object_cells[o].empty() ? 0 : 1;
        }
      }
    });
  }
  const double recall = 1.0 - static_cast<double>(total.missed) / total.visible_cells;
  const double phantom = static_cast<double>(total.phantom) / total.marked_cells;
  std::printf("recall of %d visible cells %.3f %%, phantoms among %d marked %.3f %%, debris %d of %d\n",
              total.visible_cells, 100 * recall, total.marked_cells, 100 * phantom, debris_mapped, debris_seen);
  EXPECT_GE(recall, 0.99);
  EXPECT_LE(phantom, 0.01);
  EXPECT_GE(debris_mapped, 0.99 * debris_seen);
}

TEST(Map, RobotsThatTouchCollideInTheGrid) {
  Sequence s{"touch", standardCell(2, 0), 2,
             [](Scene& scene, int) { moveAnkurbot(scene, "ankurbot_2", 1.9, 1.9 - 0.05 - 1.30 + 0.01, M_PI / 2); }};
  AssociationRun run("yarm", 50);
  run.run(s, [](const Scene&, const ScoredSet& set) {
    if (!set.calibrating) {
      EXPECT_FALSE(set.grid->collisions.empty());
    }
  });
}

/// A stranger of some size somewhere, there from set 1 to 8 of 12.
Sequence stranger(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  const Eigen::Vector3d size(0.12 + 0.3 * u(random), 0.12 + 0.3 * u(random), 0.12 + 0.4 * u(random));
  const bool on_table = u(random) < 0.4;
  const Eigen::Vector3d at = on_table ? Eigen::Vector3d(0.25, -0.3 + 0.6 * u(random), 0.7 + 0.5 * size.z())
                                      : Eigen::Vector3d(-0.4 + 0.8 * u(random), 1.1 + 0.5 * u(random), 0.5 * size.z());
  return {"stranger", standardCell(2, 1), 12, [=](Scene& scene, int k) {
            if (k == 1) {
              addBox(scene, "stranger", size, at, false);
            }
            if (k == 8) {
              scene.remove("stranger");
            }
          }};
}

TEST(Unknown, WhatStaysThreeSetsIsInTheMapAndWhatLeavesGoes) {
  for (std::uint64_t seed = 60; seed < 68; ++seed) {
    AssociationRun run("yarm", seed);
    run.run(stranger(seed), [&](const Scene& scene, const ScoredSet& set) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " set " + std::to_string(set.k));
      int seen = 0;
      int found = 0;
      for (std::size_t i = 0; i < set.truth.size(); ++i) {
        if (scene.indexOf("stranger") >= 0 && set.truth[i] == scene.indexOf("stranger")) {
          const pc::MergedPoint& p = set.merged->points[i];
          const int cell = set.grid->spec.indexOf(p.x, p.y, p.z);
          ++seen;
          found += cell >= 0 && set.grid->cells[static_cast<std::size_t>(cell)] > 0 ? 1 : 0;
        }
      }
      if (set.k >= 3 && set.k < 8) {
        ASSERT_GT(seen, 5);
        EXPECT_GE(found, 0.9 * seen);
      }
      const bool unknown = set.result->objects.back().is_unknown;
      if (set.k < 1 || set.k > 9) {
        EXPECT_FALSE(unknown);
      } else if (set.k >= 3 && set.k < 8) {
        EXPECT_TRUE(unknown);
        EXPECT_EQ(set.result->objects.back().object, pc::ObjectKind::kObstacle);
      }
    });
  }
}

TEST(Unknown, NoPhantomFromNoiseLastsTwoSets) {
  AssociationRun run("yarm", 70);
  const Score score = run.run({"noise", standardCell(3, 3), 150, [](Scene& scene, int k) {
                                 moveHc10(scene, "hc10_barc", {M_PI, -0.2 + 0.01 * k, 0.6, 0.0, 1.0, 0.0});
                                 moveAnkurbot(scene, "ankurbot_1", 1.9 - 0.005 * k, 1.9, M_PI - 0.003 * k);
                               }});
  EXPECT_LE(score.longest_phantom, 1);
  EXPECT_LE(score.phantom_sets, 2);
}

class Predict : public testing::Test {
 protected:
  void SetUp() override {
    scene_ = standardCell(2, 1);
    run_.run({"still", scene_, 2, [](Scene&, int) {}},
             [this](const Scene&, const ScoredSet& set) { present_ = *set.result; });
  }
  Scene scene_;
  AssociationRun run_{"yarm", 80};
  pc::AssociatedSet present_;
};

TEST_F(Predict, ARobotDrivenIntoAnotherCollidesWithItAndOnlyIt) {
  const Eigen::Isometry3d at = pose(1.9, 1.9 - 0.03, 0.89, M_PI / 2);  // its tip in the other's mast
  const auto answer = pc::predictNewState(present_, pc::GridSpec{}, {{"ankurbot_2", at}});
  ASSERT_TRUE(answer.ok) << answer.message;
  EXPECT_TRUE(answer.collision);
  ASSERT_EQ(answer.pairs.size(), 1U);
  EXPECT_EQ(answer.pairs[0], (std::pair<std::string, std::string>("ankurbot_1", "ankurbot_2")));
  EXPECT_FALSE(answer.cells.empty());
}

TEST_F(Predict, AFreePlaceIsFreeAndStayingIsToo) {
  EXPECT_FALSE(pc::predictNewState(present_, pc::GridSpec{}, {}).collision);
  const Eigen::Isometry3d stay = scene_.poses["ankurbot_2/ee"];
  EXPECT_FALSE(pc::predictNewState(present_, pc::GridSpec{}, {{"ankurbot_2", stay}}).collision);
  const auto moved = pc::predictNewState(present_, pc::GridSpec{}, {{"ankurbot_2", pose(0.2, -1.7, 0.89, M_PI)}});
  EXPECT_TRUE(moved.ok);
  EXPECT_FALSE(moved.collision) << moved.message;
}

TEST_F(Predict, TwoMovedTogetherAreCheckedAgainstEachOther) {
  const auto answer = pc::predictNewState(
      present_, pc::GridSpec{},
      {{"ankurbot_1", pose(0.9, 1.5, 0.89, M_PI)}, {"ankurbot_2", pose(1.0, 1.45, 0.89, M_PI / 2)}});
  EXPECT_TRUE(answer.collision) << answer.message;
}

TEST_F(Predict, BadQuestionsAreRefusedWithEveryReason) {
  Eigen::Isometry3d broken = Eigen::Isometry3d::Identity();
  broken.translation().x() = std::nan("");
  const auto answer = pc::predictNewState(present_, pc::GridSpec{}, {{"nobody", broken}, {"ankurbot_1", broken}});
  EXPECT_FALSE(answer.ok);
  EXPECT_NE(answer.message.find("'nobody' is not in the map"), std::string::npos) << answer.message;
  EXPECT_NE(answer.message.find("pose of 'ankurbot_1'"), std::string::npos) << answer.message;
}

TEST(AssociationParams, EveryFaultIsNamedAtOnce) {
  pc::AssociationParams params;
  params.search_radius = -1.0;
  params.unknown_hits = 9;
  try {
    static_cast<void>(pc::makeAssociator("yarm", params));
    FAIL() << "bad parameters were taken";
  } catch (const std::invalid_argument& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("search_radius = -1"), std::string::npos) << text;
    EXPECT_NE(text.find("unknown_hits = 9"), std::string::npos) << text;
  }
  EXPECT_THROW(static_cast<void>(pc::makeAssociator("other", {})), std::invalid_argument);
}

}  // namespace
}  // namespace yarm::test
