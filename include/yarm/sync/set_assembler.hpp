// Brings clouds of several cameras together by capture time. No ROS, no clocks: stamps and "now" are handed in.
#pragma once

#include "yarm/sync/period_estimate.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace yarm {

/// How sets are made.
struct SetAssemblerOptions {
  std::size_t cameras = 4;
  std::int64_t tolerance_ns = 10'000'000;  ///< stamps this close belong to one set, whatever the cameras' period
  std::int64_t timeout_ns = 200'000'000;   ///< wall time after which a set goes on without a camera
  std::int64_t silent_grace_ns = 0;        ///< wall time a set waits for cameras that are already silent
  std::size_t max_pending = 32;            ///< sets kept waiting at most; then the oldest goes on as it is
  bool free_running = true;  ///< also bring together cameras that are not synchronised; false: the tolerance alone
};

/// What became of a cloud.
enum class Admission {
  accepted,   ///< waits for its set
  backwards,  ///< not newer than this camera's previous stamp
  late,       ///< its set, or a newer one, has gone on already
};

/// One moment as several cameras saw it. items[camera] is empty where a camera is missing.
template <class Item>
struct CameraSet {
  std::int64_t stamp_ns = 0;  ///< oldest capture time in the set
  std::vector<std::optional<Item>> items;
};

/// A set has a beat: the stamp of the cloud that opened it. A cloud opens a set when it is more than the tolerance and
/// nine tenths of the cameras' period away from every other beat, so that the beats run at the cameras' own rate
/// whatever their phases and jitter; a camera whose last cloud was the beat itself opens the next one after six tenths.
/// Each camera then gives the cloud that is nearest to the beat, at most three quarters of a period away. Cameras that
/// are synchronised within the tolerance thus give one set a trigger. No cloud is in two sets.
///
/// Sets leave in the order of their stamps. A set leaves when every camera has delivered, was skipped or is known to
/// have nothing for it: because it has sent a newer stamp, because it is silent, or because the set has waited for
/// timeout_ns. A silent camera holds nothing up and is back with its next cloud. Not thread-safe.
template <class Item>
class SetAssembler {
 public:
  explicit SetAssembler(const SetAssemblerOptions& options) : options_(options), cameras_(options.cameras) {}

  /// Adds a cloud that arrived at now_ns (any monotonic wall clock). O(pending sets).
  Admission add(std::size_t camera, std::int64_t stamp_ns, std::int64_t now_ns, Item item) {
    return admit(camera, stamp_ns, now_ns, std::optional<Item>(std::move(item)));
  }

  /// The camera delivered for this stamp, but nothing that can be used: its set does not wait for it.
  Admission skip(std::size_t camera, std::int64_t stamp_ns, std::int64_t now_ns) {
    return admit(camera, stamp_ns, now_ns, std::nullopt);
  }

  /// The oldest set, when it is ready at now_ns.
  std::optional<CameraSet<Item>> take(std::int64_t now_ns) {
    const std::int64_t period_ns = periodAt(now_ns);
    if (beats_.empty() || !ready(beats_.front(), period_ns, now_ns)) {
      return std::nullopt;
    }
    CameraSet<Item> set;
    set.stamp_ns = beats_.front().stamp_ns;
    for (Camera& camera : cameras_) {
      const auto chosen = nearest(camera, beats_.front(), reachOf(period_ns));
      set.items.emplace_back();
      std::int64_t spent_ns = beats_.front().stamp_ns;
      if (chosen != camera.waiting.end()) {
        set.stamp_ns = std::min(set.stamp_ns, chosen->stamp_ns);
        spent_ns = std::max(spent_ns, chosen->stamp_ns);
        set.items.back() = std::move(chosen->item);
      }
      while (!camera.waiting.empty() && camera.waiting.front().stamp_ns <= spent_ns) {
        camera.waiting.pop_front();
      }
    }
    released_ = std::move(beats_.front());
    beats_.pop_front();
    return set;
  }

  /// Sets that wait.
  std::size_t pending() const { return beats_.size(); }

  /// The cameras' period as far as it is known, else 0.
  std::int64_t periodAt(std::int64_t now_ns) const {
    std::int64_t least = 0;
    for (std::size_t index = 0; options_.free_running && index < cameras_.size(); ++index) {
      const std::int64_t period_ns = cameras_[index].period.value();
      if (period_ns > 0 && !isSilent(index, now_ns) && (least == 0 || period_ns < least)) {
        least = period_ns;
      }
    }
    return least;
  }

  /// Wall time since the camera was last heard, or since the first cloud of any camera if it never was.
  std::int64_t silentFor(std::size_t camera, std::int64_t now_ns) const {
    return started_ ? now_ns - cameras_[camera].heard_ns : 0;
  }

  /// Whether the camera has not been heard for longer than the timeout.
  bool isSilent(std::size_t camera, std::int64_t now_ns) const {
    return silentFor(camera, now_ns) > options_.timeout_ns;
  }

  /// Time has started again: forget stamps and waiting sets. Silence is counted on.
  void reset() {
    beats_.clear();
    released_ = Beat();
    for (Camera& camera : cameras_) {
      camera.stamp_ns = kNever;
      camera.waiting.clear();
      camera.period.reset();
    }
  }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 4;

  struct Waiting {
    std::int64_t stamp_ns;
    std::optional<Item> item;
  };

  struct Camera {
    std::int64_t stamp_ns = kNever;
    std::int64_t heard_ns = kNever;
    std::deque<Waiting> waiting;  ///< in the order of their stamps
    PeriodEstimate period;
  };

  struct Beat {
    std::int64_t stamp_ns = kNever;
    std::int64_t arrived_ns = 0;
    std::vector<bool> on_it = {};  ///< cameras with a cloud of exactly this stamp
  };

  /// A cloud farther than this from a beat opens a set of its own.
  std::int64_t spacingOf(std::int64_t period_ns) const { return std::max(options_.tolerance_ns, period_ns * 9 / 10); }
  /// A cloud farther than this from a beat is not in its set.
  std::int64_t reachOf(std::int64_t period_ns) const { return std::max(options_.tolerance_ns, period_ns * 3 / 4); }
  /// The camera's next cloud cannot be nearer to a beat than one within this of it.
  std::int64_t promptOf(std::int64_t period_ns) const { return std::max(options_.tolerance_ns, period_ns / 2); }

  Admission admit(std::size_t index, std::int64_t stamp_ns, std::int64_t now_ns, std::optional<Item> item) {
    if (!started_) {
      started_ = true;
      heard_ns_ = now_ns;
      for (Camera& camera : cameras_) {
        camera.heard_ns = now_ns;
      }
    }
    Camera& camera = cameras_[index];
    if (stamp_ns <= camera.stamp_ns) {
      return Admission::backwards;
    }
    forgivePause(now_ns);
    if (camera.stamp_ns != kNever && stamp_ns - camera.stamp_ns <= options_.timeout_ns) {
      camera.period.add(stamp_ns - camera.stamp_ns);
    }
    camera.heard_ns = now_ns;
    camera.stamp_ns = stamp_ns;
    if (stamp_ns <= released_.stamp_ns + options_.tolerance_ns) {
      return Admission::late;
    }
    camera.waiting.push_back({stamp_ns, std::move(item)});
    if (camera.waiting.size() > 2 * options_.max_pending) {
      camera.waiting.pop_front();
    }
    noteBeat(index, stamp_ns, now_ns);
    return Admission::accepted;
  }

  /// A pause of all cameras is nobody's silence: the first cloud after it does not go on without those that owed
  /// nothing. They have half the timeout left, however long the pause was. A cloud whose stamp went back ends no pause,
  /// as it ends no silence.
  void forgivePause(std::int64_t now_ns) {
    const std::int64_t pause_ns = now_ns - heard_ns_;
    for (std::size_t index = 0; index < cameras_.size(); ++index) {
      if (isSilent(index, heard_ns_)) {
        continue;
      }
      if (pause_ns > options_.timeout_ns) {
        cameras_[index].heard_ns += pause_ns;
      } else if (pause_ns > options_.timeout_ns / 2 && owesNothing(index, now_ns)) {
        cameras_[index].heard_ns += pause_ns - options_.timeout_ns / 2;
      }
    }
    heard_ns_ = now_ns;
  }

  /// Whether the camera has delivered for the newest set that anybody opened.
  bool owesNothing(std::size_t index, std::int64_t now_ns) const {
    const Beat& newest = beats_.empty() ? released_ : beats_.back();
    return cameras_[index].stamp_ns >= newest.stamp_ns - reachOf(periodAt(now_ns));
  }

  /// Opens a set with this cloud where none is near.
  void noteBeat(std::size_t index, std::int64_t stamp_ns, std::int64_t now_ns) {
    const std::int64_t period_ns = periodAt(now_ns);
    const auto next = std::find_if(beats_.begin(), beats_.end(), [&](const Beat& b) { return b.stamp_ns > stamp_ns; });
    Beat& before = next == beats_.begin() ? released_ : *std::prev(next);
    if (before.stamp_ns == stamp_ns) {
      before.on_it[index] = true;
      return;
    }
    const bool was_beat = before.stamp_ns != kNever && before.on_it[index];
    const bool after = stamp_ns - before.stamp_ns > (was_beat ? period_ns * 6 / 10 : spacingOf(period_ns));
    const std::int64_t least = std::max(options_.tolerance_ns, period_ns * 6 / 10);
    if (!after || (next != beats_.end() && next->stamp_ns - stamp_ns <= least)) {
      return;
    }
    Beat beat;
    beat.stamp_ns = stamp_ns;
    beat.arrived_ns = now_ns;
    beat.on_it.assign(cameras_.size(), false);
    beat.on_it[index] = true;
    beats_.insert(next, std::move(beat));
  }

  /// The waiting cloud of a camera that is nearest to the oldest beat, within reach of it and nearer to no other beat.
  typename std::deque<Waiting>::iterator nearest(Camera& camera, const Beat& oldest, std::int64_t reach_ns) const {
    auto best = camera.waiting.end();
    std::int64_t best_ns = reach_ns;
    const std::int64_t next_ns = beats_.size() > 1 ? beats_[1].stamp_ns : std::numeric_limits<std::int64_t>::max();
    for (auto at = camera.waiting.begin(); at != camera.waiting.end(); ++at) {
      const std::int64_t off_ns = std::abs(at->stamp_ns - oldest.stamp_ns);
      const bool others = beats_.size() > 1 && std::abs(at->stamp_ns - next_ns) < off_ns;
      if (off_ns <= best_ns && !others) {
        best = at;
        best_ns = off_ns;
      }
    }
    return best;
  }

  bool ready(const Beat& oldest, std::int64_t period_ns, std::int64_t now_ns) {
    const std::int64_t waited = now_ns - oldest.arrived_ns;
    if (waited > options_.timeout_ns || beats_.size() > options_.max_pending) {
      return true;
    }
    for (std::size_t index = 0; index < cameras_.size(); ++index) {
      Camera& camera = cameras_[index];
      const bool settled = camera.stamp_ns > oldest.stamp_ns;
      if (settled || nearest(camera, oldest, promptOf(period_ns)) != camera.waiting.end()) {
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
  std::deque<Beat> beats_;     ///< in the order of their stamps
  Beat released_;              ///< that of the last set that left
  std::int64_t heard_ns_ = 0;  ///< the last accepted cloud of any camera, wall time
  bool started_ = false;
};

}  // namespace yarm
