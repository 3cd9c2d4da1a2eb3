// What a hand says of itself, by the time at which it is so. No ROS.
#pragma once

#include <cstdint>
#include <deque>
#include <utility>

namespace yarm {

/// Remembers whether a hand holds something. With stamps a word counts for the capture times from its own on, whenever
/// it arrives; without them (a hand that has no clock) it counts from its arrival. Not thread-safe.
class HandWords {
 public:
  /// A word without a stamp; it counts until the first one with a stamp comes.
  void say(bool holds) { unstamped_ = holds; }

  /// What is so at a stamp, ns; one before the newest is of a new run of the simulator.
  void say(std::int64_t stamp_ns, bool holds) {
    if (stamp_ns < newest_ns_) {
      changes_.clear();
    }
    newest_ns_ = stamp_ns;
    if (changes_.empty() || changes_.back().second != holds) {
      changes_.emplace_back(stamp_ns, holds);
    }
  }

  /// Whether what is so at a stamp is known; true of a hand without stamps.
  bool covers(std::int64_t stamp_ns) const { return changes_.empty() || newest_ns_ >= stamp_ns; }

  /// Whether it holds something by its newest word.
  bool holds() const { return changes_.empty() ? unstamped_ : changes_.back().second; }

  /// Whether it holds something at a stamp not before the one last asked for; the oldest word known for what is before.
  bool holdsAt(std::int64_t stamp_ns) {
    while (changes_.size() > 1 && changes_[1].first <= stamp_ns) {
      changes_.pop_front();
    }
    return changes_.empty() ? unstamped_ : changes_.front().second;
  }

 private:
  bool unstamped_ = false;
  std::int64_t newest_ns_ = 0;
  std::deque<std::pair<std::int64_t, bool>> changes_;  // the first is what was so when last asked
};

}  // namespace yarm
