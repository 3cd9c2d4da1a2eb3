#ifndef YARM_JOINT_PAIRS_HPP
#define YARM_JOINT_PAIRS_HPP

// What any two robots of a fleet cost each other on the way to their goals, when nobody else is there.

#include <cstdint>
#include <vector>

#include "fleet.hpp"

namespace yarm::joint {

/// Exact costs of every two robots by their places, beyond what each costs alone. Pairs that cannot both come to their
/// goals make a configuration hopeless, whoever else is there.
class Pairs {
 public:
  /// For fleets of which `look-ups` says that it is not too much. to_go: each robot's cost to go alone.
  Pairs(const Fleet& fleet, const std::vector<std::vector<Cost>>& to_go);

  /// Look-ups that the tables take; kTooMany for a fleet that they are not for.
  static std::int64_t lookUps(const Fleet& fleet);
  static constexpr std::int64_t kTooMany = std::int64_t{1} << 60;

  /// What two robots cost each other; kFar when they cannot both come to their goals.
  Cost extra(std::size_t i, Place place, std::size_t j, Place other) const {
    const Table& table = tables_[i * n_ + j];
    const std::uint16_t cost = table.transposed
                                   ? tables_[j * n_ + i].cost[static_cast<std::size_t>(other) * table.width + place]
                                   : table.cost[static_cast<std::size_t>(place) * table.width + other];
    return cost == kNever ? kFar : cost;
  }
  /// Sum over one robot's pairs with all others; kFar when one of them is hopeless.
  Cost extraOf(std::size_t i, Place place, const Places& places) const;
  /// Sum over all pairs; kFar when one of them is hopeless.
  Cost extraOf(const Places& places) const;

 private:
  static constexpr std::uint16_t kNever = 0xffff;
  struct Table {
    bool transposed = false;
    std::size_t width = 0;
    std::vector<std::uint16_t> cost;
  };

  void fill(std::size_t i, std::size_t j, const std::vector<Cost>& mine, const std::vector<Cost>& theirs);

  const Fleet& fleet_;
  std::size_t n_;
  std::vector<Table> tables_;  // by two robots; that of a greater and a lesser number is the other one, transposed
};

}  // namespace yarm::joint

#endif  // YARM_JOINT_PAIRS_HPP
