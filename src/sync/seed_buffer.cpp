#include "yarm/sync/seed_buffer.hpp"

#include <algorithm>
#include <cstdio>
#include <iterator>

namespace yarm {

namespace {

using perception::Seed;

constexpr std::int64_t kKeepNs = 2'000'000'000;
constexpr std::int64_t kMostBehindNs = 5'000'000'000;  // the clock: messages may have waited in a queue

std::string faultText(std::int64_t stamp_ns, std::int64_t off_ns, const char* than, std::int64_t limit_ns) {
  char text[160];
  std::snprintf(text, sizeof(text), "its stamp %.3f s is %.3f s %s, at most %.1f s",
                1e-9 * static_cast<double>(stamp_ns), 1e-9 * static_cast<double>(off_ns), than,
                1e-9 * static_cast<double>(limit_ns));
  return text;
}

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

void SeedBuffer::noticeClock(std::int64_t now_ns) {
  if (now_ns == 0) {
    return;
  }
  if (clock_.wentBack(now_ns)) {
    ticks_.clear();
    if (early_ && stampFault(early_->stamp_ns, now_ns).empty()) {
      ticks_.push_back(std::move(*early_));
    }
    early_.reset();
  }
  while (!ticks_.empty() && ticks_.back().stamp_ns - now_ns > most_ahead_ns_) {
    ticks_.pop_back();  // came before the time was known
  }
}

std::string SeedBuffer::stampFault(std::int64_t stamp_ns, std::int64_t now_ns) const {
  if (now_ns > 0 && stamp_ns - now_ns > most_ahead_ns_) {
    return faultText(stamp_ns, stamp_ns - now_ns, "ahead of the clock", most_ahead_ns_);
  }
  if (now_ns > 0 && now_ns - stamp_ns > kMostBehindNs) {
    return faultText(stamp_ns, now_ns - stamp_ns, "behind the clock", kMostBehindNs);
  }
  if (!ticks_.empty() && ticks_.back().stamp_ns - stamp_ns > kJumpBackNs) {
    return faultText(stamp_ns, ticks_.back().stamp_ns - stamp_ns, "behind the newest seeds", kJumpBackNs);
  }
  return "";
}

std::string SeedBuffer::add(std::int64_t stamp_ns, std::vector<Seed> seeds, std::int64_t now_ns) {
  noticeClock(now_ns);
  std::string fault = stampFault(stamp_ns, now_ns);
  if (!fault.empty()) {
    early_ = Tick{stamp_ns, std::move(seeds)};
    return fault;
  }
  early_.reset();
  if (!ticks_.empty() && stamp_ns <= ticks_.back().stamp_ns) {
    return "";
  }
  ticks_.push_back({stamp_ns, std::move(seeds)});
  while (ticks_.front().stamp_ns + kKeepNs < stamp_ns) {
    ticks_.pop_front();
  }
  return "";
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
