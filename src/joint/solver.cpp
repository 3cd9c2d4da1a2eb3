#include "solver.hpp"

#include <algorithm>
#include <utility>

namespace yarm::joint {
namespace {

// Stops of a robot in the searches that come before the complete one.
constexpr std::size_t kStops[] = {24, 128};
// Robots with this many times as many places as stops, or fewer, are searched for by every edge alone.
constexpr std::size_t kFewPlaces = 3;
// Look-ups that the searches take in turns.
constexpr std::int64_t kTurn = 500000;
// Look-ups that a search for a cheaper stretch may take, and moves in a stretch.
constexpr std::int64_t kStretchWork = 300000;
constexpr std::size_t kStretches[] = {24, 60, 12};

// Whether two robots can stand on their goals at the same time.
bool goalsFit(const Fleet& fleet, std::size_t i, std::size_t j) {
  if (!fleet.graph(i).hasGoal() || !fleet.graph(j).hasGoal()) {
    return true;
  }
  for (const Place mine : fleet.graph(i).goals()) {
    for (const Place theirs : fleet.graph(j).goals()) {
      if (fleet.apart(i, mine, j, theirs) || fleet.apart(j, theirs, i, mine)) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

Solver::Solver(Fleet fleet, std::int64_t memory_bytes)
    : fleet_(std::move(fleet)), memory_bytes_(memory_bytes), start_(fleet_.size(), 0) {
  for (std::size_t i = 0; i < fleet_.size(); ++i) {
    const RobotGraph& graph = fleet_.graph(i);
    to_go_.push_back(graph.hasGoal() ? graph.costsTo(graph.goals()) : std::vector<Cost>(graph.size(), 0));
    impossible_ = impossible_ || to_go_.back()[0] >= kFar;
    for (std::size_t j = 0; j < i; ++j) {
      impossible_ = impossible_ || !goalsFit(fleet_, j, i);
    }
  }
  std::size_t most = 0;
  for (std::size_t i = 0; i < fleet_.size(); ++i) {
    most = std::max(most, static_cast<std::size_t>(fleet_.graph(i).size()));
  }
  for (const std::size_t stops : kStops) {
    if (stops * kFewPlaces < most) {
      stages_.push_back({nullptr, stops});
    }
  }
  stages_.push_back({nullptr, 0});
}

Search& Solver::searchOf(Stage* stage) {
  if (!stage->search) {
    SearchParams params;
    params.memory_bytes = memory_bytes_ / static_cast<std::int64_t>(stages_.size());
    for (std::size_t i = 0; stage->stops > 0 && i < fleet_.size(); ++i) {
      const RobotGraph& graph = fleet_.graph(i);
      std::vector<std::uint8_t> stops(graph.size(), 0);
      for (const Place p : graph.spread(stage->stops)) {
        stops[p] = 1;
      }
      for (const Place p : graph.goals()) {
        stops[p] = 1;
      }
      params.stops.push_back(std::move(stops));
    }
    stage->search = std::make_unique<Search>(fleet_, start_, to_go_, std::move(params));
  }
  return *stage->search;
}

Outcome Solver::run(std::int64_t work) {
  if (impossible_) {
    return Outcome::kExhausted;
  }
  const std::int64_t until = this->work() + work;
  while (!found_ && this->work() < until) {
    bool any = false;
    for (Stage& stage : stages_) {
      if (stage.ended) {
        continue;
      }
      any = true;
      Search& search = searchOf(&stage);
      const Outcome outcome = search.found() ? Outcome::kFound : search.advance(kTurn);
      if (outcome == Outcome::kFound) {
        plan_ = unitPlan(start_, search.plan());
        found_ = true;
        break;
      }
      if (outcome == Outcome::kExhausted && stage.stops == 0) {
        impossible_ = true;
        return outcome;
      }
      stage.ended = outcome != Outcome::kOpen;
    }
    if (!any) {
      return Outcome::kFull;
    }
  }
  return found_ ? Outcome::kFound : Outcome::kOpen;
}

std::int64_t Solver::visited() const {
  std::int64_t visited = improving_visited_;
  for (const Stage& stage : stages_) {
    visited += stage.search ? stage.search->visited() : 0;
  }
  return visited;
}

std::int64_t Solver::work() const {
  std::int64_t work = improving_work_;
  for (const Stage& stage : stages_) {
    work += stage.search ? stage.search->work() : 0;
  }
  return work;
}

std::vector<UnitMove> Solver::unitPlan(Places places, const std::vector<Leg>& legs) const {
  std::vector<UnitMove> moves;
  for (const Leg& leg : legs) {
    const std::vector<Place> way = unitMoves(fleet_, places, leg);
    for (std::size_t k = 1; k < way.size(); ++k) {
      moves.push_back({leg.robot, way[k]});
    }
    places[leg.robot] = leg.to;
  }
  return moves;
}

std::vector<Places> Solver::configurations() const {
  std::vector<Places> at{start_};
  for (const UnitMove& move : plan_) {
    at.push_back(at.back());
    at.back()[move.robot] = move.to;
  }
  return at;
}

Cost Solver::costOf(const std::vector<UnitMove>& moves, std::size_t begin, std::size_t end) const {
  Places at = start_;
  Cost cost = 0;
  for (std::size_t k = 0; k < end; ++k) {
    const RobotGraph& graph = fleet_.graph(moves[k].robot);
    Place& place = at[moves[k].robot];
    const Edge* edge = graph.begin(place);
    while (edge != graph.end(place) && edge->to != moves[k].to) {
      ++edge;
    }
    cost += k >= begin && edge != graph.end(place) ? edge->cost : 0;
    place = moves[k].to;
  }
  return cost;
}

void Solver::improve(std::int64_t work) {
  const std::int64_t until = this->work() + work;
  improveWhole(work / 2);
  bool better = true;
  while (better && this->work() < until) {
    better = false;
    for (const std::size_t length : kStretches) {
      std::vector<Places> at = configurations();
      for (std::size_t begin = 0; begin + 1 < plan_.size() && this->work() < until;) {
        const std::size_t end = std::min(plan_.size(), begin + length);
        if (improveStretch(begin, end, at, kStretchWork)) {
          better = true;
          at = configurations();
        } else {
          begin += length / 2;
        }
      }
    }
  }
}

void Solver::improveWhole(std::int64_t work) {
  Cost least = 0;
  for (std::size_t i = 0; i < fleet_.size(); ++i) {
    least += to_go_[i][0];
  }
  if (!found_ || cost() <= least) {
    return;
  }
  SearchParams params;
  params.greedy = false;
  params.weight = 1;
  params.below = cost();
  params.memory_bytes = memory_bytes_;
  Search search(fleet_, start_, to_go_, std::move(params));
  search.advance(work);
  if (search.found()) {
    plan_ = unitPlan(start_, search.plan());
  }
  improving_work_ += search.work();
  improving_visited_ += search.visited();
}

bool Solver::improveStretch(std::size_t begin, std::size_t end, const std::vector<Places>& at, std::int64_t work) {
  std::vector<std::uint8_t> movable(fleet_.size(), 0);
  for (std::size_t k = begin; k < end; ++k) {
    movable[plan_[k].robot] = 1;
  }
  std::vector<std::vector<Cost>> to_go(fleet_.size());
  Cost least = 0;
  const Cost now = costOf(plan_, begin, end);
  for (std::size_t i = 0; i < fleet_.size(); ++i) {
    const bool last = end == plan_.size() && fleet_.graph(i).hasGoal();
    if (!movable[i]) {
      to_go[i].assign(fleet_.graph(i).size(), 0);
    } else if (last) {
      to_go[i] = to_go_[i];
    } else if (end == plan_.size()) {
      to_go[i].assign(fleet_.graph(i).size(), 0);
    } else {
      to_go[i] = fleet_.graph(i).costsTo({at[end][i]});
    }
    least += to_go[i][at[begin][i]];
    improving_work_ += fleet_.graph(i).size();
  }
  if (now <= least) {
    return false;
  }
  SearchParams params;
  params.greedy = false;
  params.weight = 1;
  params.below = now;
  params.movable = movable;
  params.memory_bytes = memory_bytes_;
  Search search(fleet_, at[begin], to_go, std::move(params));
  search.advance(work);
  improving_work_ += search.work();
  improving_visited_ += search.visited();
  if (!search.found()) {
    return false;
  }
  std::vector<UnitMove> moves(plan_.begin(), plan_.begin() + static_cast<std::ptrdiff_t>(begin));
  const std::vector<UnitMove> between = unitPlan(at[begin], search.plan());
  moves.insert(moves.end(), between.begin(), between.end());
  moves.insert(moves.end(), plan_.begin() + static_cast<std::ptrdiff_t>(end), plan_.end());
  plan_ = std::move(moves);
  return true;
}

}  // namespace yarm::joint
