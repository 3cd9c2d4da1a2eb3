// Where every seed was at a capture time, from the seed messages of the last seconds. No ROS.
#pragma once

#include "yarm/perception/types.hpp"
#include "yarm/sync/clock.hpp"

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace yarm {

/// How well seeds belong to a stamp.
enum class SeedMatch {
  exact,   ///< measured at, or interpolated to, the stamp
  newest,  ///< the buffer ends before the stamp: the newest seeds as they are
  none,    ///< no seeds at all
};

/// The seeds for a stamp.
struct SeedLookup {
  SeedMatch match = SeedMatch::none;    ///< how well they belong to it
  std::vector<perception::Seed> seeds;  ///< the objects that existed at the stamp
  std::int64_t lag_ns = 0;              ///< how far the newest seeds lie before the stamp; 0 when matched
};

/// Keeps two seconds of seed messages. What time it is only the clock says: a stamp that lies elsewhere is refused, and
/// the buffer starts afresh when the clock goes back. Not thread-safe.
class SeedBuffer {
 public:
  /// most_ahead_ns: how far a stamp may lie ahead of the clock, which comes on a way of its own.
  explicit SeedBuffer(std::int64_t most_ahead_ns = 500'000'000) : most_ahead_ns_(most_ahead_ns) {}

  /// Notes the time of the clock; 0: not known, then stamps are held against each other only.
  void noticeClock(std::int64_t now_ns);

  /// Adds the seeds of one tick, in the order of their stamps; now_ns as in noticeClock. Says why a stamp too far from
  /// the clock, or more than kJumpBackNs before the newest one, is refused; a slightly older or equal one is ignored.
  std::string add(std::int64_t stamp_ns, std::vector<perception::Seed> seeds, std::int64_t now_ns);

  /// Whether the buffer reaches up to the stamp.
  bool covers(std::int64_t stamp_ns) const { return !ticks_.empty() && ticks_.back().stamp_ns >= stamp_ns; }

  /// Each seed interpolated (position linearly, rotation along the shortest arc) to the stamp. Which objects exist is
  /// taken from the first message at or after it. O(log messages + seeds).
  SeedLookup lookup(std::int64_t stamp_ns) const;

 private:
  struct Tick {
    std::int64_t stamp_ns = 0;
    std::vector<perception::Seed> seeds;
  };

  /// What is wrong with a stamp at a time of the clock; empty when nothing is.
  std::string stampFault(std::int64_t stamp_ns, std::int64_t now_ns) const;

  std::int64_t most_ahead_ns_;
  ClockWatch clock_;
  std::deque<Tick> ticks_;
  std::optional<Tick> early_;  ///< refused as too old: the first of a new time when the clock goes back next
};

}  // namespace yarm
