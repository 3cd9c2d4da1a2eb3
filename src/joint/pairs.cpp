#include "pairs.hpp"

#include <algorithm>

namespace yarm::joint {
namespace {

constexpr std::int64_t kEdges = 8;

// Places that end a robot's way.
std::vector<Place> endsOf(const Fleet& fleet, std::size_t i) {
  if (fleet.hasGoal(i)) {
    return fleet.goals(i);
  }
  std::vector<Place> all;
  for (Place p = 0; p < fleet.graph(i).size(); ++p) {
    all.push_back(p);
  }
  return all;
}

}  // namespace

std::int64_t Pairs::lookUps(const Fleet& fleet) {
  std::int64_t sum = fleet.hasNear() ? kTooMany : 0;
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    for (std::size_t j = i + 1; j < fleet.size(); ++j) {
      sum += kEdges * fleet.graph(i).size() * fleet.graph(j).size();
    }
  }
  return sum;
}

Pairs::Pairs(const Fleet& fleet, const std::vector<std::vector<Cost>>& to_go)
    : fleet_(fleet), n_(fleet.size()), tables_(n_ * n_) {
  for (std::size_t i = 0; i < n_; ++i) {
    for (std::size_t j = i + 1; j < n_; ++j) {
      fill(i, j, to_go[i], to_go[j]);
      tables_[j * n_ + i].transposed = true;
      tables_[j * n_ + i].width = tables_[i * n_ + j].width;
    }
  }
}

Cost Pairs::extraOf(std::size_t i, Place place, const Places& places) const {
  Cost sum = 0;
  for (std::size_t j = 0; j < n_ && sum < kFar; ++j) {
    sum += j == i ? 0 : std::min(kFar - sum, extra(i, place, j, places[j]));
  }
  return sum;
}

Cost Pairs::extraOf(const Places& places) const {
  Cost sum = 0;
  for (std::size_t i = 0; i < n_ && sum < kFar; ++i) {
    for (std::size_t j = i + 1; j < n_ && sum < kFar; ++j) {
      sum += std::min(kFar - sum, extra(i, places[i], j, places[j]));
    }
  }
  return sum;
}

// Backwards from where both are on their goals, by rising cost.
void Pairs::fill(std::size_t i, std::size_t j, const std::vector<Cost>& mine, const std::vector<Cost>& theirs) {
  const RobotGraph& one = fleet_.graph(i);
  const RobotGraph& other = fleet_.graph(j);
  const std::size_t width = static_cast<std::size_t>(other.size());
  std::vector<Cost> costs(static_cast<std::size_t>(one.size()) * width, kFar);
  std::vector<std::vector<std::size_t>> rings(
      static_cast<std::size_t>(std::max(one.greatestCost(), other.greatestCost())) + 1);
  std::size_t waiting = 0;
  const auto reach = [&](std::size_t state, Cost cost) {
    if (cost < costs[state]) {
      costs[state] = cost;
      rings[static_cast<std::size_t>(cost) % rings.size()].push_back(state);
      ++waiting;
    }
  };
  const std::vector<Place> ends = endsOf(fleet_, j);
  for (const Place p : endsOf(fleet_, i)) {
    for (const Place q : ends) {
      if (fleet_.apart(i, p, j, q)) {
        reach(static_cast<std::size_t>(p) * width + q, 0);
      }
    }
  }
  for (Cost now = 0; waiting > 0; ++now) {
    std::vector<std::size_t>& ring = rings[static_cast<std::size_t>(now) % rings.size()];
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const std::size_t state = ring[k];
      if (costs[state] != now) {
        continue;
      }
      const Place p = static_cast<Place>(state / width), q = static_cast<Place>(state % width);
      for (const Edge* back = one.beginBack(p); back != one.endBack(p); ++back) {
        if (fleet_.apart(i, back->to, j, q) && fleet_.clearOf(i, back->to, {p, back->cost, back->turn}, j, q)) {
          reach(static_cast<std::size_t>(back->to) * width + q, now + back->cost);
        }
      }
      for (const Edge* back = other.beginBack(q); back != other.endBack(q); ++back) {
        if (fleet_.apart(j, back->to, i, p) && fleet_.clearOf(j, back->to, {q, back->cost, back->turn}, i, p)) {
          reach(static_cast<std::size_t>(p) * width + back->to, now + back->cost);
        }
      }
    }
    waiting -= ring.size();
    ring.clear();
  }
  Table& table = tables_[i * n_ + j];
  table.width = width;
  table.cost.resize(costs.size());
  for (std::size_t state = 0; state < costs.size(); ++state) {
    const Cost extra = costs[state] - std::min(costs[state], mine[state / width] + theirs[state % width]);
    table.cost[state] = costs[state] >= kFar ? kNever : static_cast<std::uint16_t>(std::min<Cost>(extra, kNever - 1));
  }
}

}  // namespace yarm::joint
