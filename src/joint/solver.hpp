#ifndef YARM_JOINT_SOLVER_HPP
#define YARM_JOINT_SOLVER_HPP

// The searches of one problem, coarse ones beside the complete one, and the plan made cheaper afterwards.

#include <cstdint>
#include <memory>
#include <vector>

#include "search.hpp"

namespace yarm::joint {

/// A robot's next place.
struct UnitMove {
  std::int32_t robot;
  Place to;
};

class Solver {
 public:
  Solver(Fleet fleet, std::int64_t memory_bytes);
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  /// Goes on searching; kFull when the memory is used up without an answer.
  Outcome run(std::int64_t work);
  /// Makes the plan found cheaper: the whole of it by an exact search where that ends, then stretches of it.
  void improve(std::int64_t work);

  const Fleet& fleet() const { return fleet_; }
  const std::vector<UnitMove>& plan() const { return plan_; }
  Cost cost() const { return costOf(plan_, 0, plan_.size()); }
  std::int64_t visited() const;
  std::int64_t work() const;

 private:
  struct Stage {
    std::unique_ptr<Search> search;
    std::size_t stops;  // a robot; 0 for every edge
    bool ended = false;
  };

  Search& searchOf(Stage* stage);
  std::vector<UnitMove> unitPlan(Places places, const std::vector<Leg>& legs) const;
  Cost costOf(const std::vector<UnitMove>& moves, std::size_t begin, std::size_t end) const;
  std::vector<Places> configurations() const;
  void improveWhole(std::int64_t work);
  bool improveStretch(std::size_t begin, std::size_t end, const std::vector<Places>& at, std::int64_t work);

  Fleet fleet_;
  std::int64_t memory_bytes_;
  Places start_;
  std::vector<std::vector<Cost>> to_go_;
  std::vector<Stage> stages_;
  bool impossible_ = false;
  std::vector<UnitMove> plan_;
  bool found_ = false;
  std::int64_t improving_work_ = 0, improving_visited_ = 0;
};

}  // namespace yarm::joint

#endif  // YARM_JOINT_SOLVER_HPP
