#include "shorten.hpp"

#include <algorithm>
#include <cstdlib>
#include <list>
#include <utility>

namespace yarm::joint {
namespace {

// Moves of others that a robot's next move may be brought forward over.
constexpr std::size_t kForward = 3000;

Cost leastBetween(const Stand& a, const Stand& b) {
  return std::abs(a.x - b.x) + std::abs(a.y - b.y) + (a.heading == b.heading ? 0 : 1);
}

}  // namespace

const Edge* edgeBetween(const RobotGraph& graph, Place from, Place to) {
  const Edge* found = nullptr;
  for (const Edge* edge = graph.begin(from); edge != graph.end(from); ++edge) {
    if (edge->to == to && (found == nullptr || edge->cost < found->cost)) {
      found = edge;
    }
  }
  return found;
}

Shortener::Shortener(const Fleet& fleet) : fleet_(fleet) {
  Place most = 0;
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    most = std::max(most, fleet.graph(i).size());
  }
  cost_.assign(most, kFar);
  before_.assign(most, -1);
}

std::vector<UnitMove> Shortener::shortened(const std::vector<UnitMove>& plan, std::int64_t work) {
  const std::int64_t until = work_ + work;
  std::vector<UnitMove> moves = plan;
  bool better = true;
  while (better && work_ < until) {
    std::vector<Run> all = runs(moves);
    better = false;
    while (work_ < until && pass(&all, until)) {
      better = true;
    }
    moves.clear();
    for (const Run& run : all) {
      for (std::size_t k = 1; k < run.way.size(); ++k) {
        moves.push_back({run.robot, run.way[k]});
      }
    }
  }
  return moves;
}

std::vector<Shortener::Run> Shortener::runs(const std::vector<UnitMove>& plan) {
  struct Move {
    std::int32_t robot;
    Place from, to;
  };
  std::list<Move> left;
  Places at = fleet_.starts();
  for (const UnitMove& move : plan) {
    left.push_back({move.robot, at[move.robot], move.to});
    at[move.robot] = move.to;
  }
  std::vector<Run> found;
  while (!left.empty()) {
    const std::int32_t robot = left.front().robot;
    std::vector<Place> way{left.front().from, left.front().to};
    left.pop_front();
    std::vector<const Move*> passed;
    for (auto move = left.begin(); move != left.end() && passed.size() < kForward;) {
      if (move->robot != robot) {
        passed.push_back(&*move++);
        continue;
      }
      work_ += 1 + static_cast<std::int64_t>(passed.size()) / 4;
      const bool free = std::all_of(passed.begin(), passed.end(), [&](const Move* other) {
        return commute(robot, move->from, move->to, other->robot, other->from, other->to);
      });
      if (!free) {
        break;
      }
      way.push_back(move->to);
      move = left.erase(move);
    }
    found.push_back(runOf(robot, std::move(way)));
  }
  return found;
}

// Whether two moves may be made in either order.
bool Shortener::commute(std::int32_t i, Place from, Place to, std::int32_t j, Place other_from, Place other_to) {
  const Stand& here = fleet_.graph(i).stand(from);
  const Stand& there = fleet_.graph(j).stand(other_from);
  // Two moves by one column each.
  if (std::max(std::abs(here.x - there.x), std::abs(here.y - there.y)) > fleet_.reach() + 2) {
    return true;
  }
  work_ += 4;
  const Edge& mine = *edgeBetween(fleet_.graph(i), from, to);
  const Edge& theirs = *edgeBetween(fleet_.graph(j), other_from, other_to);
  return fleet_.clearOf(i, from, mine, j, other_from) && fleet_.clearOf(i, from, mine, j, other_to) &&
         fleet_.clearOf(j, other_from, theirs, i, from) && fleet_.clearOf(j, other_from, theirs, i, to);
}

bool Shortener::pass(std::vector<Run>* runs, std::int64_t until) {
  bool better = false;
  Places at = fleet_.starts();
  for (std::size_t k = 0; k < runs->size() && work_ < until;) {
    better = reroute(&(*runs)[k], at) || better;
    if (join(runs, k, at)) {
      better = true;
      continue;
    }
    at[(*runs)[k].robot] = (*runs)[k].way.back();
    ++k;
  }
  return better;
}

bool Shortener::reroute(Run* run, const Places& at) {
  Cost cost = 0;
  std::vector<Place> shorter = way(run->robot, run->way.front(), run->way.back(), at, run->cost, &cost);
  if (shorter.empty()) {
    return false;
  }
  run->way = std::move(shorter);
  run->cost = cost;
  return true;
}

// Makes one of run k and the robot's next one, at the time of either; or leaves run k out when it leads nowhere.
bool Shortener::join(std::vector<Run>* runs, std::size_t k, const Places& at) {
  const std::int32_t robot = (*runs)[k].robot;
  const Place from = (*runs)[k].way.front();
  if ((*runs)[k].way.size() == 1) {
    runs->erase(runs->begin() + static_cast<std::ptrdiff_t>(k));
    return true;
  }
  std::size_t next = k + 1;
  Places then = at;
  while (next < runs->size() && (*runs)[next].robot != robot) {
    then[(*runs)[next].robot] = (*runs)[next].way.back();
    ++next;
  }
  if (next == runs->size()) {
    const bool idle = !fleet_.hasGoal(robot) && standsClear(*runs, k + 1, next, robot, from);
    if (idle) {
      runs->erase(runs->begin() + static_cast<std::ptrdiff_t>(k));
    }
    return idle;
  }
  const Place to = (*runs)[next].way.back();
  const Cost now = (*runs)[k].cost + (*runs)[next].cost;
  // Fewer runs at the same cost are better too: each may be a stop.
  if (standsClear(*runs, k + 1, next, robot, from)) {
    Cost cost = 0;
    std::vector<Place> later = way(robot, from, to, then, now + 1, &cost);
    if (!later.empty()) {
      (*runs)[next] = {robot, std::move(later), cost};
      runs->erase(runs->begin() + static_cast<std::ptrdiff_t>(k));
      return true;
    }
  }
  if (standsClear(*runs, k + 1, next, robot, to)) {
    Cost cost = 0;
    std::vector<Place> sooner = way(robot, from, to, at, now + 1, &cost);
    if (!sooner.empty()) {
      (*runs)[k] = {robot, std::move(sooner), cost};
      runs->erase(runs->begin() + static_cast<std::ptrdiff_t>(next));
      return true;
    }
  }
  return false;
}

// Whether a robot may stand at a place while others make their runs.
bool Shortener::standsClear(const std::vector<Run>& runs, std::size_t begin, std::size_t end, std::int32_t i,
                            Place place) {
  for (std::size_t k = begin; k < end; ++k) {
    const Run& run = runs[k];
    const RobotGraph& graph = fleet_.graph(run.robot);
    work_ += static_cast<std::int64_t>(run.way.size());
    for (std::size_t m = 0; m + 1 < run.way.size(); ++m) {
      if (!fleet_.clearOf(run.robot, run.way[m], *edgeBetween(graph, run.way[m], run.way[m + 1]), i, place)) {
        return false;
      }
    }
  }
  return true;
}

// The cheapest way between the others, if it costs less than `below`; empty without one.
std::vector<Place> Shortener::way(std::int32_t i, Place from, Place to, const Places& at, Cost below, Cost* cost) {
  const RobotGraph& graph = fleet_.graph(i);
  const Stand& end = graph.stand(to);
  std::vector<std::vector<Place>> buckets;
  std::vector<Place> touched{from}, found;
  const auto push = [&](Place place) {
    const std::size_t f = static_cast<std::size_t>(cost_[place] + leastBetween(graph.stand(place), end));
    if (static_cast<Cost>(f) < below) {
      buckets.resize(std::max(buckets.size(), f + 1));
      buckets[f].push_back(place);
    }
  };
  cost_[from] = 0;
  before_[from] = -1;
  push(from);
  for (std::size_t f = 0; f < buckets.size();) {
    if (buckets[f].empty()) {
      ++f;
      continue;
    }
    const Place here = buckets[f].back();
    buckets[f].pop_back();
    if (static_cast<std::size_t>(cost_[here] + leastBetween(graph.stand(here), end)) != f) {
      continue;
    }
    if (here == to) {
      break;
    }
    for (const Edge* edge = graph.begin(here); edge != graph.end(here); ++edge) {
      const Cost further = cost_[here] + edge->cost;
      if (further >= cost_[edge->to] || further + leastBetween(graph.stand(edge->to), end) >= below) {
        continue;
      }
      work_ += static_cast<std::int64_t>(fleet_.size());
      if (fleet_.isFree(i, here, *edge, at)) {
        if (cost_[edge->to] == kFar) {
          touched.push_back(edge->to);
        }
        cost_[edge->to] = further;
        before_[edge->to] = here;
        push(edge->to);
      }
    }
  }
  *cost = cost_[to];
  for (Place p = to; *cost < below && p >= 0; p = before_[p]) {
    found.push_back(p);
  }
  std::reverse(found.begin(), found.end());
  for (const Place p : touched) {
    cost_[p] = kFar;
  }
  return found;
}

Shortener::Run Shortener::runOf(std::int32_t i, std::vector<Place> way) const {
  Cost cost = 0;
  for (std::size_t k = 0; k + 1 < way.size(); ++k) {
    cost += edgeBetween(fleet_.graph(i), way[k], way[k + 1])->cost;
  }
  return {i, std::move(way), cost};
}

}  // namespace yarm::joint
