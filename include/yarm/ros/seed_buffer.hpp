// Where every seed was at a capture time, from the seed messages of the last seconds. No ROS.
#pragma once

#include "yarm/perception/types.hpp"

#include <cstdint>
#include <deque>
#include <vector>

namespace yarm {

enum class SeedMatch {
  exact,   // measured at, or interpolated to, the stamp
  newest,  // the buffer ends before the stamp: the newest seeds as they are
  none,    // no seeds at all
};

struct SeedLookup {
  SeedMatch match = SeedMatch::none;
  std::vector<perception::Seed> seeds;  // the objects that existed at the stamp
  std::int64_t lag_ns = 0;              // how far the newest seeds lie before the stamp; 0 when matched
};

// Keeps keep_ns of seed messages. Not thread-safe.
class SeedBuffer {
 public:
  explicit SeedBuffer(std::int64_t keep_ns = 2'000'000'000) : keep_ns_(keep_ns) {}

  // Adds the seeds of one tick, in the order of their stamps. A stamp more than kJumpBackNs before the newest one is a
  // restart and empties the buffer first; a slightly older or equal one is ignored.
  void add(std::int64_t stamp_ns, std::vector<perception::Seed> seeds);

  // Whether the buffer reaches up to the stamp.
  bool covers(std::int64_t stamp_ns) const { return !ticks_.empty() && ticks_.back().stamp_ns >= stamp_ns; }

  // Each seed interpolated (position linearly, rotation along the shortest arc) to the stamp. Which objects exist is
  // taken from the first message at or after it. O(log messages + seeds).
  SeedLookup lookup(std::int64_t stamp_ns) const;

  bool empty() const { return ticks_.empty(); }
  std::int64_t newestNs() const { return ticks_.empty() ? 0 : ticks_.back().stamp_ns; }
  void clear() { ticks_.clear(); }

 private:
  struct Tick {
    std::int64_t stamp_ns = 0;
    std::vector<perception::Seed> seeds;
  };

  std::int64_t keep_ns_;
  std::deque<Tick> ticks_;
};

}  // namespace yarm
