#ifndef YARM_JOINT_SHORTEN_HPP
#define YARM_JOINT_SHORTEN_HPP

// A plan put into another order and its detours taken out, without a search over configurations.

#include <cstdint>
#include <vector>

#include "fleet.hpp"

namespace yarm::joint {

/// Edge of a robot's graph from one place to another; the cheapest of several. There must be one.
const Edge* edgeBetween(const RobotGraph& graph, Place from, Place to);

/// Shortens plans of one fleet from where all start. Never makes one dearer.
class Shortener {
 public:
  explicit Shortener(const Fleet& fleet);

  /// The plan with moves of one robot brought together where moves of others between may as well be made later, and
  /// with ways and stops of robots left out that nobody needs, until `work` look-ups are done.
  std::vector<UnitMove> shortened(const std::vector<UnitMove>& plan, std::int64_t work);
  std::int64_t work() const { return work_; }

 private:
  // A robot's way while all others stand.
  struct Run {
    std::int32_t robot;
    std::vector<Place> way;
    Cost cost;
  };

  std::vector<Run> runs(const std::vector<UnitMove>& plan);
  bool commute(std::int32_t i, Place from, Place to, std::int32_t j, Place other_from, Place other_to);
  bool pass(std::vector<Run>* runs, std::int64_t until);
  bool reroute(Run* run, const Places& at);
  bool join(std::vector<Run>* runs, std::size_t k, const Places& at);
  bool standsClear(const std::vector<Run>& runs, std::size_t begin, std::size_t end, std::int32_t i, Place place);
  std::vector<Place> way(std::int32_t i, Place from, Place to, const Places& at, Cost below, Cost* cost);
  Run runOf(std::int32_t i, std::vector<Place> way) const;

  const Fleet& fleet_;
  std::int64_t work_ = 0;
  std::vector<Cost> cost_;
  std::vector<Place> before_;
};

}  // namespace yarm::joint

#endif  // YARM_JOINT_SHORTEN_HPP
