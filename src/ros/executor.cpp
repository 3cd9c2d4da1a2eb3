#include "yarm/ros/executor.hpp"

#include "yarm/ros/pulse.hpp"

#include <malloc.h>

#include <algorithm>
#include <chrono>

namespace yarm {

namespace {
constexpr double kIdleWaitS = 0.05;
constexpr double kBusyWaitS = 0.001;
constexpr int kKeepBytes = 32 << 20;  // the most glibc accepts as a threshold
}  // namespace

Executor& Executor::instance() {
  static Executor executor;
  return executor;
}

Executor::~Executor() {
  stopping_ = true;
  if (thread_.joinable()) {
    thread_.join();
  }
}

std::unique_lock<std::mutex> Executor::pause() {
  ++pausing_;
  std::unique_lock<std::mutex> lock(mutex_);
  --pausing_;
  return lock;
}

void Executor::add(PolledNode& node) {
  nodes_.push_back(&node);
  if (!thread_.joinable()) {
    thread_ = std::thread([this] { run(); });
  }
}

void Executor::remove(PolledNode& node) {
  nodes_.erase(std::remove(nodes_.begin(), nodes_.end(), &node), nodes_.end());
}

void Executor::run() {
  Pulse pulse;
  while (!stopping_ && ros::ok()) {
    pulse.beat();
    while (pausing_ > 0) {
      std::this_thread::yield();
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    const bool waiting =
        std::any_of(nodes_.begin(), nodes_.end(), [](const PolledNode* node) { return node->waiting(); });
    queue_.callOne(ros::WallDuration(waiting ? kBusyWaitS : kIdleWaitS));
    for (PolledNode* node : nodes_) {
      node->poll();
    }
  }
}

std::int64_t steadyNow() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void keepBuffers() {
  mallopt(M_MMAP_THRESHOLD, kKeepBytes);
  mallopt(M_TRIM_THRESHOLD, 8 * kKeepBytes);
  mallopt(M_TOP_PAD, kKeepBytes);
  mallopt(M_ARENA_MAX, 2);
}

}  // namespace yarm
