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

/// What one robot can do by the map alone: the places reachable from its start.
class RobotGraph {
 public:
  RobotGraph(std::int32_t gx, std::int32_t gy, const YarmJointRobot& robot);

  Place size() const { return static_cast<Place>(stands_.size()); }
  const Stand& stand(Place p) const { return stands_[p]; }
  /// Shape that the robot sweeps in a turn.
  std::int32_t turnShape(std::int32_t turn) const { return turn_shapes_[turn]; }
  const Edge* begin(Place p) const { return edges_.data() + first_[p]; }
  const Edge* end(Place p) const { return edges_.data() + first_[p + 1]; }
  Cost greatestCost() const { return greatest_cost_; }
  /// Places on the goal; none for a robot without one.
  const std::vector<Place>& goals() const { return goals_; }
  bool hasGoal() const { return has_goal_; }
  /// Least cost from every place to one of some; kFar where no way leads.
  std::vector<Cost> costsTo(const std::vector<Place>& ends) const;
  /// Places far apart that cover the graph, the start first, `count` at most; every place when there are no more.
  std::vector<Place> spread(std::size_t count) const;

 private:
  void addEdges(std::int32_t gx, std::int32_t gy, const YarmJointRobot& robot);

  std::vector<Stand> stands_;
  std::vector<std::int32_t> turn_shapes_;
  std::vector<std::int32_t> first_;
  std::vector<Edge> edges_;
  std::vector<std::int32_t> first_back_;
  std::vector<Edge> back_;  // towards where an edge comes from
  std::vector<Place> goals_;
  bool has_goal_ = false;
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
  const RobotGraph& graph(std::size_t i) const { return graphs_[i]; }
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
  struct Near {
    std::vector<std::uint8_t> blocked, turn_blocked;
  };
  const Near* nearOf(std::size_t i, std::size_t j, Place other) const {
    return near_.empty() || other != 0 ? nullptr : near_[i * graphs_.size() + j].get();
  }

  std::int32_t gx_, gy_, n_shapes_;
  std::vector<RobotGraph> graphs_;
  std::vector<PairTable> tables_;            // by two shapes
  std::vector<std::unique_ptr<Near>> near_;  // by two robots, where they start close; their starts are place 0
};

}  // namespace yarm::joint

#endif  // YARM_JOINT_FLEET_HPP
