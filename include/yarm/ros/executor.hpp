// One thread for all perception nodes of a process: callbacks in the order of arrival, no locks, no thread hops between
// the stages. A node never blocks in it; what has to wait is put aside and looked at again in poll().
#pragma once

#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace yarm {

/// A node that lives on the executor.
class PolledNode {
 public:
  virtual ~PolledNode() = default;
  /// Called after every batch of callbacks, and every few milliseconds while waiting() is true.
  virtual void poll() = 0;
  /// Whether something is put aside.
  virtual bool waiting() const = 0;
};

/// One thread for all nodes of the process: it runs their callbacks in batches and polls them in between.
class Executor {
 public:
  /// The process's executor; its thread starts with the first node.
  static Executor& instance();
  ~Executor();

  /// The queue that nodes' subscribers and services must be made with.
  ros::CallbackQueue& queue() { return queue_; }

  /// Holds the thread between batches; to make and remove nodes.
  std::unique_lock<std::mutex> pause();

  void add(PolledNode& node);     ///< while paused
  void remove(PolledNode& node);  ///< while paused

 private:
  Executor() = default;
  void run();

  ros::CallbackQueue queue_;
  std::mutex mutex_;
  std::atomic<int> pausing_{0};
  std::vector<PolledNode*> nodes_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

/// Monotonic wall time, ns.
std::int64_t steadyNow();

/// Lets the allocator keep big buffers instead of giving each back to the kernel: without it most of the time spent on
/// a cloud is page faults. For the whole process.
void keepBuffers();

}  // namespace yarm
