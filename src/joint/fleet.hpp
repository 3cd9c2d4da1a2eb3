#ifndef YARM_JOINT_FLEET_HPP
#define YARM_JOINT_FLEET_HPP

// The robots of a fleet as graphs of places, and which places of two robots exclude each other.

#include <cstdint>
#include <memory>
#include <vector>

#include "yarm/joint/joint.hpp"

namespace yarm::joint {

/// A cost in cells.
using Cost = std::int32_t;
/// Number of a robot's place: a column and a heading that it can come to.
using Place = std::int32_t;
/// The place of every robot.
using Places = std::vector<Place>;

constexpr Cost kFar = 1 << 29;

/// A whole number's bits well mixed.
inline std::uint64_t mixed(std::uint64_t value) {
  value += 0x9e3779b97f4a7c15U;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9U;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebU;
  return value ^ (value >> 31);
}

/// Of places in their order.
inline std::uint64_t hashOf(const Places& places) {
  std::uint64_t hash = 0;
  for (const Place place : places) {
    hash = mixed(hash ^ static_cast<std::uint32_t>(place));
  }
  return hash;
}

/// A robot's next place.
struct UnitMove {
  std::int32_t robot;
  Place to;
};

/// A move by one column or one turn.
struct Edge {
  Place to;
  Cost cost;
  std::int32_t turn;  ///< which turn; -1 for a column's way
};

/// Where and how a robot stands at a place.
struct Stand {
  std::int32_t x, y, heading, shape;
};

/// What robots of one kind can do by the map alone: the places reachable from the start of the first of them.
class RobotGraph {
 public:
  RobotGraph(std::int32_t gx, std::int32_t gy, const YarmJointRobot& robot);

  Place size() const { return static_cast<Place>(stands_.size()); }
  const Stand& stand(Place p) const { return stands_[p]; }
  /// Shape that the robot sweeps in a turn.
  std::int32_t turnShape(std::int32_t turn) const { return turn_shapes_[turn]; }
  const Edge* begin(Place p) const { return edges_.data() + first_[p]; }
  const Edge* end(Place p) const { return edges_.data() + first_[p + 1]; }
  std::size_t edges() const { return edges_.size(); }
  std::size_t numberOf(const Edge* edge) const { return static_cast<std::size_t>(edge - edges_.data()); }
  /// Edges that lead to a place, towards where they come from.
  const Edge* beginBack(Place p) const { return back_.data() + first_back_[p]; }
  const Edge* endBack(Place p) const { return back_.data() + first_back_[p + 1]; }
  Cost greatestCost() const { return greatest_cost_; }
  /// Number of the place with a column and heading; -1 when it is none of this graph's.
  Place find(std::int32_t x, std::int32_t y, std::int32_t heading) const;
  /// Least cost from every place to one of some; kFar where no way leads.
  std::vector<Cost> costsTo(const std::vector<Place>& ends) const;
  /// Some places, and `count` more far from these and from each other, that cover the graph.
  std::vector<Place> spread(std::vector<Place> seeds, std::size_t count) const;

 private:
  void addEdges(std::int32_t gx, std::int32_t gy, const YarmJointRobot& robot);

  std::vector<Stand> stands_;
  std::vector<std::int32_t> turn_shapes_;
  std::vector<std::int32_t> first_;
  std::vector<Edge> edges_;
  std::vector<std::int32_t> first_back_;
  std::vector<Edge> back_;     // towards where an edge comes from
  std::vector<Place> number_;  // by heading, x, y
  std::int32_t gx_, gy_;
  Cost greatest_cost_ = 1;
};

/// At which offsets one shape comes within the margin of another.
class PairTable {
 public:
  PairTable() = default;
  PairTable(const YarmJointShapes& shapes, std::int32_t one, std::int32_t other);
  /// Whether they touch when the one's end effector is by (dx, dy) from the other's.
  bool touches(std::int32_t dx, std::int32_t dy) const {
    if (dx < -reach_ || dx > reach_ || dy < -reach_ || dy > reach_) {
      return false;
    }
    return hit_[(dx + reach_) * (2 * reach_ + 1) + dy + reach_] != 0;
  }

  std::int32_t reach() const { return reach_; }

 private:
  std::int32_t reach_ = -1;
  std::vector<std::uint8_t> hit_;
};

/// The fleet: graphs and tables.
class Fleet {
 public:
  Fleet(std::int32_t gx, std::int32_t gy, const YarmJointShapes& shapes, std::int32_t n_robots,
        const YarmJointRobot* robots, std::int32_t n_near, const YarmJointNear* near);

  std::size_t size() const { return graphs_.size(); }
  const RobotGraph& graph(std::size_t i) const { return *graphs_[i]; }
  /// Whether two robots can do the same: they have one graph.
  bool alike(std::size_t i, std::size_t j) const { return graphs_[i] == graphs_[j]; }
  Place start(std::size_t i) const { return starts_[i]; }
  /// Where all start.
  const Places& starts() const { return starts_; }
  /// Places on a robot's goal; none for a robot without one, or with one that it cannot reach.
  const std::vector<Place>& goals(std::size_t i) const { return goals_[i]; }
  bool hasGoal(std::size_t i) const { return has_goal_[i] != 0; }
  /// Columns along x or y beyond which no two robots, standing or turning, touch.
  std::int32_t reach() const { return reach_; }
  /// Whether some robots start within each other's margin, so that what is in the way depends on who it is.
  bool hasNear() const { return !near_.empty(); }
  /// Whether a robot at a place is clear of one that stands.
  bool apart(std::size_t i, Place place, std::size_t j, Place other) const;
  /// Whether a move is clear of one that stands; that the robot stands clear before it is taken for granted.
  bool clearOf(std::size_t i, Place from, const Edge& edge, std::size_t j, Place other) const;
  /// Whether a move is clear of all others, who stand at their places.
  bool isFree(std::size_t i, Place from, const Edge& edge, const Places& places) const {
    for (std::size_t j = 0; j < places.size(); ++j) {
      if (j != i && !clearOf(i, from, edge, j, places[j])) {
        return false;
      }
    }
    return true;
  }

 private:
  void addRobots(std::int32_t n_robots, const YarmJointRobot* robots);

  struct Near {
    std::vector<std::uint8_t> blocked, turn_blocked;
  };
  const Near* nearOf(std::size_t i, std::size_t j, Place other) const {
    return near_.empty() || other != starts_[j] ? nullptr : near_[i * graphs_.size() + j].get();
  }

  std::int32_t gx_, gy_, n_shapes_, reach_ = 0;
  std::vector<std::shared_ptr<const RobotGraph>> graphs_;
  Places starts_;
  std::vector<std::vector<Place>> goals_;
  std::vector<std::uint8_t> has_goal_;
  std::vector<PairTable> tables_;            // by two shapes
  std::vector<std::unique_ptr<Near>> near_;  // by two robots, where they start close
};

}  // namespace yarm::joint

#endif  // YARM_JOINT_FLEET_HPP
