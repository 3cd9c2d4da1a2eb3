#ifndef YARM_JOINT_SEARCH_HPP
#define YARM_JOINT_SEARCH_HPP

// Best-first search over joint configurations, with a set of those visited.

#include <cstdint>
#include <vector>

#include "fleet.hpp"
#include "masks.hpp"
#include "pairs.hpp"

namespace yarm::joint {

/// One robot's move between two places while all others stand.
struct Leg {
  std::int32_t robot;
  Place from, to;
};

/// How configurations follow one another, and which are looked at first.
struct SearchParams {
  /// Stops of each robot, 1 a place: a robot goes to any stop it can reach while the others stand. Empty: one edge at a
  /// time.
  std::vector<std::vector<std::uint8_t>> stops;
  /// Robots that may move; empty for all.
  std::vector<std::uint8_t> movable;
  /// Weight of the cost to go in the second queue's order, f = cost so far + weight * cost to go.
  Cost weight = 3;
  /// Whether a first queue, by the cost to go alone, takes turns with the second one.
  bool greedy = true;
  /// Adds what any two cost each other to the cost to go, and leaves hopeless configurations out; for a first plan, not
  /// for the cheapest one.
  const Pairs* pairs = nullptr;
  /// Says what is free; none: every edge is looked up. Shared by searches that take turns.
  Masks* masks = nullptr;
  /// Only plans cheaper than this are wanted.
  Cost below = kFar;
  std::int64_t memory_bytes = std::int64_t{256} << 20;
};

enum class Outcome { kOpen, kFound, kExhausted, kFull };

/// Goes on from where it stopped each time it is asked.
class Search {
 public:
  /// A search from `start` to where every robot's cost to go, (size of its graph), is 0. Both are referred to.
  Search(const Fleet& fleet, Places start, const std::vector<std::vector<Cost>>& to_go, SearchParams params);

  /// Looks at configurations until `work` look-ups are done or the outcome is known. After kFound it goes on looking
  /// for a cheaper plan, and says kFound for each, in the end kExhausted.
  Outcome advance(std::int64_t work);

  /// Legs of the cheapest plan found.
  std::vector<Leg> plan() const;
  bool found() const { return goal_ >= 0; }
  Cost cost() const { return best_; }
  std::int64_t visited() const { return static_cast<std::int64_t>(cost_.size()); }
  std::int64_t work() const { return work_; }

 private:
  // Configurations by a whole number, the last one pushed first.
  class Buckets {
   public:
    void push(Cost key, std::int32_t node);
    // The next configuration; -1 when there is none.
    std::int32_t pop();
    std::size_t size() const { return size_; }

   private:
    std::vector<std::vector<std::int32_t>> buckets_;
    std::size_t lowest_ = 0, size_ = 0;
  };

  Cost costToGo(const Places& places) const;
  void placesOf(std::int32_t node, Places* places) const;
  bool same(std::int32_t node, const Places& places) const;
  // Number of a configuration; -1 when it is new.
  std::int32_t find(const Places& places, std::uint64_t hash) const;
  std::int32_t add(const Places& places, std::uint64_t hash, std::int32_t parent, Cost cost, Cost to_go);
  void enter(std::int32_t node, std::uint64_t hash);
  std::uint64_t hashOf(const Places& places) const;
  std::uint64_t key(std::size_t robot, Place place) const;
  void push(std::int32_t node);
  void expand(std::int32_t node);
  void expandEdges(std::int32_t node, std::size_t i);
  void expandStops(std::int32_t node, std::size_t i);
  bool isFree(std::size_t i, Place from, const Edge& edge);
  void offer(std::int32_t node, std::size_t i, Place to, Cost cost);
  std::int64_t bytes() const;

  const Fleet& fleet_;
  const std::vector<std::vector<Cost>>& to_go_;
  SearchParams params_;
  bool wide_;  // whether a place needs more than 16 bits
  std::vector<std::uint16_t> places_;
  std::vector<Cost> cost_, left_;
  std::vector<std::int32_t> parent_;
  std::vector<std::uint8_t> expanded_;
  std::vector<std::uint64_t> table_;  // upper half of a hash, and the number of its configuration + 1
  Buckets greedy_, weighted_;
  bool turn_ = false;
  std::int32_t goal_ = -1;
  Cost best_;
  std::int64_t work_ = 0;
  // Of the expansion at hand.
  Places here_;
  Cost here_left_ = 0, here_extra_ = 0;
  std::uint64_t here_hash_ = 0;
  const std::vector<std::uint64_t>* blocked_ = nullptr;  // of the robot at hand
  std::vector<Cost> reached_;
  std::vector<Place> touched_;
  std::vector<std::vector<Place>> rings_;
};

/// Unit moves of a leg while the others stand at their places; empty when there is no way.
std::vector<Place> unitMoves(const Fleet& fleet, const Places& places, const Leg& leg);

}  // namespace yarm::joint

#endif  // YARM_JOINT_SEARCH_HPP
