// Each weakness of the original association, shown on it and shown gone in ours.
#include "association_score.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace yarm::test {
namespace {

const pc::AssociatedObject* find(const pc::AssociatedSet& set, const std::string& name) {
  const auto at = std::find_if(set.objects.begin(), set.objects.end(), [&](const auto& o) { return o.name == name; });
  return at == set.objects.end() ? nullptr : &*at;
}

/// A set made by hand: every point a voxel of its own.
pc::MergedSet handmade(const std::vector<std::vector<Eigen::Vector3f>>& clusters) {
  pc::MergedSet set;
  for (const auto& cluster : clusters) {
    std::vector<std::int32_t> voxels;
    for (const Eigen::Vector3f& p : cluster) {
      voxels.push_back(static_cast<std::int32_t>(set.centroids.size()));
      set.voxel_of_point.push_back(voxels.back());
      set.cluster_of_voxel.push_back(static_cast<std::int32_t>(set.clusters.size()));
      set.voxel_points.push_back(1);
      set.centroids.push_back(p);
      const Eigen::Vector3f ray = (p - Eigen::Vector3f(0.F, 0.F, 5.F)).normalized();
      set.points.push_back({p.x(), p.y(), p.z(), 0.005F, ray.x(), ray.y(), ray.z(), 0});
    }
    set.clusters.push_back(voxels);
  }
  return set;
}

std::vector<Eigen::Vector3f> row(const Eigen::Vector3f& from, const Eigen::Vector3f& step, int count) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(from + static_cast<float>(i) * step);
  }
  return points;
}

TEST(Weakness, TheSmallestClusterNearASeedWinsInsteadOfItsOwn) {
  // The robot is a row of 20 points that ends at its seed; five points of something else lie 0.19 m beyond the seed.
  const auto robot = row({-2.F, 0.F, 1.F}, {0.1F, 0.F, 0.F}, 20);  // up to x = -0.1
  const auto other = row({0.15F, 0.F, 1.F}, {0.F, 0.1F, 0.F}, 5);
  const pc::MergedSet set = handmade({robot, other});
  const std::vector<pc::Seed> seeds{{"robot", pc::ObjectKind::kMobile, false, pose(-0.04, 0.0, 1.0), 1}};
  const auto original = pc::makeAssociator("original", {});
  const auto& wrong = original->associate({&set, &seeds, nullptr, nullptr, false});
  EXPECT_EQ(find(wrong, "robot")->points.size(), 5U);

  const auto ours = pc::makeAssociator("yarm", {});
  const pc::Knowledge nothing;
  const pc::LinkPoses links;
  const auto& right = ours->associate({&set, &seeds, &nothing, &links, true});
  const auto& source = find(right, "robot")->source;
  for (std::uint32_t i = 0; i < 20; ++i) {
    EXPECT_EQ(std::count(source.begin(), source.end(), i), 1) << "point " << i << " of the robot";
  }
}

struct Both {
  AssociationRun original{"original", 21};
  AssociationRun ours{"yarm", 21};
};

/// Share of the truth points of a body that lie in an occupied cell of the grid.
double mapped(const Scene& scene, const ScoredSet& set, const std::string& body) {
  Mean share;
  for (std::size_t i = 0; i < set.truth.size(); ++i) {
    if (set.truth[i] == scene.indexOf(body)) {
      const pc::MergedPoint& p = set.merged->points[i];
      const int cell = set.grid->spec.indexOf(p.x, p.y, p.z);
      if (cell >= 0) {
        share.add(set.grid->cells[static_cast<std::size_t>(cell)] > 0 ? 1.0 : 0.0);
      }
    }
  }
  return share.value();
}

TEST(Weakness, PointsOfNobodyNeverReachTheMap) {
  Sequence s{"stranger", standardCell(1, 0), 6, [](Scene& scene, int k) {
               if (k == 1) {
                 addBox(scene, "stranger", {0.3, 0.3, 0.4}, {1.2, 0.6, 0.2}, false);
               }
             }};
  Both both;
  both.original.run(s, [](const Scene& scene, const ScoredSet& set) {
    if (set.k > 1) {
      EXPECT_EQ(mapped(scene, set, "stranger"), 0.0);
    }
  });
  both.ours.run(s, [](const Scene& scene, const ScoredSet& set) {
    if (set.k >= 3) {  // there since 1: its third set
      EXPECT_GE(mapped(scene, set, "stranger"), 0.95);
    }
  });
}

TEST(Weakness, AStaticThingThatMovedStaysWhereItWas) {
  Sequence s{"moved", standardCell(0, 0), 4, [](Scene& scene, int k) {
               if (k == 1) {
                 scene.poses["box_1"] = pose(1.5, -1.0, 0.4);
               }
             }};
  addBox(s.scene, "box_1", {0.3, 0.3, 0.4}, {1.2, 0.6, 0.2}, true);
  Both both;
  both.original.run(s, [](const Scene& scene, const ScoredSet& set) {
    if (set.k == 3) {
      EXPECT_EQ(mapped(scene, set, "box_1"), 0.0);
    }
  });
  both.ours.run(s, [](const Scene& scene, const ScoredSet& set) {
    if (set.k == 3) {
      EXPECT_GE(mapped(scene, set, "box_1"), 0.98);
      const int old = set.grid->spec.indexOf(1.2, 0.6, 0.35);
      EXPECT_EQ(set.grid->cells[static_cast<std::size_t>(old)], 0);
    }
  });
}

TEST(Weakness, AnObjectThatLeftStays) {
  Sequence s{"left", standardCell(1, 0), 3, [](Scene& scene, int k) {
               if (k == 1) {
                 scene.remove("box_1");
               }
             }};
  addBox(s.scene, "box_1", {0.3, 0.3, 0.4}, {1.2, 0.6, 0.2}, true);
  Both both;
  both.original.run(s, [](const Scene&, const ScoredSet& set) {
    if (set.k >= 1) {
      EXPECT_NE(find(*set.result, "box_1"), nullptr);
    }
  });
  both.ours.run(
      s, [](const Scene&, const ScoredSet& set) { EXPECT_EQ(find(*set.result, "box_1") != nullptr, set.k < 1); });
}

TEST(Weakness, TwoThatFirstAppearInContactEraseEachOther) {
  Sequence s{"both at once", standardCell(0, 0), 4, [](Scene& scene, int k) {
               if (k == 1) {
                 addAnkurbot(scene, "ankurbot_1", 1.6, 1.2, M_PI);
                 addAnkurbot(scene, "ankurbot_2", 0.85, -0.142, M_PI / 2);  // its tip touches the other's arm
               }
             }};
  Both both;
  both.original.run(s, [](const Scene&, const ScoredSet& set) {
    if (set.k == 3) {
      EXPECT_LT(
          std::min(find(*set.result, "ankurbot_1")->points.size(), find(*set.result, "ankurbot_2")->points.size()),
          10U);
    }
  });
  const Score score = both.ours.run(s);
  EXPECT_GE(Score::mean(score.contact), 0.9);
  EXPECT_EQ(score.contact.size(), 2U);
}

/// Points of an object near its seed.
int nearSeed(const pc::AssociatedObject& o) {
  const Eigen::Vector3f tip = o.T_world_seed.translation().cast<float>();
  return static_cast<int>(std::count_if(o.points.begin(), o.points.end(),
                                        [&](const Eigen::Vector3f& p) { return (p - tip).norm() < 0.15F; }));
}

TEST(Weakness, SubtractionTakesAwayTheVeryPartThatTouches) {
  // A thing first seen beside another keeps only what is farther than r from it, and that becomes all it ever is.
  Sequence s{"eaten", standardCell(1, 0), 8, [](Scene& scene, int k) {
               if (k == 1) {
                 addAnkurbot(scene, "ankurbot_2", 1.9, 1.9 - 0.05 - 1.30 - 0.005,
                             M_PI / 2);  // its tip at the other's mast
               }
               if (k > 3) {
                 moveAnkurbot(scene, "ankurbot_2", 1.9, 0.3, M_PI / 2);
               }
             }};
  Both both;
  both.original.run(s, [&](const Scene&, const ScoredSet& set) {
    if (set.k >= 1 && set.k <= 3) {
      EXPECT_EQ(nearSeed(*find(*set.result, "ankurbot_2")), 0);
    }
  });
  const Score score = both.ours.run(s, [&](const Scene&, const ScoredSet& set) {
    if (set.k >= 1) {
      EXPECT_GT(nearSeed(*find(*set.result, "ankurbot_2")), 0);
    }
  });
  EXPECT_GE(Score::mean(score.contact), 0.9);
}

TEST(Weakness, VoxelCentroidsLeaveHolesInTheGrid) {
  Sequence s{"holes", standardCell(2, 1), 2, [](Scene&, int) {}};
  const auto share = [](const Scene&, const ScoredSet& set) {
    std::set<int> seen;
    int found = 0;
    for (const pc::MergedPoint& p : set.merged->points) {
      seen.insert(set.grid->spec.indexOf(p.x, p.y, p.z));
    }
    seen.erase(-1);
    for (const int cell : seen) {
      found += set.grid->cells[static_cast<std::size_t>(cell)] > 0 ? 1 : 0;
    }
    return static_cast<double>(found) / static_cast<double>(seen.size());
  };
  Both both;
  both.original.run(s, [&](const Scene& scene, const ScoredSet& set) { EXPECT_LT(share(scene, set), 0.85); });
  both.ours.run(s, [&](const Scene& scene, const ScoredSet& set) { EXPECT_GT(share(scene, set), 0.90); });
}

TEST(Weakness, FloorNoiseMeltsTheSceneIntoOneCluster) {
  SceneFactory factory(31);
  factory.render(standardCell(3, 2));
  const auto largestShare = [&](double floor_sigmas) {
    pc::MergeParams params;
    params.floor_sigmas = floor_sigmas;
    const auto backend = pc::makeBackend("fused", params, {});
    pc::MergedSet set;
    backend->merge(factory.clouds(1), set);
    backend->cluster(set);
    return static_cast<double>(set.clusters.front().size()) / static_cast<double>(set.centroids.size());
  };
  EXPECT_GT(largestShare(0.0), 0.9);
  EXPECT_LT(largestShare(pc::MergeParams{}.floor_sigmas), 0.5);
}

}  // namespace
}  // namespace yarm::test
