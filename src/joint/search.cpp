#include "search.hpp"

#include <algorithm>
#include <utility>

namespace yarm::joint {
namespace {

constexpr std::size_t kFirstTable = 1 << 12;
constexpr std::uint64_t kNumber = 0xffffffffU;

}  // namespace

void Search::Buckets::push(Cost key, std::int32_t node) {
  const std::size_t k = static_cast<std::size_t>(std::max(key, 0));
  if (k >= buckets_.size()) {
    buckets_.resize(k + k / 2 + 1);
  }
  buckets_[k].push_back(node);
  lowest_ = std::min(lowest_, k);
  ++size_;
}

std::int32_t Search::Buckets::pop() {
  if (size_ == 0) {
    return -1;
  }
  while (buckets_[lowest_].empty()) {
    ++lowest_;
  }
  const std::int32_t node = buckets_[lowest_].back();
  buckets_[lowest_].pop_back();
  --size_;
  return node;
}

Search::Search(const Fleet& fleet, Places start, const std::vector<std::vector<Cost>>& to_go, SearchParams params)
    : fleet_(fleet), to_go_(to_go), params_(std::move(params)), wide_(false), best_(params_.below) {
  Place most = 0;
  Cost dearest = 1;
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    most = std::max(most, fleet.graph(i).size());
    dearest = std::max(dearest, fleet.graph(i).greatestCost());
  }
  wide_ = most > 0xffff;
  reached_.assign(most, kFar);
  rings_.resize(static_cast<std::size_t>(dearest) + 1);
  table_.assign(kFirstTable, 0);
  here_.resize(fleet.size());
  const Cost left = costToGo(start);
  if (left < kFar && left < best_) {
    push(add(start, hashOf(start), -1, 0, left));
  }
}

Outcome Search::advance(std::int64_t work) {
  const std::int64_t until = work_ + work;
  while (work_ < until) {
    if (bytes() > params_.memory_bytes) {
      return Outcome::kFull;
    }
    turn_ = !turn_;
    const std::int32_t node = turn_ && params_.greedy ? greedy_.pop() : weighted_.pop();
    if (node < 0 && weighted_.size() == 0) {
      return Outcome::kExhausted;
    }
    ++work_;
    if (node < 0 || expanded_[node]) {
      continue;
    }
    if (left_[node] == 0) {
      goal_ = node;
      best_ = cost_[node];
      return Outcome::kFound;
    }
    if (cost_[node] + left_[node] < best_) {
      expand(node);
    }
  }
  return Outcome::kOpen;
}

void Search::push(std::int32_t node) {
  if (params_.greedy) {
    greedy_.push(left_[node], node);
  }
  weighted_.push(cost_[node] + params_.weight * left_[node], node);
}

void Search::expand(std::int32_t node) {
  expanded_[node] = 1;
  placesOf(node, &here_);
  here_left_ = left_[node];
  here_hash_ = hashOf(here_);
  for (std::size_t i = 0; i < fleet_.size(); ++i) {
    if (!params_.movable.empty() && !params_.movable[i]) {
      continue;
    }
    if (params_.pairs != nullptr) {
      here_extra_ = params_.pairs->extraOf(i, here_[i], here_);
    }
    if (params_.masks != nullptr && !params_.stops.empty()) {
      blocked_ = &params_.masks->blocked(i, here_);
      work_ += params_.masks->work();
    }
    if (params_.stops.empty()) {
      expandEdges(node, i);
    } else {
      expandStops(node, i);
    }
  }
}

bool Search::isFree(std::size_t i, Place from, const Edge& edge) {
  if (blocked_ == nullptr) {
    work_ += static_cast<std::int64_t>(fleet_.size());
    return fleet_.isFree(i, from, edge, here_);
  }
  ++work_;
  const std::size_t number = fleet_.graph(i).numberOf(&edge);
  return ((*blocked_)[number / 64] >> number % 64 & 1) == 0;
}

void Search::expandEdges(std::int32_t node, std::size_t i) {
  const RobotGraph& graph = fleet_.graph(i);
  const Place from = here_[i];
  for (const Edge* edge = graph.begin(from); edge != graph.end(from); ++edge) {
    if (isFree(i, from, *edge)) {
      offer(node, i, edge->to, edge->cost);
    }
  }
}

// Lets the robot's reach grow by rising cost; every stop it comes to is a successor.
void Search::expandStops(std::int32_t node, std::size_t i) {
  const RobotGraph& graph = fleet_.graph(i);
  const std::size_t count = rings_.size();
  touched_.clear();
  rings_[0].push_back(here_[i]);
  reached_[here_[i]] = 0;
  touched_.push_back(here_[i]);
  std::size_t waiting = 1;
  for (Cost cost = 0; waiting > 0; ++cost) {
    std::vector<Place>& ring = rings_[static_cast<std::size_t>(cost) % count];
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Place from = ring[k];
      if (reached_[from] != cost) {
        continue;
      }
      if (cost > 0 && params_.stops[i][from]) {
        offer(node, i, from, cost);
      }
      for (const Edge* edge = graph.begin(from); edge != graph.end(from); ++edge) {
        const Cost further = cost + edge->cost;
        if (further >= reached_[edge->to]) {
          continue;
        }
        if (isFree(i, from, *edge)) {
          if (reached_[edge->to] == kFar) {
            touched_.push_back(edge->to);
          }
          reached_[edge->to] = further;
          rings_[static_cast<std::size_t>(further) % count].push_back(edge->to);
          ++waiting;
        }
      }
    }
    waiting -= ring.size();
    ring.clear();
  }
  for (const Place p : touched_) {
    reached_[p] = kFar;
  }
}

void Search::offer(std::int32_t node, std::size_t i, Place to, Cost cost) {
  Cost left = here_left_ - to_go_[i][here_[i]] + to_go_[i][to];
  const Cost total = cost_[node] + cost;
  if (to_go_[i][to] >= kFar || total + left >= best_) {
    return;
  }
  if (params_.pairs != nullptr) {
    const Cost extra = params_.pairs->extraOf(i, to, here_);
    work_ += static_cast<std::int64_t>(fleet_.size());
    if (extra >= kFar) {
      return;
    }
    left += extra - here_extra_;
  }
  ++work_;
  const Place from = here_[i];
  const std::uint64_t hash = here_hash_ ^ key(i, from) ^ key(i, to);
  here_[i] = to;
  const std::int32_t known = find(here_, hash);
  if (known < 0) {
    push(add(here_, hash, node, total, left));
  } else if (total < cost_[known]) {
    cost_[known] = total;
    parent_[known] = node;
    if (!expanded_[known] || !params_.greedy) {
      expanded_[known] = 0;
      push(known);
    }
  }
  here_[i] = from;
}

std::vector<Leg> Search::plan() const {
  std::vector<Leg> legs;
  for (std::int32_t node = goal_; node >= 0 && parent_[node] >= 0; node = parent_[node]) {
    Places before(fleet_.size()), after(fleet_.size());
    placesOf(parent_[node], &before);
    placesOf(node, &after);
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (before[i] != after[i]) {
        legs.push_back({static_cast<std::int32_t>(i), before[i], after[i]});
      }
    }
  }
  std::reverse(legs.begin(), legs.end());
  return legs;
}

Cost Search::costToGo(const Places& places) const {
  Cost left = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Cost own = to_go_[i][places[i]];
    if (own >= kFar) {
      return kFar;
    }
    left += own;
  }
  return params_.pairs == nullptr ? left : std::min(kFar, left + params_.pairs->extraOf(places));
}

void Search::placesOf(std::int32_t node, Places* places) const {
  const std::size_t n = fleet_.size();
  const std::uint16_t* at = places_.data() + static_cast<std::size_t>(node) * n * (wide_ ? 2 : 1);
  for (std::size_t i = 0; i < n; ++i) {
    (*places)[i] = wide_ ? static_cast<Place>(at[2 * i] | static_cast<std::uint32_t>(at[2 * i + 1]) << 16) : at[i];
  }
}

bool Search::same(std::int32_t node, const Places& places) const {
  const std::size_t n = fleet_.size();
  const std::uint16_t* at = places_.data() + static_cast<std::size_t>(node) * n * (wide_ ? 2 : 1);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t place = static_cast<std::uint32_t>(places[i]);
    if (wide_ ? at[2 * i] != (place & 0xffff) || at[2 * i + 1] != place >> 16 : at[i] != place) {
      return false;
    }
  }
  return true;
}

std::int32_t Search::find(const Places& places, std::uint64_t hash) const {
  const std::size_t mask = table_.size() - 1;
  for (std::size_t slot = hash & mask; table_[slot] != 0; slot = (slot + 1) & mask) {
    const std::int32_t node = static_cast<std::int32_t>(table_[slot] & kNumber) - 1;
    if ((table_[slot] ^ hash) >> 32 == 0 && same(node, places)) {
      return node;
    }
  }
  return -1;
}

std::int32_t Search::add(const Places& places, std::uint64_t hash, std::int32_t parent, Cost cost, Cost to_go) {
  const std::int32_t node = static_cast<std::int32_t>(cost_.size());
  for (const Place place : places) {
    places_.push_back(static_cast<std::uint16_t>(place & 0xffff));
    if (wide_) {
      places_.push_back(static_cast<std::uint16_t>(static_cast<std::uint32_t>(place) >> 16));
    }
  }
  cost_.push_back(cost);
  left_.push_back(to_go);
  parent_.push_back(parent);
  expanded_.push_back(0);
  if (2 * cost_.size() >= table_.size()) {
    table_.assign(2 * table_.size(), 0);
    Places known(fleet_.size());
    for (std::int32_t other = 0; other < node; ++other) {
      placesOf(other, &known);
      enter(other, hashOf(known));
    }
  }
  enter(node, hash);
  return node;
}

void Search::enter(std::int32_t node, std::uint64_t hash) {
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = hash & mask;
  while (table_[slot] != 0) {
    slot = (slot + 1) & mask;
  }
  table_[slot] = (hash & ~kNumber) | static_cast<std::uint64_t>(node + 1);
}

std::uint64_t Search::key(std::size_t robot, Place place) const {
  return mixed(static_cast<std::uint64_t>(robot) << 32 | static_cast<std::uint32_t>(place));
}

std::uint64_t Search::hashOf(const Places& places) const {
  std::uint64_t hash = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    hash ^= key(i, places[i]);
  }
  return hash;
}

std::int64_t Search::bytes() const {
  return static_cast<std::int64_t>(places_.size() * sizeof(std::uint16_t) + cost_.size() * (3 * sizeof(Cost) + 1) +
                                   table_.size() * sizeof(std::uint64_t) +
                                   (greedy_.size() + weighted_.size()) * sizeof(std::int32_t));
}

std::vector<Place> unitMoves(const Fleet& fleet, const Places& places, const Leg& leg) {
  const RobotGraph& graph = fleet.graph(leg.robot);
  std::vector<Cost> cost(graph.size(), kFar);
  std::vector<Place> before(graph.size(), -1);
  std::vector<std::vector<Place>> rings(static_cast<std::size_t>(graph.greatestCost()) + 1);
  cost[leg.from] = 0;
  rings[0].push_back(leg.from);
  std::size_t waiting = 1;
  for (Cost now = 0; waiting > 0 && cost[leg.to] >= now; ++now) {
    std::vector<Place>& ring = rings[static_cast<std::size_t>(now) % rings.size()];
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Place from = ring[k];
      for (const Edge* edge = graph.begin(from); cost[from] == now && edge != graph.end(from); ++edge) {
        if (now + edge->cost < cost[edge->to] && fleet.isFree(leg.robot, from, *edge, places)) {
          cost[edge->to] = now + edge->cost;
          before[edge->to] = from;
          rings[static_cast<std::size_t>(cost[edge->to]) % rings.size()].push_back(edge->to);
          ++waiting;
        }
      }
    }
    waiting -= ring.size();
    ring.clear();
  }
  std::vector<Place> way;
  for (Place p = leg.to; p >= 0 && cost[leg.to] < kFar; p = before[p]) {
    way.push_back(p);
  }
  std::reverse(way.begin(), way.end());
  return way;
}

}  // namespace yarm::joint
