// The sparse optimisation against solutions known in closed form.
#include "yarm/slam/pose_graph.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace yarm::slam {
namespace {

PoseEdge edge(int from, int to, const Pose2& difference, double sigma_m = 0.01, double sigma_rad = 0.01) {
  const Eigen::Vector3d information(1.0 / (sigma_m * sigma_m), 1.0 / (sigma_m * sigma_m),
                                    1.0 / (sigma_rad * sigma_rad));
  return {from, to, difference, information.asDiagonal(), false};
}

GraphParams thorough() {
  GraphParams params;
  params.iterations = 50;
  params.converged = 1e-12;
  params.cauchy = 1000.0;  // as good as squares
  return params;
}

TEST(PoseTest, ComposesInvertsAndWraps) {
  const Pose2 a{1.0, 2.0, 3.0};
  const Pose2 b{-0.5, 0.3, 2.0};
  const Pose2 back = a.inverse() * (a * b);
  EXPECT_NEAR(back.x, b.x, 1e-12);
  EXPECT_NEAR(back.y, b.y, 1e-12);
  EXPECT_NEAR(back.yaw, b.yaw, 1e-12);
  EXPECT_LE(std::abs((a * b).yaw), M_PI);
  const Eigen::Vector2d point = Pose2{1.0, 0.0, M_PI / 2} * Eigen::Vector2d(1.0, 0.0);
  EXPECT_NEAR(point.x(), 1.0, 1e-12);
  EXPECT_NEAR(point.y(), 1.0, 1e-12);
}

TEST(GraphTest, ACollinearLoopSharesItsErrorByVariance) {
  // 0 -> 1 -> 2 measured 1 m each, 0 -> 2 measured 2.3 m: least squares gives each step its share of the 0.3 m.
  const std::vector<Pose2> start{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const GraphResult result =
      optimize(start, {edge(0, 1, {1, 0, 0}), edge(1, 2, {1, 0, 0}, 0.02), edge(0, 2, {2.3, 0, 0})}, thorough());
  ASSERT_TRUE(result.ok) << result.reason;
  // Variances 1, 4 and 1 (in 1e-4 m^2): corrections 0.05, 0.20 and -0.05.
  EXPECT_NEAR(result.poses[1].x, 1.05, 1e-5);
  EXPECT_NEAR(result.poses[2].x, 2.25, 1e-5);
  EXPECT_NEAR(result.poses[2].y, 0.0, 1e-9);
  EXPECT_LT(result.error_after, result.error_before);
}

TEST(GraphTest, HeadingAroundALoopIsShared) {
  // Turns of 90.9 deg four times about one point: the loop closes at 360 deg, so each gives back 0.9 deg.
  const double turn = 1.01 * M_PI / 2;
  std::vector<Pose2> start{{0, 0, 0}};
  std::vector<PoseEdge> edges;
  for (int i = 1; i < 4; ++i) {
    start.push_back(start.back() * Pose2{0, 0, turn});
    edges.push_back(edge(i - 1, i, {0, 0, turn}));
  }
  edges.push_back(edge(3, 0, {0, 0, turn}));
  const GraphResult result = optimize(start, edges, thorough());
  ASSERT_TRUE(result.ok) << result.reason;
  for (int i = 1; i < 4; ++i) {
    EXPECT_NEAR(wrapAngle(result.poses[i].yaw - i * M_PI / 2), 0.0, 1e-6) << i;
  }
}

// A square driven twice with noisy odometry and exact ties between the rounds.
struct Loop {
  std::vector<Pose2> truth;
  std::vector<Pose2> odometry{{0, 0, 0}};
  std::vector<PoseEdge> edges;

  explicit Loop(unsigned seed, int count = 80) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise;
    Pose2 pose;
    truth.push_back(pose);
    for (int i = 1; i < count; ++i) {
      const Pose2 step{0.5, 0.0, i % 10 == 0 ? M_PI / 2 : 0.0};
      truth.push_back(truth.back() * step);
      const Pose2 measured{step.x + 0.02 * noise(random), 0.02 * noise(random), step.yaw + 0.02 * noise(random)};
      odometry.push_back(odometry.back() * measured);
      edges.push_back(edge(i - 1, i, measured, 0.02, 0.02));
    }
  }
  void tie(int from, int to) { edges.push_back(edge(from, to, truth[from].inverse() * truth[to], 0.005, 0.005)); }
  [[nodiscard]] double error(const std::vector<Pose2>& poses) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      sum += std::pow(poses[i].distanceTo(truth[i]), 2);
    }
    return std::sqrt(sum / static_cast<double>(poses.size()));
  }
};

TEST(GraphTest, ClosingLoopsAtLeastHalvesTheError) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Loop loop(seed);
    for (int i = 0; i < 40; i += 5) {
      loop.tie(i, i + 40);
    }
    const GraphResult result = optimize(loop.odometry, loop.edges, thorough());
    ASSERT_TRUE(result.ok) << result.reason;
    EXPECT_LT(loop.error(result.poses), 0.5 * loop.error(loop.odometry)) << "seed " << seed;
  }
}

TEST(GraphTest, AWrongTieIsOutvoted) {
  Loop loop(3);
  for (int i = 0; i < 40; i += 5) {
    loop.tie(i, i + 40);
  }
  GraphParams robust;
  robust.iterations = 50;
  const double good = loop.error(optimize(loop.odometry, loop.edges, robust).poses);
  loop.edges.push_back(edge(5, 60, {3.0, -2.0, 1.0}, 0.005, 0.005));
  const double with_lie = loop.error(optimize(loop.odometry, loop.edges, robust).poses);
  const double believed = loop.error(optimize(loop.odometry, loop.edges, thorough()).poses);
  EXPECT_LT(with_lie, 1.5 * good + 0.01);
  EXPECT_GT(believed, 5.0 * good) << "without the robust cost the lie must hurt, or this test shows nothing";
}

TEST(GraphTest, TheFirstPoseStays) {
  Loop loop(5);
  for (Pose2& pose : loop.odometry) {
    pose = Pose2{4.0, -1.0, 2.0} * pose;
  }
  const GraphResult result = optimize(loop.odometry, loop.edges, thorough());
  EXPECT_EQ(result.poses[0].x, loop.odometry[0].x);
  EXPECT_EQ(result.poses[0].yaw, loop.odometry[0].yaw);
}

TEST(GraphTest, WhatCannotBeSolvedIsRefusedWithAReason) {
  const std::vector<Pose2> two{{0, 0, 0}, {1, 0, 0}};
  GraphResult result = optimize({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {edge(0, 1, {1, 0, 0})}, thorough());
  EXPECT_FALSE(result.ok) << "pose 2 is tied to nothing";
  EXPECT_NE(result.reason.find("tied"), std::string::npos) << result.reason;
  EXPECT_EQ(result.poses[1].x, 1.0);
  result = optimize(two, {edge(0, 7, {1, 0, 0})}, thorough());
  EXPECT_NE(result.reason.find("7"), std::string::npos) << result.reason;
  result = optimize(two, {edge(0, 1, {std::numeric_limits<double>::infinity(), 0, 0})}, thorough());
  EXPECT_NE(result.reason.find("not finite"), std::string::npos) << result.reason;
  result = optimize({{0, 0, 0}, {std::numeric_limits<double>::quiet_NaN(), 0, 0}}, {edge(0, 1, {1, 0, 0})}, thorough());
  EXPECT_NE(result.reason.find("not finite"), std::string::npos) << result.reason;
}

TEST(GraphTest, NothingAndOnePoseAreFine) {
  EXPECT_TRUE(optimize({}, {}, thorough()).ok);
  EXPECT_TRUE(optimize({{1, 2, 3}}, {}, thorough()).ok);
}

}  // namespace
}  // namespace yarm::slam
