#ifndef YARM_JOINT_SOLVER_HPP
#define YARM_JOINT_SOLVER_HPP

// The searches of one problem, quick ones beside the complete one, and the plan made cheaper afterwards.

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "crowd.hpp"
#include "exchange.hpp"
#include "search.hpp"

namespace yarm::joint {

class Solver {
 public:
  Solver(Fleet fleet, std::int64_t memory_bytes);
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  /// Goes on searching; kFull when the memory is used up without an answer.
  Outcome run(std::int64_t work);
  /// Makes the plan found cheaper: the whole of it by an exact search where that ends, then stretches of it.
  void improve(std::int64_t work);

  /// Whether what is impossible is so by the exchanges of robots of one kind, not by every configuration looked at.
  bool byExchange() const { return by_exchange_; }
  const Fleet& fleet() const { return fleet_; }
  const std::vector<UnitMove>& plan() const { return plan_; }
  Cost cost() const { return costOf(plan_, 0, plan_.size()); }
  std::int64_t visited() const;
  std::int64_t work() const;

 private:
  struct Stage {
    std::unique_ptr<Search> search;
    std::size_t stops;  // a robot; 0 for every edge
    bool pairs = false;
    bool ended = false;
  };

  void makeStages();
  void addPairs();
  std::int64_t memoryShare() const;
  Search& searchOf(Stage* stage);
  const std::vector<Place>& spreadOf(std::size_t i, std::size_t stops);
  Outcome turnOfCrowd();
  Outcome turnOfRest();
  bool bring(std::size_t i);
  Outcome turnOfExchange();
  Outcome turnOfSearches(bool* any);
  std::vector<UnitMove> unitPlan(Places places, const std::vector<Leg>& legs) const;
  Cost costOf(const std::vector<UnitMove>& moves, std::size_t begin, std::size_t end) const;
  std::vector<Places> configurations() const;
  void shorten(std::int64_t work);
  void improveWhole(std::int64_t work);
  bool improveStretch(std::size_t begin, std::size_t end, const std::vector<Places>& at, std::int64_t work);

  Fleet fleet_;
  std::int64_t memory_bytes_;
  std::vector<std::vector<Cost>> to_go_;
  std::vector<Stage> stages_;
  std::unique_ptr<Masks> masks_;
  std::unique_ptr<Pairs> pairs_;
  std::int64_t pairs_work_ = 0;
  std::unique_ptr<Crowd> crowd_;
  std::unique_ptr<Exchange> exchange_;
  std::int32_t rest_from_ = 0;  // the crowd's configuration that the rest goes on from
  std::vector<UnitMove> rest_plan_;
  Places rest_at_;
  std::size_t rest_movable_ = 1;
  std::int64_t rest_allowed_ = 0, rest_work_ = 0, rest_visited_ = 0;
  std::int64_t crowd_turn_ = 0;  // look-ups
  bool crowd_ended_ = false, exchange_ended_ = false;
  std::map<std::pair<const RobotGraph*, std::size_t>, std::vector<Place>> spreads_;
  bool impossible_ = false, by_exchange_ = false;
  std::vector<UnitMove> plan_;
  bool found_ = false;
  std::int64_t improving_work_ = 0, improving_visited_ = 0;
};

}  // namespace yarm::joint

#endif  // YARM_JOINT_SOLVER_HPP
