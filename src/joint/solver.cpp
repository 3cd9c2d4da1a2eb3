#include "solver.hpp"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <utility>

#include "shorten.hpp"

namespace yarm::joint {
namespace {

// Look-ups after which, and at most for which, the costs of pairs are made.
constexpr std::int64_t kPairsAfter = 10000000;
constexpr std::int64_t kMostPairs = 60000000;
// Bytes that masks may take.
constexpr std::int64_t kMostMasks = std::int64_t{32} << 20;
// Stops of a robot in the searches that come before the complete one.
constexpr std::size_t kStops[] = {6, 24, 128};
// Look-ups that the searches take in turns.
constexpr std::int64_t kTurn = 500000;
// Rounds of a crowd go first, and for so many look-ups, where a look at one configuration may take more than
// kLargeLook.
constexpr std::int64_t kCrowdTurn = 20000000;
// Look-ups that the search for one of the rest of a crowd may take, at first and at most.
constexpr std::int64_t kRest = 1000000;
constexpr std::int64_t kMostRest = 16000000;
// They take one of so many parts of all look-ups.
constexpr std::int64_t kRestShare = 4;
constexpr std::int64_t kLargeLook = 4000000;
// Look-ups that a search for a cheaper stretch may take, and moves in a stretch.
constexpr std::int64_t kStretchWork = 300000;
constexpr std::size_t kStretches[] = {24, 60, 12};

// Whether two robots can stand on their goals at the same time.
bool goalsFit(const Fleet& fleet, std::size_t i, std::size_t j) {
  if (!fleet.hasGoal(i) || !fleet.hasGoal(j)) {
    return true;
  }
  for (const Place mine : fleet.goals(i)) {
    for (const Place theirs : fleet.goals(j)) {
      if (fleet.apart(i, mine, j, theirs) || fleet.apart(j, theirs, i, mine)) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

Solver::Solver(Fleet fleet, std::int64_t memory_bytes) : fleet_(std::move(fleet)), memory_bytes_(memory_bytes) {
  for (std::size_t i = 0; i < fleet_.size(); ++i) {
    const RobotGraph& graph = fleet_.graph(i);
    to_go_.push_back(fleet_.hasGoal(i) ? graph.costsTo(fleet_.goals(i)) : std::vector<Cost>(graph.size(), 0));
    impossible_ = impossible_ || to_go_.back()[fleet_.start(i)] >= kFar;
    for (std::size_t j = 0; j < i; ++j) {
      impossible_ = impossible_ || !goalsFit(fleet_, j, i);
    }
  }
  if (!impossible_) {
    makeStages();
  }
}

void Solver::makeStages() {
  const std::int64_t robots = static_cast<std::int64_t>(fleet_.size());
  std::int64_t most = 0;
  for (std::size_t i = 0; i < fleet_.size(); ++i) {
    most = std::max<std::int64_t>(most, fleet_.graph(i).size());
  }
  const bool large = robots * robots * most > kLargeLook;
  for (const std::size_t stops : kStops) {
    if (static_cast<std::int64_t>(stops) < most && !large) {
      stages_.push_back({nullptr, stops, false});
    }
  }
  stages_.push_back({nullptr, 0, false});
  if (Masks::bytes(fleet_) <= kMostMasks) {
    masks_ = std::make_unique<Masks>(fleet_);
  }
  crowd_turn_ = large ? kCrowdTurn : kTurn;
  if (Exchange::fits(fleet_)) {
    exchange_ = std::make_unique<Exchange>(fleet_, memoryShare());
  }
  exchange_ended_ = exchange_ == nullptr;
  crowd_ = std::make_unique<Crowd>(fleet_, to_go_, memoryShare());
}

// A search that knows what any two robots cost each other, once the others have not found a plan soon.
void Solver::addPairs() {
  const std::int64_t look_ups = Pairs::lookUps(fleet_);
  if (pairs_ != nullptr || look_ups > kMostPairs || work() < kPairsAfter) {
    return;
  }
  pairs_ = std::make_unique<Pairs>(fleet_, to_go_);
  pairs_work_ = look_ups;
  stages_.push_back({nullptr, kStops[0], true});
}

std::int64_t Solver::memoryShare() const {
  return memory_bytes_ / static_cast<std::int64_t>(stages_.size() + 4);
}

// Where robots of a kind start or want to go any of them can stand; the others are spread between.
const std::vector<Place>& Solver::spreadOf(std::size_t i, std::size_t stops) {
  std::vector<Place>& spread = spreads_[{&fleet_.graph(i), stops}];
  if (spread.empty()) {
    for (std::size_t j = 0; j < fleet_.size(); ++j) {
      if (fleet_.alike(i, j)) {
        spread.push_back(fleet_.start(j));
        spread.insert(spread.end(), fleet_.goals(j).begin(), fleet_.goals(j).end());
      }
    }
    spread = fleet_.graph(i).spread(std::move(spread), stops);
  }
  return spread;
}

Search& Solver::searchOf(Stage* stage) {
  if (!stage->search) {
    SearchParams params;
    params.memory_bytes = memoryShare();
    params.masks = masks_.get();
    params.pairs = stage->pairs ? pairs_.get() : nullptr;
    for (std::size_t i = 0; stage->stops > 0 && i < fleet_.size(); ++i) {
      std::vector<std::uint8_t> stops(fleet_.graph(i).size(), 0);
      for (const Place p : spreadOf(i, stage->stops)) {
        stops[p] = 1;
      }
      params.stops.push_back(std::move(stops));
    }
    stage->search = std::make_unique<Search>(fleet_, fleet_.starts(), to_go_, std::move(params));
  }
  return *stage->search;
}

Outcome Solver::run(std::int64_t work) {
  if (impossible_) {
    return Outcome::kExhausted;
  }
  const std::int64_t until = this->work() + work;
  while (!found_ && this->work() < until) {
    addPairs();
    bool any = !crowd_ended_;
    // Where one look of a search is dear, rounds go first.
    const bool crowd_first = crowd_turn_ > kTurn;
    if (crowd_first && (turnOfCrowd() == Outcome::kFound || turnOfRest() == Outcome::kFound)) {
      break;
    }
    const Outcome outcome = turnOfSearches(&any);
    if (outcome != Outcome::kOpen) {
      impossible_ = outcome == Outcome::kExhausted;
      return outcome;
    }
    if (turnOfExchange() == Outcome::kExhausted) {
      impossible_ = by_exchange_ = true;
      return Outcome::kExhausted;
    }
    if (!crowd_first && (turnOfCrowd() == Outcome::kFound || turnOfRest() == Outcome::kFound)) {
      break;
    }
    if (!any && exchange_ended_ && crowd_ended_) {
      return Outcome::kFull;
    }
  }
  return found_ ? Outcome::kFound : Outcome::kOpen;
}

Outcome Solver::turnOfSearches(bool* any) {
  for (Stage& stage : stages_) {
    if (stage.ended) {
      continue;
    }
    *any = true;
    Search& search = searchOf(&stage);
    const Outcome outcome = search.found() ? Outcome::kFound : search.advance(kTurn);
    if (outcome == Outcome::kFound) {
      plan_ = unitPlan(fleet_.starts(), search.plan());
      found_ = true;
      return outcome;
    }
    if (outcome == Outcome::kExhausted && stage.stops == 0) {
      return outcome;
    }
    stage.ended = outcome != Outcome::kOpen;
  }
  return Outcome::kOpen;
}

Outcome Solver::turnOfExchange() {
  if (exchange_ended_) {
    return Outcome::kFull;
  }
  const Outcome outcome = exchange_->advance(kTurn);
  exchange_ended_ = outcome != Outcome::kOpen;
  return outcome;
}

Outcome Solver::turnOfCrowd() {
  if (crowd_ended_) {
    return Outcome::kFull;
  }
  const Outcome outcome = crowd_->advance(crowd_turn_);
  if (outcome == Outcome::kFound) {
    plan_ = crowd_->plan();
    found_ = true;
  }
  crowd_ended_ = outcome != Outcome::kOpen;
  return outcome;
}

// Brings those whom the crowd's rounds leave away from their goals there one after the other, from where the rounds
// bring the others; with each one those nearest to it may move, more and more of them.
Outcome Solver::turnOfRest() {
  const std::int32_t best = crowd_->best();
  if (best != rest_from_) {
    rest_from_ = best;
    rest_plan_ = crowd_->movesTo(best);
    rest_at_ = crowd_->placesOf(best);
    rest_movable_ = 1;
    rest_allowed_ = kRest;
  }
  if (best == 0 || rest_work_ > work() / kRestShare) {
    return Outcome::kOpen;
  }
  const std::int64_t until = rest_work_ + crowd_turn_;
  while (rest_work_ < until) {
    std::size_t next = fleet_.size();
    for (std::size_t i = 0; i < fleet_.size(); ++i) {
      if (to_go_[i][rest_at_[i]] > 0 &&
          (next == fleet_.size() || to_go_[i][rest_at_[i]] < to_go_[next][rest_at_[next]])) {
        next = i;
      }
    }
    if (next == fleet_.size()) {
      plan_ = rest_plan_;
      found_ = true;
      return Outcome::kFound;
    }
    if (bring(next)) {
      rest_movable_ = 1;
    } else if (rest_movable_ < fleet_.size()) {
      rest_movable_ *= 2;
    } else {
      rest_movable_ = 1;
      rest_allowed_ = std::min(4 * rest_allowed_, kMostRest);
    }
  }
  return Outcome::kOpen;
}

// Lets a robot and those nearest to it go to their goals while the others stand, if that is soon found.
bool Solver::bring(std::size_t i) {
  const Stand& mine = fleet_.graph(i).stand(rest_at_[i]);
  std::vector<std::size_t> nearest(fleet_.size());
  std::iota(nearest.begin(), nearest.end(), std::size_t{0});
  std::stable_sort(nearest.begin(), nearest.end(), [&](std::size_t a, std::size_t b) {
    const auto away = [&](std::size_t j) {
      const Stand& theirs = fleet_.graph(j).stand(rest_at_[j]);
      return j == i ? -1 : std::max(std::abs(mine.x - theirs.x), std::abs(mine.y - theirs.y));
    };
    return away(a) < away(b);
  });
  SearchParams params;
  params.memory_bytes = memoryShare();
  params.movable.assign(fleet_.size(), 0);
  std::vector<std::vector<Cost>> to_go(fleet_.size());
  for (std::size_t k = 0; k < nearest.size(); ++k) {
    const std::size_t j = nearest[k];
    params.movable[j] = k < rest_movable_ ? 1 : 0;
    to_go[j] = k < rest_movable_ ? to_go_[j] : std::vector<Cost>(fleet_.graph(j).size(), 0);
    rest_work_ += fleet_.graph(j).size() / 8;
  }
  Search search(fleet_, rest_at_, to_go, std::move(params));
  const Outcome outcome = search.advance(rest_allowed_);
  rest_work_ += search.work();
  rest_visited_ += search.visited();
  if (outcome != Outcome::kFound) {
    return false;
  }
  for (const UnitMove& move : unitPlan(rest_at_, search.plan())) {
    rest_plan_.push_back(move);
    rest_at_[move.robot] = move.to;
  }
  return true;
}

std::int64_t Solver::visited() const {
  std::int64_t visited = improving_visited_ + (crowd_ ? crowd_->visited() : 0) + (exchange_ ? exchange_->visited() : 0);
  visited += rest_visited_;
  for (const Stage& stage : stages_) {
    visited += stage.search ? stage.search->visited() : 0;
  }
  return visited;
}

std::int64_t Solver::work() const {
  std::int64_t work = improving_work_ + (crowd_ ? crowd_->work() : 0) + (exchange_ ? exchange_->work() : 0);
  work += rest_work_ + pairs_work_;
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
  std::vector<Places> at{fleet_.starts()};
  for (const UnitMove& move : plan_) {
    at.push_back(at.back());
    at.back()[move.robot] = move.to;
  }
  return at;
}

Cost Solver::costOf(const std::vector<UnitMove>& moves, std::size_t begin, std::size_t end) const {
  Places at = fleet_.starts();
  Cost cost = 0;
  for (std::size_t k = 0; k < end; ++k) {
    Place& place = at[moves[k].robot];
    cost += k >= begin ? edgeBetween(fleet_.graph(moves[k].robot), place, moves[k].to)->cost : 0;
    place = moves[k].to;
  }
  return cost;
}

void Solver::improve(std::int64_t work) {
  const std::int64_t until = this->work() + work;
  shorten(work / 2);
  improveWhole(work / 4);
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

void Solver::shorten(std::int64_t work) {
  Shortener shortener(fleet_);
  plan_ = shortener.shortened(plan_, work);
  improving_work_ += shortener.work();
}

void Solver::improveWhole(std::int64_t work) {
  Cost least = 0;
  for (std::size_t i = 0; i < fleet_.size(); ++i) {
    least += to_go_[i][fleet_.start(i)];
  }
  if (!found_ || cost() <= least) {
    return;
  }
  SearchParams params;
  params.greedy = false;
  params.weight = 1;
  params.below = cost();
  params.memory_bytes = memory_bytes_;
  Search search(fleet_, fleet_.starts(), to_go_, std::move(params));
  search.advance(work);
  if (search.found()) {
    plan_ = unitPlan(fleet_.starts(), search.plan());
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
    const bool last = end == plan_.size() && fleet_.hasGoal(i);
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
