// Time that goes backwards: the one place where C++ nodes notice it (Python: yarm.ros.common.clock).
#pragma once

#include <cstdint>
#include <optional>

namespace yarm {

/// A step back of more than this is a restart of the simulator, not reordering.
inline constexpr std::int64_t kJumpBackNs = 100'000'000;

/// Watches a time that should only grow. Not thread-safe.
class ClockWatch {
 public:
  /// Notes the present time; true when it has gone back since the last call.
  bool wentBack(std::int64_t now_ns) {
    const bool back = last_ns_ && now_ns + kJumpBackNs < *last_ns_;
    last_ns_ = now_ns;
    return back;
  }

 private:
  std::optional<std::int64_t> last_ns_;
};

}  // namespace yarm
