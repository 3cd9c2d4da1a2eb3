// Things nobody registered, over time: one identity each, how fast they go, and when they are gone.
#include "object_tracks.hpp"
#include "scene_factory.hpp"

#include "yarm/perception/association.hpp"
#include "yarm/perception/merge.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>

namespace yarm::test {
namespace {

using Groups = std::vector<pc::ObjectTracks::Group>;

// ---- upright cylinders, before four cameras and walls

struct Cylinder {
  double x;
  double y;
  double radius{0.25};
  double height{1.2};
};
struct Wall {
  Eigen::AlignedBox3d box;
};

constexpr int kCameras = 4;
const Eigen::Vector3d kPlaces[kCameras] = {{3, 0, 2}, {0, 3, 2}, {0, -3, 2}, {-3, 0, 2}};

/// Whether a wall is on the line from a camera to a point.
bool isHidden(const Eigen::Vector3d& camera, const Eigen::Vector3d& point, const std::vector<Wall>& walls) {
  for (const Wall& wall : walls) {
    for (double share = 0.05; share < 0.995; share += 0.005) {
      if (wall.box.contains(camera + share * (point - camera))) {
        return true;
      }
    }
  }
  return false;
}

/// Shows cylinders to a tracker, set by set.
class Stage {
 public:
  Stage(std::uint64_t seed, double rate_hz) : step_ns_(static_cast<pc::StampNs>(1e9 / rate_hz)), random_(seed) {}

  /// Cameras from `first` on look; what touches within 0.2 m is one group.
  void step(const std::vector<Cylinder>& things, const std::vector<Wall>& walls = {}, int first = 0) {
    stamp_ += step_ns_;
    std::vector<pc::MergedPoint> points;
    Groups groups(things.size());
    std::vector<std::int32_t> absent;
    for (int camera = 0; camera < kCameras; ++camera) {
      if (camera < first) {
        absent.push_back(camera);
        continue;
      }
      for (const Wall& wall : walls) {
        addWall(points, camera, wall);
      }
      for (std::size_t i = 0; i < things.size(); ++i) {
        addCylinder(points, camera, things[i], walls, groups[i]);
      }
    }
    for (std::size_t i = 1; i < things.size(); ++i) {
      const double gap = std::hypot(things[i].x - things[0].x, things[i].y - things[0].y);
      if (gap < things[i].radius + things[0].radius + 0.2) {
        groups[0].insert(groups[0].end(), groups[i].begin(), groups[i].end());
        groups[i].clear();
      }
    }
    groups.erase(std::remove_if(groups.begin(), groups.end(), [](const auto& g) { return g.size() < 2; }),
                 groups.end());
    shown_ = groups.size();
    points_ = points;
    tracks_.update(stamp_, points_, std::vector<char>(points.size(), explained ? 1 : 0), absent, groups);
  }

  /// What the map must show: number and points of each track but those told.
  [[nodiscard]] std::vector<pc::ObjectTracks::Place> places(const std::set<int>& but = {}) const {
    return tracks_.placesBut(but, points_);
  }
  bool explained{false};  ///< whether a registered body explains the points that are shown

  [[nodiscard]] const std::vector<pc::TrackedObject>& tracked() const { return tracks_.believed(); }
  [[nodiscard]] std::vector<int> numbers() const {
    std::vector<int> numbers;
    for (const pc::TrackedObject& t : tracked()) {
      numbers.push_back(t.number);
    }
    return numbers;
  }
  /// Number of the track that is nearest to a place; 0 = none within 0.15 m.
  [[nodiscard]] int numberAt(double x, double y) const {
    for (const pc::TrackedObject& t : tracked()) {
      if (std::hypot(t.position.x() - x, t.position.y() - y) < 0.15) {
        return t.number;
      }
    }
    return 0;
  }
  [[nodiscard]] std::size_t shown() const { return shown_; }
  [[nodiscard]] pc::StampNs stamp() const { return stamp_; }
  pc::ObjectTracks& tracks() { return tracks_; }

 private:
  void add(std::vector<pc::MergedPoint>& points, int camera, const Eigen::Vector3d& place) {
    const Eigen::Vector3d u = (place - kPlaces[camera]).normalized();
    std::normal_distribution<double> noise(0.0, 0.02);
    const Eigen::Vector3f seen = (place + noise(random_) * u).cast<float>();
    const Eigen::Vector3f ray = u.cast<float>();
    points.push_back({seen.x(), seen.y(), seen.z(), 0.02F, ray.x(), ray.y(), ray.z(), camera});
  }

  void addWall(std::vector<pc::MergedPoint>& points, int camera, const Wall& wall) {
    const Eigen::Vector3d size = wall.box.sizes();
    const Eigen::Vector3d& from = kPlaces[camera];
    for (double a = 0.02; a < 1.0; a += 0.04) {
      for (double b = 0.02; b < 1.0; b += 0.04) {
        const double x = from.x() < wall.box.min().x() ? wall.box.min().x() : wall.box.max().x();
        add(points, camera, {x, wall.box.min().y() + a * size.y(), wall.box.min().z() + b * size.z()});
        add(points, camera, {wall.box.min().x() + a * size.x(), wall.box.min().y() + b * size.y(), wall.box.max().z()});
      }
    }
  }

  void addCylinder(std::vector<pc::MergedPoint>& points, int camera, const Cylinder& c, const std::vector<Wall>& walls,
                   pc::ObjectTracks::Group& group) {
    for (int turn = 0; turn < 24; ++turn) {
      const double angle = M_PI * turn / 12.0;
      const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0.0);
      for (double z = 0.1; z < c.height + 0.05; z += 0.1) {
        const Eigen::Vector3d place(c.x + c.radius * out.x(), c.y + c.radius * out.y(), z);
        const bool in = place.cwiseAbs().head<2>().maxCoeff() < 2.5;
        if (in && out.dot(kPlaces[camera] - place) > 0.0 && !isHidden(kPlaces[camera], place, walls)) {
          group.push_back(static_cast<std::uint32_t>(points.size()));
          add(points, camera, place);
        }
      }
    }
  }

  pc::StampNs step_ns_;
  std::mt19937_64 random_;
  pc::StampNs stamp_{0};
  std::size_t shown_{0};
  std::vector<pc::MergedPoint> points_;
  pc::ObjectTracks tracks_{pc::AssociationParams{}};
};

TEST(Tracks, AreBornInTheSecondSet) {
  Stage stage(1, 30.0);
  stage.step({{0.0, 0.0}});
  EXPECT_TRUE(stage.tracked().empty());
  stage.step({{0.0, 0.0}});
  ASSERT_EQ(stage.tracked().size(), 1U);
  EXPECT_EQ(stage.tracked()[0].first_seen_ns, stage.stamp() / 2);
  EXPECT_NEAR(stage.tracked()[0].position.x(), 0.0, 0.04);
  EXPECT_NEAR(stage.tracked()[0].extent.y(), 0.5, 0.08);
}

TEST(Tracks, ASpeckInOneSetIsNone) {
  Stage stage(2, 30.0);
  stage.step({{0.0, 0.0}});
  for (int set = 0; set < 5; ++set) {
    stage.step({});
    EXPECT_TRUE(stage.tracked().empty());
  }
}

TEST(Tracks, WhatIsTakenAwayIsGoneInTheSecondSetThatLooksThroughItsPlace) {
  Stage stage(3, 30.0);
  for (int set = 0; set < 5; ++set) {
    stage.step({{0.5, 0.2}});
  }
  stage.step({});
  ASSERT_EQ(stage.tracked().size(), 1U);
  EXPECT_FALSE(stage.tracked()[0].hidden);
  EXPECT_LT(stage.tracked()[0].last_seen_ns, stage.stamp());
  stage.step({});
  EXPECT_TRUE(stage.tracked().empty());
}

TEST(Tracks, WhatACameraThatIsAwayHasSeenStays) {
  Stage stage(4, 30.0);
  for (int set = 0; set < 5; ++set) {
    stage.step({{0.5, 0.2}});
  }
  for (int set = 0; set < 30; ++set) {
    stage.step({}, {}, kCameras);  // none looks
    ASSERT_EQ(stage.numbers(), std::vector<int>{1}) << set;
    EXPECT_TRUE(stage.tracked()[0].hidden);
  }
  stage.step({{0.5, 0.2}});
  EXPECT_EQ(stage.numbers(), std::vector<int>{1});
  EXPECT_FALSE(stage.tracked()[0].hidden);
}

/// A low thing passes between a wall and where the only camera cannot see it.
class BehindAWall : public ::testing::Test {
 protected:
  static constexpr int kOnly = 3;  // the camera at (-3, 0, 2)
  const Wall wall_{{Eigen::Vector3d(-0.1, -0.5, 0.0), Eigen::Vector3d(0.0, 0.5, 1.25)}};
  static Cylinder at(double y) { return {0.3, y, 0.15, 0.4}; }
};

TEST_F(BehindAWall, ItComesBackAsTheSame) {
  Stage stage(5, 30.0);
  int unseen = 0;
  for (double y = -1.5; y < 1.5; y += 0.8 / 30.0) {
    stage.step({at(y)}, {wall_}, kOnly);
    unseen += stage.shown() == 0 ? 1 : 0;
    if (y > -1.4) {
      ASSERT_EQ(stage.numbers(), std::vector<int>{1}) << "y " << y;
      EXPECT_EQ(stage.tracked()[0].hidden, stage.shown() == 0) << "y " << y;
    }
  }
  EXPECT_GT(unseen, 20);
}

TEST_F(BehindAWall, ItMayStopThereAndComeOutAgain) {
  Stage stage(6, 30.0);
  double y = -1.5;
  for (; y < 0.0; y += 0.8 / 30.0) {
    stage.step({at(y)}, {wall_}, kOnly);
  }
  for (int set = 0; set < 150; ++set) {
    stage.step({at(y)}, {wall_}, kOnly);
    ASSERT_EQ(stage.numbers(), std::vector<int>{1}) << set;
    EXPECT_TRUE(stage.tracked()[0].hidden);
  }
  for (; y < 1.5; y += 0.8 / 30.0) {
    stage.step({at(y)}, {wall_}, kOnly);
  }
  EXPECT_EQ(stage.numbers(), std::vector<int>{1});
}

TEST_F(BehindAWall, ItIsGoneWhenTheWallIsGoneAndNothingIsThere) {
  Stage stage(7, 30.0);
  for (double y = -1.5; y < 0.0; y += 0.8 / 30.0) {
    stage.step({at(y)}, {wall_}, kOnly);
  }
  for (int set = 0; set < 30; ++set) {
    stage.step({}, {wall_}, kOnly);
  }
  ASSERT_EQ(stage.numbers(), std::vector<int>{1});
  for (int set = 0; set < 3; ++set) {
    stage.step({}, {}, kOnly);
  }
  EXPECT_TRUE(stage.tracked().empty());
}

TEST_F(BehindAWall, ItEndsWhereSomethingRegisteredStands) {
  Stage stage(8, 30.0);
  for (double y = -1.5; y < 0.0; y += 0.8 / 30.0) {
    stage.step({at(y)}, {wall_}, kOnly);
  }
  stage.tracks().dissolve([](const Eigen::Vector3f& p) { return p.x() > 1.0F; });
  stage.step({}, {wall_}, kOnly);
  EXPECT_EQ(stage.numbers(), std::vector<int>{1});
  stage.tracks().dissolve([](const Eigen::Vector3f& p) { return p.x() > 0.1F; });
  stage.step({}, {wall_}, kOnly);
  EXPECT_TRUE(stage.tracked().empty());
}

/// Middle of some points, x and y, metres.
Eigen::Vector2f middleOf(const std::vector<Eigen::Vector3f>& points) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : points) {
    box.extend(p);
  }
  return box.center().head<2>();
}

TEST_F(BehindAWall, TheMapKeepsItWhereItMayBe) {
  Stage stage(9, 30.0);
  double y = -1.5;
  for (; y < 0.0; y += 0.8 / 30.0) {
    stage.step({at(y)}, {wall_}, kOnly);
  }
  for (int set = 0; set < 150; ++set) {
    stage.step({at(y)}, {wall_}, kOnly);
    ASSERT_EQ(stage.places().size(), 1U) << set;
    EXPECT_TRUE(stage.places()[0].source.empty());
    EXPECT_GT(stage.places()[0].points.size(), 10U);
  }
  EXPECT_TRUE(stage.places({1}).empty()) << "what the map has already";
  const Eigen::Vector2f place = middleOf(stage.places()[0].points);
  EXPECT_NEAR(place.x(), 0.25F, 0.15F);
  EXPECT_LT(std::abs(place.y()), 0.7F);
  for (int set = 0; set < 3; ++set) {
    stage.step({}, {}, kOnly);
  }
  EXPECT_TRUE(stage.places().empty());
}

TEST_F(BehindAWall, WhatStandsWhenItIsHiddenStaysThere) {
  Stage stage(10, 30.0);
  for (int set = 0; set < 30; ++set) {
    stage.step({at(0.1)}, {}, kOnly);
  }
  for (int set = 0; set < 1800; ++set) {
    stage.step({at(0.1)}, {wall_}, kOnly);
  }
  ASSERT_EQ(stage.places().size(), 1U);
  const Eigen::Vector2f place = middleOf(stage.places()[0].points);
  EXPECT_NEAR(place.x(), 0.25F, 0.1F);
  EXPECT_NEAR(place.y(), 0.1F, 0.05F);
}

TEST(Tracks, OneOfWhichEveryPointHasBecomeARegisteredBodysIsGone) {
  Stage stage(11, 30.0);
  for (int set = 0; set < 5; ++set) {
    stage.step({{0.5, 0.2}});
  }
  stage.explained = true;
  const std::vector<Wall> body{{{Eigen::Vector3d(0.25, -0.05, 0.0), Eigen::Vector3d(0.75, 0.45, 1.2)}}};
  for (int set = 0; set < 2; ++set) {
    stage.step({}, body);
  }
  EXPECT_TRUE(stage.tracked().empty());
}

TEST(Tracks, TwoThatCrossKeepTheirNumbers) {
  for (const std::uint64_t seed : {11, 12, 13}) {
    for (const double rate_hz : {10.0, 30.0}) {
      Stage stage(seed, rate_hz);
      int first = 0;
      int second = 0;
      for (double s = 0.0; s < 2.4; s += 1.0 / rate_hz) {
        const Cylinder a{-1.2 + s, -0.15};
        const Cylinder b{1.2 - s, 0.45};
        stage.step({a, b});
        if (s < 0.5) {
          first = stage.numberAt(a.x, a.y);
          second = stage.numberAt(b.x, b.y);
        }
      }
      EXPECT_NE(first, 0);
      EXPECT_NE(second, 0);
      EXPECT_EQ(stage.numbers().size(), 2U) << "seed " << seed << ", " << rate_hz << " Hz";
      EXPECT_EQ(stage.numberAt(1.2, -0.15), first) << "seed " << seed << ", " << rate_hz << " Hz";
      EXPECT_EQ(stage.numberAt(-1.2, 0.45), second) << "seed " << seed << ", " << rate_hz << " Hz";
    }
  }
}

TEST(Tracks, WhoWalksOutOfTheVolumeIsGone) {
  Stage stage(9, 30.0);
  for (double x = 1.0; x < 3.7; x += 1.0 / 30.0) {
    stage.step({{x, 0.9}});
    EXPECT_EQ(stage.numbers(), x < 1.03 ? std::vector<int>{} : std::vector<int>{1}) << "x " << x;
  }
  for (int set = 0; set < 5; ++set) {
    stage.step({});
  }
  EXPECT_TRUE(stage.tracked().empty());
}

// ---- walks through the synthetic cell, seen by its cameras with their noise

constexpr double kRadius = 0.25;

struct Walk {
  double speed;
  double rate_hz;
  std::uint64_t seed;
};

std::ostream& operator<<(std::ostream& out, const Walk& walk) {
  return out << walk.speed << " m/s, " << walk.rate_hz << " Hz, seed " << walk.seed;
}

class ObliqueWalk : public ::testing::TestWithParam<Walk> {};

TEST_P(ObliqueWalk, IsOneTrackWithTheRightVelocitySoonAfterTheFirstContact) {
  const auto& [speed, rate_hz, seed] = GetParam();
  SceneFactory factory(seed);
  Scene scene = standardCell(1, 0);
  Body person{"person", pc::ObjectKind::kObstacle, false, false, true, "person", {"person"}, {}};
  person.solids = {{pc::Solid::Shape::kCylinder, {kRadius, 0.0, 1.7}, Eigen::Isometry3d::Identity(), "person"}};
  scene.bodies.push_back(person);
  const auto backend = pc::makeBackend("fused", {}, {});
  const auto associator = pc::makeAssociator("yarm", {});
  const pc::Knowledge knowledge = scene.knowledge();
  const Eigen::Vector3d velocity(speed * std::cos(0.5), speed * std::sin(0.5), 0.0);
  const Eigen::Vector3d start(-2.5 - kRadius, -1.7, 0.85);  // touches the border at t = 0
  pc::MergedSet set;
  std::set<int> numbers;
  std::set<std::string> in_map;
  double reported_s = -1.0;
  int lost = 0;
  double worst = 0.0;
  for (int k = -4; k < static_cast<int>(std::min(2.0, 2.4 / speed + 1.0) * rate_hz); ++k) {
    const double t = (k + 0.5) / rate_hz;
    const Eigen::Vector3d place = start + t * velocity;
    scene.poses["person"] = pose(place.x(), place.y(), place.z());
    factory.render(scene);
    const auto stamp = static_cast<pc::StampNs>(1e9 * (t + 10.0));
    backend->merge(factory.clouds(stamp), set);
    const auto seeds = scene.seeds(stamp);
    const pc::AssociatedSet& result = associator->associate({&set, &seeds, &knowledge, &scene.poses, false});
    for (const pc::AssociatedObject& object : result.objects) {
      if (object.is_unknown && object.points.size() > 20) {
        in_map.insert(object.name);
      }
    }
    const pc::TrackedObject* track = nullptr;
    for (const pc::TrackedObject& one : associator->tracks()) {
      const bool here = (one.position - place).head<2>().norm() < kRadius + 0.2;
      if (here && one.last_seen_ns == set.stamp_ns) {
        track = &one;
        numbers.insert(one.number);
      }
    }
    if (track == nullptr) {
      lost += reported_s >= 0.0 ? 1 : 0;
      continue;
    }
    reported_s = reported_s < 0.0 ? t : reported_s;
    if (t > 0.5) {
      worst = std::max(worst, (track->velocity - velocity).head<2>().norm());
      EXPECT_LT((track->velocity - velocity).head<2>().norm(), 0.2) << GetParam() << ", " << t << " s";
    }
  }
  std::printf("%.1f m/s, %2.0f Hz: reported after %.3f s, velocity off by at most %.3f m/s, lost in %d sets\n", speed,
              rate_hz, reported_s, worst, lost);
  EXPECT_EQ(numbers.size(), 1U) << GetParam();
  EXPECT_EQ(in_map.size(), 1U) << GetParam();
  EXPECT_EQ(lost, 0) << GetParam();
  EXPECT_GE(reported_s, 0.0) << GetParam();
  if (speed > 1.0) {  // a slow one shows too little of itself so soon, and births take two sets
    EXPECT_LE(reported_s, std::max(0.1, 2.0 / rate_hz)) << GetParam();
  }
}

INSTANTIATE_TEST_SUITE_P(SpeedsAndRates, ObliqueWalk,
                         ::testing::Values(Walk{0.3, 10.0, 1}, Walk{0.3, 15.0, 2}, Walk{0.3, 30.0, 3},
                                           Walk{1.6, 10.0, 4}, Walk{1.6, 15.0, 5}, Walk{1.6, 30.0, 6}));

}  // namespace
}  // namespace yarm::test
