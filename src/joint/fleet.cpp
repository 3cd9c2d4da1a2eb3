#include "fleet.hpp"

#include <algorithm>
#include <utility>

namespace yarm::joint {
namespace {

constexpr std::int32_t kSteps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

// Lowers costs from some places on along edges; costs are whole numbers, `dearest` the greatest of an edge.
void spreadCosts(const std::vector<std::int32_t>& first, const std::vector<Edge>& edges, Cost dearest,
                 const std::vector<Place>& ends, std::vector<Cost>* costs) {
  std::vector<std::vector<Place>> rings(static_cast<std::size_t>(dearest) + 1);
  for (const Place p : ends) {
    (*costs)[p] = 0;
  }
  rings[0] = ends;
  std::size_t waiting = ends.size();
  for (Cost now = 0; waiting > 0; ++now) {
    std::vector<Place>& ring = rings[static_cast<std::size_t>(now) % rings.size()];
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Place place = ring[k];
      for (std::int32_t e = first[place]; (*costs)[place] == now && e < first[place + 1]; ++e) {
        const Cost further = now + edges[e].cost;
        if (further < (*costs)[edges[e].to]) {
          (*costs)[edges[e].to] = further;
          rings[static_cast<std::size_t>(further) % rings.size()].push_back(edges[e].to);
          ++waiting;
        }
      }
    }
    waiting -= ring.size();
    ring.clear();
  }
}

// Whether two robots are handed over with the same tables.
bool sameTables(std::int32_t gx, std::int32_t gy, const YarmJointRobot& one, const YarmJointRobot& other) {
  if (one.n_headings != other.n_headings || one.n_turns != other.n_turns) {
    return false;
  }
  const std::size_t image = static_cast<std::size_t>(gx) * gy;
  return std::equal(one.shapes, one.shapes + one.n_headings, other.shapes) &&
         std::equal(one.turns, one.turns + 3 * one.n_turns, other.turns) &&
         std::equal(one.turn_shapes, one.turn_shapes + one.n_turns, other.turn_shapes) &&
         std::equal(one.blocked, one.blocked + image * one.n_headings, other.blocked) &&
         std::equal(one.turn_blocked, one.turn_blocked + image * one.n_turns, other.turn_blocked);
}

}  // namespace

RobotGraph::RobotGraph(std::int32_t gx, std::int32_t gy, const YarmJointRobot& robot)
    : turn_shapes_(robot.turn_shapes, robot.turn_shapes + robot.n_turns), gx_(gx), gy_(gy) {
  addEdges(gx, gy, robot);
}

Place RobotGraph::find(std::int32_t x, std::int32_t y, std::int32_t heading) const {
  const std::int64_t cell = (static_cast<std::int64_t>(heading) * gx_ + x) * gy_ + y;
  const bool inside = x >= 0 && x < gx_ && y >= 0 && y < gy_ && heading >= 0;
  return inside && cell < static_cast<std::int64_t>(number_.size()) ? number_[cell] : -1;
}

void RobotGraph::addEdges(std::int32_t gx, std::int32_t gy, const YarmJointRobot& robot) {
  number_.assign(static_cast<std::size_t>(robot.n_headings) * gx * gy, -1);
  const auto cell = [gx, gy](std::int32_t k, std::int32_t x, std::int32_t y) {
    return (static_cast<std::size_t>(k) * gx + x) * gy + y;
  };
  const auto reach = [&](std::int32_t x, std::int32_t y, std::int32_t h) {
    Place& known = number_[cell(h, x, y)];
    if (known < 0) {
      known = size();
      stands_.push_back({x, y, h, robot.shapes[h]});
    }
    return known;
  };
  reach(robot.start[0], robot.start[1], robot.start[2]);
  for (Place p = 0; p < size(); ++p) {
    first_.push_back(static_cast<std::int32_t>(edges_.size()));
    const std::int32_t x = stands_[p].x, y = stands_[p].y, h = stands_[p].heading;
    for (const auto& step : kSteps) {
      const std::int32_t nx = x + step[0], ny = y + step[1];
      if (nx >= 0 && nx < gx && ny >= 0 && ny < gy && !robot.blocked[cell(h, nx, ny)]) {
        edges_.push_back({reach(nx, ny, h), 1, -1});
      }
    }
    for (std::int32_t t = 0; t < robot.n_turns; ++t) {
      const std::int32_t* turn = robot.turns + 3 * t;
      if (turn[0] == h && !robot.turn_blocked[cell(t, x, y)] && !robot.blocked[cell(turn[1], x, y)]) {
        edges_.push_back({reach(x, y, turn[1]), turn[2], t});
        greatest_cost_ = std::max(greatest_cost_, turn[2]);
      }
    }
  }
  first_.push_back(static_cast<std::int32_t>(edges_.size()));
  first_back_.assign(static_cast<std::size_t>(size()) + 1, 0);
  for (const Edge& edge : edges_) {
    ++first_back_[edge.to + 1];
  }
  for (Place p = 0; p < size(); ++p) {
    first_back_[p + 1] += first_back_[p];
  }
  back_.resize(edges_.size());
  std::vector<std::int32_t> next(first_back_.begin(), first_back_.end() - 1);
  for (Place p = 0; p < size(); ++p) {
    for (const Edge* edge = begin(p); edge != end(p); ++edge) {
      back_[next[edge->to]++] = {p, edge->cost, edge->turn};
    }
  }
}

std::vector<Cost> RobotGraph::costsTo(const std::vector<Place>& ends) const {
  std::vector<Cost> costs(size(), kFar);
  spreadCosts(first_back_, back_, greatest_cost_, ends, &costs);
  return costs;
}

std::vector<Place> RobotGraph::spread(std::vector<Place> seeds, std::size_t count) const {
  std::vector<Cost> costs(size(), kFar);
  spreadCosts(first_, edges_, greatest_cost_, seeds, &costs);
  for (std::size_t k = 0; k < count; ++k) {
    const auto farthest = std::max_element(costs.begin(), costs.end());
    if (*farthest == 0) {
      break;
    }
    seeds.push_back(static_cast<Place>(farthest - costs.begin()));
    spreadCosts(first_, edges_, greatest_cost_, {seeds.back()}, &costs);
  }
  return seeds;
}

PairTable::PairTable(const YarmJointShapes& shapes, std::int32_t one, std::int32_t other) {
  const auto reachOf = [&shapes](std::int32_t shape) {
    std::int32_t reach = 0;
    for (std::int32_t c = shapes.first[shape]; c < shapes.first[shape + 1]; ++c) {
      reach = std::max({reach, std::abs(shapes.columns[2 * c]), std::abs(shapes.columns[2 * c + 1])});
    }
    return reach;
  };
  const std::int32_t words = shapes.words, wide = reachOf(other) + 1, side = 2 * wide + 1;
  std::vector<std::uint64_t> grown(static_cast<std::size_t>(side) * side * words, 0);
  std::vector<std::uint64_t> column(words);
  for (std::int32_t c = shapes.first[other]; c < shapes.first[other + 1]; ++c) {
    const std::uint64_t* bits = shapes.bits + static_cast<std::size_t>(c) * words;
    for (std::int32_t w = 0; w < words; ++w) {
      column[w] = bits[w] | bits[w] << 1 | bits[w] >> 1;
      column[w] |= w > 0 ? bits[w - 1] >> 63 : 0;
      column[w] |= w + 1 < words ? bits[w + 1] << 63 : 0;
    }
    for (std::int32_t dx = -1; dx <= 1; ++dx) {
      for (std::int32_t dy = -1; dy <= 1; ++dy) {
        const std::int32_t x = shapes.columns[2 * c] + dx + wide, y = shapes.columns[2 * c + 1] + dy + wide;
        for (std::int32_t w = 0; w < words; ++w) {
          grown[(static_cast<std::size_t>(x) * side + y) * words + w] |= column[w];
        }
      }
    }
  }
  reach_ = reachOf(one) + wide;
  hit_.assign(static_cast<std::size_t>(2 * reach_ + 1) * (2 * reach_ + 1), 0);
  for (std::int32_t c = shapes.first[one]; c < shapes.first[one + 1]; ++c) {
    const std::uint64_t* bits = shapes.bits + static_cast<std::size_t>(c) * words;
    for (std::int32_t x = 0; x < side; ++x) {
      for (std::int32_t y = 0; y < side; ++y) {
        const std::uint64_t* theirs = grown.data() + (static_cast<std::size_t>(x) * side + y) * words;
        bool both = false;
        for (std::int32_t w = 0; w < words; ++w) {
          both = both || (bits[w] & theirs[w]) != 0;
        }
        if (both) {
          const std::int32_t dx = x - wide - shapes.columns[2 * c], dy = y - wide - shapes.columns[2 * c + 1];
          hit_[(dx + reach_) * (2 * reach_ + 1) + dy + reach_] = 1;
        }
      }
    }
  }
}

Fleet::Fleet(std::int32_t gx, std::int32_t gy, const YarmJointShapes& shapes, std::int32_t n_robots,
             const YarmJointRobot* robots, std::int32_t n_near, const YarmJointNear* near)
    : gx_(gx), gy_(gy), n_shapes_(shapes.n) {
  addRobots(n_robots, robots);
  std::vector<bool> stood(shapes.n, false);
  for (std::int32_t i = 0; i < n_robots; ++i) {
    for (std::int32_t h = 0; h < robots[i].n_headings; ++h) {
      stood[robots[i].shapes[h]] = true;
    }
  }
  for (std::int32_t one = 0; one < shapes.n; ++one) {
    for (std::int32_t other = 0; other < shapes.n; ++other) {
      tables_.push_back(stood[other] ? PairTable(shapes, one, other) : PairTable());
    }
  }
  for (const PairTable& table : tables_) {
    reach_ = std::max(reach_, table.reach());
  }
  if (n_near > 0) {
    near_.resize(graphs_.size() * graphs_.size());
  }
  const std::size_t image = static_cast<std::size_t>(gx) * gy;
  for (std::int32_t k = 0; k < n_near; ++k) {
    const YarmJointRobot& robot = robots[near[k].robot];
    auto kept = std::make_unique<Near>();
    kept->blocked.assign(near[k].blocked, near[k].blocked + image * robot.n_headings);
    kept->turn_blocked.assign(near[k].turn_blocked, near[k].turn_blocked + image * robot.n_turns);
    near_[static_cast<std::size_t>(near[k].robot) * graphs_.size() + near[k].other] = std::move(kept);
  }
}

void Fleet::addRobots(std::int32_t n_robots, const YarmJointRobot* robots) {
  for (std::int32_t i = 0; i < n_robots; ++i) {
    const YarmJointRobot& robot = robots[i];
    Place start = -1;
    for (std::int32_t j = 0; start < 0 && j < i; ++j) {
      if (sameTables(gx_, gy_, robot, robots[j])) {
        start = graphs_[j]->find(robot.start[0], robot.start[1], robot.start[2]);
        if (start >= 0) {
          graphs_.push_back(graphs_[j]);
        }
      }
    }
    if (start < 0) {
      start = 0;
      graphs_.push_back(std::make_shared<const RobotGraph>(gx_, gy_, robot));
    }
    starts_.push_back(start);
    goals_.emplace_back();
    has_goal_.push_back(robot.goal[0] >= 0 ? 1 : 0);
    for (std::int32_t h = 0; robot.goal[0] >= 0 && h < robot.n_headings; ++h) {
      const Place goal = graphs_[i]->find(robot.goal[0], robot.goal[1], h);
      if (goal >= 0 && (robot.goal[2] < 0 || robot.goal[2] == h)) {
        goals_.back().push_back(goal);
      }
    }
  }
}

bool Fleet::apart(std::size_t i, Place place, std::size_t j, Place other) const {
  const Stand& mine = graphs_[i]->stand(place);
  if (const Near* near = nearOf(i, j, other)) {
    return near->blocked[(static_cast<std::size_t>(mine.heading) * gx_ + mine.x) * gy_ + mine.y] == 0;
  }
  const Stand& theirs = graphs_[j]->stand(other);
  return !tables_[mine.shape * n_shapes_ + theirs.shape].touches(mine.x - theirs.x, mine.y - theirs.y);
}

bool Fleet::clearOf(std::size_t i, Place from, const Edge& edge, std::size_t j, Place other) const {
  if (!apart(i, edge.to, j, other)) {
    return false;
  }
  if (edge.turn < 0) {
    return true;
  }
  const Stand& mine = graphs_[i]->stand(from);
  if (const Near* near = nearOf(i, j, other)) {
    return near->turn_blocked[(static_cast<std::size_t>(edge.turn) * gx_ + mine.x) * gy_ + mine.y] == 0;
  }
  const Stand& theirs = graphs_[j]->stand(other);
  const PairTable& table = tables_[graphs_[i]->turnShape(edge.turn) * n_shapes_ + theirs.shape];
  return !table.touches(mine.x - theirs.x, mine.y - theirs.y);
}

}  // namespace yarm::joint
