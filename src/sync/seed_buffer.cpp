#include "yarm/ros/seed_buffer.hpp"

#include "yarm/ros/clock.hpp"

#include <algorithm>
#include <iterator>

namespace yarm {

namespace {

using perception::Seed;

// The seed at a time between two measurements; outside them, the nearer one.
Seed between(const Seed& before, const Seed& after, std::int64_t stamp_ns) {
  if (stamp_ns >= after.stamp_ns || before.stamp_ns >= after.stamp_ns) {
    return after;
  }
  const auto span = static_cast<double>(after.stamp_ns - before.stamp_ns);
  const double share = std::clamp(static_cast<double>(stamp_ns - before.stamp_ns) / span, 0.0, 1.0);
  Seed seed = after;
  const Eigen::Vector3d from = before.T_world_seed.translation();
  const Eigen::Vector3d to = after.T_world_seed.translation();
  const Eigen::Quaterniond turn_from(before.T_world_seed.linear());
  const Eigen::Quaterniond turn_to(after.T_world_seed.linear());
  seed.T_world_seed.translation() = from + share * (to - from);
  seed.T_world_seed.linear() = turn_from.slerp(share, turn_to).toRotationMatrix();
  seed.stamp_ns = stamp_ns;
  return seed;
}

}  // namespace

void SeedBuffer::add(std::int64_t stamp_ns, std::vector<Seed> seeds) {
  if (!ticks_.empty() && stamp_ns + kJumpBackNs < ticks_.back().stamp_ns) {
    ticks_.clear();
  }
  if (!ticks_.empty() && stamp_ns <= ticks_.back().stamp_ns) {
    return;
  }
  ticks_.push_back({stamp_ns, std::move(seeds)});
  while (ticks_.front().stamp_ns + keep_ns_ < stamp_ns) {
    ticks_.pop_front();
  }
}

SeedLookup SeedBuffer::lookup(std::int64_t stamp_ns) const {
  SeedLookup found;
  if (ticks_.empty()) {
    return found;
  }
  const auto at = std::find_if(ticks_.rbegin(), ticks_.rend(), [&](const Tick& t) { return t.stamp_ns <= stamp_ns; });
  // `at` is the last message at or before the stamp; the one that follows it brackets the stamp.
  if (at == ticks_.rbegin() && at->stamp_ns < stamp_ns) {
    found.match = SeedMatch::newest;
    found.seeds = at->seeds;
    found.lag_ns = stamp_ns - at->stamp_ns;
    return found;
  }
  found.match = SeedMatch::exact;
  if (at == ticks_.rend() || at->stamp_ns == stamp_ns) {
    found.seeds = at == ticks_.rend() ? ticks_.front().seeds : at->seeds;
    return found;
  }
  const Tick& before = *at;
  const Tick& next = *std::prev(at);
  for (const Seed& seed : next.seeds) {
    const auto same = std::find_if(before.seeds.begin(), before.seeds.end(),
                                   [&](const Seed& other) { return other.name == seed.name; });
    found.seeds.push_back(same == before.seeds.end() ? seed : between(*same, seed, stamp_ns));
  }
  return found;
}

}  // namespace yarm
