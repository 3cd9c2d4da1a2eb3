// Brings clouds of several cameras together by capture time. No ROS, no clocks: stamps and "now" are handed in.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace yarm {

struct SetAssemblerOptions {
  std::size_t cameras = 4;
  std::int64_t tolerance_ns = 10'000'000;  // stamps this close belong to one set
  std::int64_t timeout_ns = 200'000'000;   // wall time after which a set goes on without a camera
  std::int64_t silent_grace_ns = 0;        // wall time a set waits for cameras that are already silent
  std::size_t max_pending = 32;            // sets kept waiting at most; then the oldest goes on as it is
};

enum class Admission {
  accepted,   // waits in its set
  backwards,  // not newer than this camera's previous stamp
  late,       // its set, or a newer one, has gone on already
};

// One moment as several cameras saw it. items[camera] is empty where a camera is missing.
template <class Item>
struct CameraSet {
  std::int64_t stamp_ns = 0;  // oldest capture time in the set
  std::vector<std::optional<Item>> items;
};

// Sets leave in the order of their stamps, each once. A set leaves when every camera has delivered, was skipped or is
// known to have nothing for it: because it has sent a newer stamp, because it is silent, or because the set has waited
// for timeout_ns. A silent camera holds nothing up and is back with its next cloud. Not thread-safe.
template <class Item>
class SetAssembler {
 public:
  explicit SetAssembler(const SetAssemblerOptions& options) : options_(options), cameras_(options.cameras) {}

  // Adds a cloud that arrived at now_ns (any monotonic wall clock). O(pending sets).
  Admission add(std::size_t camera, std::int64_t stamp_ns, std::int64_t now_ns, Item item) {
    return admit(camera, stamp_ns, now_ns, std::optional<Item>(std::move(item)));
  }

  // The camera delivered for this stamp, but nothing that can be used: its set does not wait for it.
  Admission skip(std::size_t camera, std::int64_t stamp_ns, std::int64_t now_ns) {
    return admit(camera, stamp_ns, now_ns, std::nullopt);
  }

  // The oldest set, when it is ready at now_ns.
  std::optional<CameraSet<Item>> take(std::int64_t now_ns) {
    if (pending_.empty() || !ready(pending_.front(), now_ns)) {
      return std::nullopt;
    }
    CameraSet<Item> set = std::move(pending_.front().set);
    pending_.pop_front();
    released_ns_ = set.stamp_ns;
    return set;
  }

  // Whether the set that leaves next has this stamp (within the tolerance).
  bool isOldest(std::int64_t stamp_ns) const { return !pending_.empty() && sameSet(pending_.front(), stamp_ns); }

  std::size_t pending() const { return pending_.size(); }

  // Wall time since the camera was last heard, or since the first cloud of any camera if it never was.
  std::int64_t silentFor(std::size_t camera, std::int64_t now_ns) const {
    return started_ ? now_ns - cameras_[camera].heard_ns : 0;
  }

  bool isSilent(std::size_t camera, std::int64_t now_ns) const {
    return silentFor(camera, now_ns) > options_.timeout_ns;
  }

  // Time has started again: forget stamps and waiting sets. Silence is counted on.
  void reset() {
    pending_.clear();
    released_ns_ = kNever;
    for (Camera& camera : cameras_) {
      camera.stamp_ns = kNever;
    }
  }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 4;

  struct Camera {
    std::int64_t stamp_ns = kNever;
    std::int64_t heard_ns = kNever;
  };

  struct Pending {
    CameraSet<Item> set;
    std::vector<bool> done;
    std::int64_t arrived_ns = 0;
  };

  Admission admit(std::size_t index, std::int64_t stamp_ns, std::int64_t now_ns, std::optional<Item> item) {
    if (!started_) {
      started_ = true;
      for (Camera& camera : cameras_) {
        camera.heard_ns = now_ns;
      }
    }
    Camera& camera = cameras_[index];
    if (stamp_ns <= camera.stamp_ns) {
      return Admission::backwards;
    }
    camera.heard_ns = now_ns;
    camera.stamp_ns = stamp_ns;
    if (stamp_ns <= released_ns_ + options_.tolerance_ns) {
      return Admission::late;
    }
    place(index, stamp_ns, now_ns, std::move(item));
    return Admission::accepted;
  }

  void place(std::size_t index, std::int64_t stamp_ns, std::int64_t now_ns, std::optional<Item> item) {
    auto at = std::find_if(pending_.begin(), pending_.end(), [&](const Pending& waiting) {
      return sameSet(waiting, stamp_ns) || waiting.set.stamp_ns > stamp_ns;
    });
    if (at == pending_.end() || !sameSet(*at, stamp_ns) || at->done[index]) {
      Pending fresh;
      fresh.set.stamp_ns = stamp_ns;
      fresh.set.items.resize(options_.cameras);
      fresh.done.resize(options_.cameras, false);
      fresh.arrived_ns = now_ns;
      const bool behind = at != pending_.end() && at->set.stamp_ns <= stamp_ns;
      at = pending_.insert(behind ? std::next(at) : at, std::move(fresh));
    }
    at->set.stamp_ns = std::min(at->set.stamp_ns, stamp_ns);
    at->set.items[index] = std::move(item);
    at->done[index] = true;
  }

  bool sameSet(const Pending& waiting, std::int64_t stamp_ns) const {
    return std::abs(waiting.set.stamp_ns - stamp_ns) <= options_.tolerance_ns;
  }

  bool ready(const Pending& waiting, std::int64_t now_ns) const {
    const std::int64_t waited = now_ns - waiting.arrived_ns;
    if (waited > options_.timeout_ns || pending_.size() > options_.max_pending) {
      return true;
    }
    for (std::size_t index = 0; index < cameras_.size(); ++index) {
      const bool skipped = cameras_[index].stamp_ns > waiting.set.stamp_ns + options_.tolerance_ns;
      if (waiting.done[index] || skipped) {
        continue;
      }
      if (!isSilent(index, now_ns) || waited < options_.silent_grace_ns) {
        return false;
      }
    }
    return true;
  }

  SetAssemblerOptions options_;
  std::vector<Camera> cameras_;
  std::deque<Pending> pending_;
  std::int64_t released_ns_ = kNever;
  bool started_ = false;
};

}  // namespace yarm
