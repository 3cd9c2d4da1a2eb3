#ifndef YARM_JOINT_EXCHANGE_HPP
#define YARM_JOINT_EXCHANGE_HPP

// A proof that goals cannot be reached, from the configurations in which robots of one kind are taken for each other.

#include <cstdint>
#include <set>
#include <vector>

#include "permutations.hpp"
#include "search.hpp"

namespace yarm::joint {

/// Looks at every *pattern* that can be reached: which places are taken, by which kind of robot. There are fewer than
/// configurations by the exchanges of robots of one kind: 15 pieces that slide in a frame of 16 places have 16 patterns
/// and 15! times as many configurations. Along a tree of patterns everybody's place is known. Each move that is not in
/// the tree closes a loop, after which some robots have taken the places of others; whatever is driven, the robots end
/// in an exchange that is a product of those of the loops. If in no pattern that holds the goals such a product brings
/// everybody to his own, there is no plan. (Moves that cannot be made backwards are taken as if they could, so that a
/// proof stays one.)
class Exchange {
 public:
  /// Only for fleets of which `fits` holds.
  Exchange(const Fleet& fleet, std::int64_t memory_bytes);

  /// No robots within each other's margin at the start, and two of one kind at least.
  static bool fits(const Fleet& fleet);

  /// Looks at patterns until `work` look-ups are done or all have been; kExhausted: there is no plan; kFull: nothing is
  /// said, for too many patterns or because a plan may exist.
  Outcome advance(std::int64_t work);

  std::int64_t visited() const { return static_cast<std::int64_t>(count_); }
  std::int64_t work() const { return work_; }

 private:
  // Who stands where, robots of one kind by rising place.
  struct Pattern {
    Places places;
    Permutation robots;
  };

  void sort(Pattern* pattern) const;
  std::int32_t find(const Places& places, std::uint64_t hash) const;
  void add(const Pattern& pattern, std::uint64_t hash);
  void grow();
  void expand(std::int32_t number);
  void close(const Pattern& pattern, std::int32_t known);
  void arrive(const Pattern& pattern);
  Outcome verdict() const;
  std::int64_t bytes() const;

  const Fleet& fleet_;
  std::int64_t memory_bytes_, work_ = 0;
  std::vector<std::int32_t> kind_, first_;  // of each robot; of each kind, its first slot
  std::vector<std::uint8_t> wanting_;       // robots with a goal
  std::vector<Place> places_;
  std::vector<std::uint8_t> robots_;
  std::vector<std::int32_t> table_;
  std::size_t count_ = 0, next_ = 0;
  PermutationGroup group_;
  std::set<std::vector<std::uint8_t>> ends_;  // what must take the place of each wanting robot
};

}  // namespace yarm::joint

#endif  // YARM_JOINT_EXCHANGE_HPP
