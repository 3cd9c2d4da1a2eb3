// What the tracks of unknown things are made of: the best assignment, and the filter of a thing's edges.
#include "assignment.hpp"
#include "axis_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace yarm::test {
namespace {

namespace pc = yarm::perception;

// ---- assignment

double costOf(const std::vector<std::vector<double>>& costs, const std::vector<int>& columns, double without) {
  double sum = 0.0;
  for (std::size_t row = 0; row < costs.size(); ++row) {
    sum += columns[row] < 0 ? without : costs[row][static_cast<std::size_t>(columns[row])];
  }
  return sum;
}

/// Least cost over everything that is possible.
double leastCost(const std::vector<std::vector<double>>& costs, double without, std::size_t row, std::set<int>& used) {
  if (row == costs.size()) {
    return 0.0;
  }
  double best = without + leastCost(costs, without, row + 1, used);
  for (int column = 0; column < static_cast<int>(costs[row].size()); ++column) {
    const double cost = costs[row][static_cast<std::size_t>(column)];
    if (cost < without && used.insert(column).second) {
      best = std::min(best, cost + leastCost(costs, without, row + 1, used));
      used.erase(column);
    }
  }
  return best;
}

TEST(Assignment, IsTheBestOfAll) {
  constexpr std::uint64_t kSeed = 1;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> draw(0.0, 12.0);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<std::vector<double>> costs(random() % 6, std::vector<double>(random() % 6));
    for (auto& row : costs) {
      std::generate(row.begin(), row.end(), [&] { return draw(random); });
    }
    const std::vector<int> columns = pc::assignAtLeastCost(costs, 10.0);
    std::set<int> used;
    ASSERT_EQ(columns.size(), costs.size());
    ASSERT_NEAR(costOf(costs, columns, 10.0), leastCost(costs, 10.0, 0, used), 1e-9)
        << "seed " << kSeed << ", trial " << trial;
    for (const int column : columns) {
      ASSERT_TRUE(column < 0 || used.insert(column).second) << "seed " << kSeed << ", trial " << trial;
    }
  }
}

TEST(Assignment, IsNotGreedy) {
  EXPECT_EQ(pc::assignAtLeastCost({{1.0, 2.0}, {2.0, 9.0}}, 100.0), (std::vector<int>{1, 0}));
}

// ---- one axis

TEST(AxisFilter, AnEdgeAtTheBorderTellsNothingOfTheMotion) {
  constexpr double kDt = 1.0 / 30.0;
  constexpr double kSpeed = 1.6;
  pc::SeenEdges seen{-2.5, -2.45, true, false, 4e-4};
  pc::AxisFilter axis(seen);
  for (int set = 1; set <= 9; ++set) {  // it is 0.5 m long: still not the whole of it
    axis.predict(kDt);
    seen.high = -2.45 + kSpeed * kDt * set;
    axis.update(seen);
  }
  EXPECT_NEAR(axis.velocity(), kSpeed, 0.1);
  EXPECT_NEAR(axis.low(), -2.5, 1e-9);
}

TEST(AxisFilter, WhatComesOutFromBehindSomethingStands) {
  pc::SeenEdges seen{0.0, 0.2, false, false, 4e-4};
  pc::AxisFilter axis(seen);
  double fastest = 0.0;
  for (int set = 1; set <= 60; ++set) {
    axis.predict(1.0 / 30.0);
    seen.high = set < 30 ? 0.2 : 0.6;
    axis.update(seen);
    fastest = std::max(fastest, std::abs(axis.velocity()));
  }
  EXPECT_LT(fastest, 0.2);
  EXPECT_NEAR(axis.high(), 0.6, 0.05);
  EXPECT_NEAR(axis.low(), 0.0, 0.05);
}

}  // namespace
}  // namespace yarm::test
