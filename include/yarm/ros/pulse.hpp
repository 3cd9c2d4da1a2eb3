// Signs of life to the supervisor (yarm.safety.supervise, docs/safety.md): a byte now and then through a pipe.
#pragma once

#include <cstdint>

namespace yarm {

/// Beats while the process is at work; without a supervisor nothing happens. Not thread-safe.
class Pulse {
 public:
  /// Finds the pipe's end in YARM_PULSE; programs that this one starts do not inherit it.
  Pulse();

  /// Gives a sign of life, at most twice a second; called from where the work is done.
  void beat();

 private:
  int file_ = -1;
  std::int64_t beat_ns_ = 0;
};

}  // namespace yarm
