#ifndef YARM_JOINT_CROWD_HPP
#define YARM_JOINT_CROWD_HPP

// Depth-first search over configurations in rounds: in each every robot makes one edge at most.

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "search.hpp"

namespace yarm::joint {

/// For many robots with some room. After LaCAM (K. Okumura, AAAI 2023) with rounds by priority inheritance (K. Okumura
/// et al., PIBT, Artificial Intelligence 310, 2022); here a robot covers many columns, so that a move may push several
/// others, and the robots of a round move one after the other. Its end without a plan proves nothing.
class Crowd {
 public:
  /// From where all start to where every robot's cost to go, (size of its graph), is 0. Both are referred to.
  Crowd(const Fleet& fleet, const std::vector<std::vector<Cost>>& to_go, std::int64_t memory_bytes);

  /// Makes rounds until `work` look-ups are done or the outcome is known.
  Outcome advance(std::int64_t work);

  /// Moves of the plan found.
  std::vector<UnitMove> plan() const { return movesTo(goal_); }
  /// The configuration with the least cost to go so far, by a number that names it.
  std::int32_t best() const { return best_; }
  const Places& placesOf(std::int32_t node) const { return nodes_[node].places; }
  Cost leftOf(std::int32_t node) const { return nodes_[node].left; }
  /// Moves from where all start to a configuration.
  std::vector<UnitMove> movesTo(std::int32_t node) const;
  std::int64_t visited() const { return static_cast<std::int64_t>(nodes_.size()); }
  std::int64_t work() const { return work_; }

 private:
  struct Forced {
    std::int32_t before;  // the one that is forced too, -1 for none
    std::int32_t depth;   // how many are forced
    std::int32_t robot;
    std::int32_t edge;  // number among the robot's edges, -1 for staying
  };
  struct Node {
    std::int32_t parent;
    Cost left;
    Places places;
    std::vector<UnitMove> moves;  // from the parent
    std::vector<float> rank;
    std::vector<std::int32_t> order;
    std::vector<Forced> forced;
    std::size_t next = 0;  // of `forced`
  };
  struct Pusher {
    std::int32_t robot;
    Place from;
    const Edge* edge;
  };
  struct Choice {
    Cost left;
    std::int32_t pushed;
    std::uint32_t chance;
    const Edge* edge;  // none for staying
  };

  std::int32_t add(std::int32_t parent, std::vector<float> rank);
  std::int32_t known() const;
  bool round(const Node& node, const Forced& forced);
  bool force(const Node& node, const Forced& forced);
  bool step(std::size_t i);
  bool go(std::size_t i, const Edge* edge);
  bool pushAside(std::size_t i, const Edge& edge);
  bool stepAside(std::size_t i);
  bool clearOfPushers(std::size_t i, Place to);
  std::vector<Choice> choices(std::size_t i);
  void move(std::size_t i, Place to);
  Cost left() const;
  std::uint32_t chance();

  const Fleet& fleet_;
  const std::vector<std::vector<Cost>>& to_go_;
  std::int64_t memory_bytes_, bytes_ = 0, work_ = 0;
  std::vector<Node> nodes_;
  std::unordered_multimap<std::uint64_t, std::int32_t> table_;
  std::vector<std::int32_t> open_;
  std::int32_t goal_ = -1, best_ = 0;
  std::uint64_t chance_ = 0;
  // Of the round at hand.
  Places at_;
  std::vector<std::uint8_t> decided_;
  std::vector<Pusher> pushers_;
  std::vector<UnitMove> moves_;
};

}  // namespace yarm::joint

#endif  // YARM_JOINT_CROWD_HPP
