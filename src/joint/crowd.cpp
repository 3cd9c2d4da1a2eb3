#include "crowd.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <unordered_set>
#include <utility>

namespace yarm::joint {
namespace {

// Places looked at for one that is clear of those who push.
constexpr std::size_t kAside = 300;

}  // namespace

Crowd::Crowd(const Fleet& fleet, const std::vector<std::vector<Cost>>& to_go, std::int64_t memory_bytes)
    : fleet_(fleet), to_go_(to_go), memory_bytes_(memory_bytes), at_(fleet.starts()) {
  std::vector<float> rank;
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    rank.push_back(static_cast<float>(to_go[i][at_[i]]) / static_cast<float>(kFar));
  }
  open_.push_back(add(-1, std::move(rank)));
}

Outcome Crowd::advance(std::int64_t work) {
  const std::int64_t until = work_ + work;
  while (work_ < until) {
    if (open_.empty()) {
      return Outcome::kExhausted;
    }
    if (bytes_ > memory_bytes_) {
      return Outcome::kFull;
    }
    const std::int32_t top = open_.back();
    if (nodes_[top].left == 0) {
      goal_ = top;
      return Outcome::kFound;
    }
    Node& node = nodes_[top];
    if (node.next == node.forced.size()) {
      node.forced = {};
      node.next = 0;
      node.forced.shrink_to_fit();
      open_.pop_back();
      continue;
    }
    const Forced forced = node.forced[node.next++];
    if (forced.depth < static_cast<std::int32_t>(fleet_.size())) {
      const std::int32_t robot = node.order[forced.depth];
      const RobotGraph& graph = fleet_.graph(robot);
      const std::int32_t count =
          static_cast<std::int32_t>(graph.end(node.places[robot]) - graph.begin(node.places[robot]));
      for (std::int32_t edge = -1; edge < count; ++edge) {
        node.forced.push_back({static_cast<std::int32_t>(node.next) - 1, forced.depth + 1, robot, edge});
      }
      bytes_ += (count + 1) * static_cast<std::int64_t>(sizeof(Forced));
    }
    if (!round(node, forced)) {
      continue;
    }
    const std::int32_t seen = known();
    if (seen >= 0) {
      if (nodes_[seen].next < nodes_[seen].forced.size() && seen != top) {
        open_.push_back(seen);
      }
      continue;
    }
    std::vector<float> rank = node.rank;
    for (std::size_t i = 0; i < rank.size(); ++i) {
      rank[i] = to_go_[i][at_[i]] == 0 ? rank[i] - static_cast<float>(static_cast<std::int32_t>(rank[i])) : rank[i] + 1;
    }
    open_.push_back(add(top, std::move(rank)));
  }
  return Outcome::kOpen;
}

std::vector<UnitMove> Crowd::movesTo(std::int32_t node) const {
  std::vector<std::int32_t> way;
  for (; node >= 0; node = nodes_[node].parent) {
    way.push_back(node);
  }
  std::vector<UnitMove> moves;
  for (auto step = way.rbegin(); step != way.rend(); ++step) {
    moves.insert(moves.end(), nodes_[*step].moves.begin(), nodes_[*step].moves.end());
  }
  return moves;
}

std::int32_t Crowd::add(std::int32_t parent, std::vector<float> rank) {
  const std::int32_t number = static_cast<std::int32_t>(nodes_.size());
  std::vector<std::int32_t> order(fleet_.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&rank](std::int32_t a, std::int32_t b) { return rank[a] > rank[b]; });
  bytes_ += static_cast<std::int64_t>(sizeof(Node) + 3 * sizeof(Place) * fleet_.size() +
                                      sizeof(UnitMove) * moves_.size() + 4 * sizeof(std::uint64_t));
  table_.emplace(hashOf(at_), number);
  nodes_.push_back({parent, left(), at_, moves_, std::move(rank), std::move(order), {{-1, 0, -1, -1}}, 0});
  best_ = nodes_[number].left < nodes_[best_].left ? number : best_;
  return number;
}

std::int32_t Crowd::known() const {
  const auto range = table_.equal_range(hashOf(at_));
  for (auto entry = range.first; entry != range.second; ++entry) {
    if (nodes_[entry->second].places == at_) {
      return entry->second;
    }
  }
  return -1;
}

bool Crowd::round(const Node& node, const Forced& forced) {
  at_ = node.places;
  moves_.clear();
  decided_.assign(fleet_.size(), 0);
  if (!force(node, forced)) {
    return false;
  }
  for (const std::int32_t i : node.order) {
    if (!decided_[i]) {
      step(i);
    }
  }
  return !moves_.empty();
}

// Makes the forced moves, the first forced first.
bool Crowd::force(const Node& node, const Forced& forced) {
  std::vector<const Forced*> all;
  for (const Forced* one = &forced; one->robot >= 0; one = &node.forced[one->before]) {
    all.push_back(one);
    if (one->before < 0) {
      break;
    }
  }
  std::reverse(all.begin(), all.end());
  for (const Forced* one : all) {
    if (decided_[one->robot]) {
      return false;
    }
    decided_[one->robot] = 1;
    const RobotGraph& graph = fleet_.graph(one->robot);
    if (one->edge >= 0 && !go(one->robot, graph.begin(at_[one->robot]) + one->edge)) {
      return false;
    }
  }
  return true;
}

// Lets a robot make its best move, and whoever is in its way move before; false when it cannot even stay.
bool Crowd::step(std::size_t i) {
  decided_[i] = 1;
  for (const Choice& choice : choices(i)) {
    if (choice.edge == nullptr ? clearOfPushers(i, at_[i]) : go(i, choice.edge)) {
      return true;
    }
  }
  return !pushers_.empty() && stepAside(i);
}

bool Crowd::go(std::size_t i, const Edge* edge) {
  const Place from = at_[i];
  if (!clearOfPushers(i, edge->to) || !pushAside(i, *edge)) {
    return false;
  }
  work_ += static_cast<std::int64_t>(fleet_.size());
  if (!fleet_.isFree(i, from, *edge, at_)) {
    return false;
  }
  move(i, edge->to);
  return true;
}

bool Crowd::pushAside(std::size_t i, const Edge& edge) {
  std::vector<std::size_t> in_way;
  work_ += static_cast<std::int64_t>(fleet_.size());
  for (std::size_t j = 0; j < fleet_.size(); ++j) {
    if (j != i && !fleet_.clearOf(i, at_[i], edge, j, at_[j])) {
      if (decided_[j]) {
        return false;
      }
      in_way.push_back(j);
    }
  }
  pushers_.push_back({static_cast<std::int32_t>(i), at_[i], &edge});
  bool away = true;
  for (const std::size_t j : in_way) {
    const bool clear = fleet_.clearOf(i, at_[i], edge, j, at_[j]);
    away = clear || (!decided_[j] && step(j));
    if (!away) {
      break;
    }
  }
  pushers_.pop_back();
  return away;
}

// Takes a pushed robot further than by one edge, between the others as they stand.
bool Crowd::stepAside(std::size_t i) {
  const RobotGraph& graph = fleet_.graph(i);
  std::vector<std::pair<Place, std::int32_t>> queue{{at_[i], -1}};
  std::unordered_set<Place> seen{at_[i]};
  for (std::size_t k = 0; k < queue.size() && queue.size() < kAside; ++k) {
    const Place from = queue[k].first;
    for (const Edge* edge = graph.begin(from); edge != graph.end(from); ++edge) {
      if (seen.count(edge->to) > 0) {
        continue;
      }
      work_ += static_cast<std::int64_t>(fleet_.size());
      if (!fleet_.isFree(i, from, *edge, at_)) {
        continue;
      }
      seen.insert(edge->to);
      queue.emplace_back(edge->to, static_cast<std::int32_t>(k));
      if (clearOfPushers(i, edge->to)) {
        std::vector<Place> way;
        for (std::int32_t back = static_cast<std::int32_t>(queue.size()) - 1; back > 0; back = queue[back].second) {
          way.push_back(queue[back].first);
        }
        for (auto place = way.rbegin(); place != way.rend(); ++place) {
          move(i, *place);
        }
        return true;
      }
    }
  }
  return false;
}

bool Crowd::clearOfPushers(std::size_t i, Place to) {
  work_ += static_cast<std::int64_t>(pushers_.size());
  return std::all_of(pushers_.begin(), pushers_.end(), [&](const Pusher& pusher) {
    return fleet_.clearOf(pusher.robot, pusher.from, *pusher.edge, i, to);
  });
}

std::vector<Crowd::Choice> Crowd::choices(std::size_t i) {
  const RobotGraph& graph = fleet_.graph(i);
  const Place from = at_[i];
  std::vector<Choice> found{{to_go_[i][from], 0, 0, nullptr}};
  for (const Edge* edge = graph.begin(from); edge != graph.end(from); ++edge) {
    if (to_go_[i][edge->to] < kFar) {
      std::int32_t pushed = 0;
      for (std::size_t j = 0; j < fleet_.size(); ++j) {
        pushed += j != i && !fleet_.apart(i, edge->to, j, at_[j]) ? 1 : 0;
      }
      work_ += static_cast<std::int64_t>(fleet_.size());
      found.push_back({to_go_[i][edge->to], pushed, 1 + chance() / 2, edge});
    }
  }
  std::sort(found.begin(), found.end(), [](const Choice& a, const Choice& b) {
    return std::tie(a.left, a.pushed, a.chance) < std::tie(b.left, b.pushed, b.chance);
  });
  return found;
}

void Crowd::move(std::size_t i, Place to) {
  at_[i] = to;
  moves_.push_back({static_cast<std::int32_t>(i), to});
}

Cost Crowd::left() const {
  Cost left = 0;
  for (std::size_t i = 0; i < at_.size(); ++i) {
    left += to_go_[i][at_[i]];
  }
  return left;
}

std::uint32_t Crowd::chance() {
  return static_cast<std::uint32_t>(mixed(++chance_) >> 32);
}

}  // namespace yarm::joint
