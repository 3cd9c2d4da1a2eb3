// How often something comes, from the times between the last few.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace yarm {

/// The median of the last seven intervals: lost ones and jitter do not move it. Not thread-safe.
class PeriodEstimate {
 public:
  /// Notes an interval, ns, more than 0.
  void add(std::int64_t interval_ns) {
    last_[next_ % last_.size()] = interval_ns;
    ++next_;
    std::array<std::int64_t, kKept> sorted = last_;
    const std::size_t count = std::min(next_, last_.size());
    std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count));
    median_ = sorted[(count - 1) / 2];
  }

  /// The period, ns; 0 while nothing is known.
  std::int64_t value() const { return median_; }

  /// Forgets all.
  void reset() { *this = PeriodEstimate(); }

 private:
  static constexpr std::size_t kKept = 7;
  std::array<std::int64_t, kKept> last_{};
  std::size_t next_ = 0;
  std::int64_t median_ = 0;
};

}  // namespace yarm
