// One thread that does what it is given, one thing after the other.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace yarm::slam {

/// Runs jobs in the order given: in the caller's thread when made inline, else in its own.
class Worker {
 public:
  explicit Worker(bool is_inline);
  ~Worker();  ///< waits for the job at work; those not begun are dropped
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Does the job, or queues it.
  void submit(std::function<void()> job);
  /// Jobs queued or at work.
  [[nodiscard]] int pending() const;
  /// Waits until there are none.
  void wait();

 private:
  void run();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> jobs_;
  bool stopping_{false};
  bool inline_;
  std::thread thread_;
};

}  // namespace yarm::slam
