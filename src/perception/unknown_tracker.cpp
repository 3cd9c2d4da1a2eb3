#include "unknown_tracker.hpp"

#include <algorithm>
#include <limits>

namespace yarm::perception {

namespace {

constexpr std::size_t kSamples = 64;  // points of a thing that are asked about, about

float squaredGap(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b) {
  float best = std::numeric_limits<float>::infinity();
  for (const Eigen::Vector3f& p : a) {
    for (const Eigen::Vector3f& q : b) {
      best = std::min(best, (p - q).squaredNorm());
    }
  }
  return best;
}

Eigen::AlignedBox3f boxAround(const std::vector<Eigen::Vector3f>& points) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : points) {
    box.extend(p);
  }
  return box;
}

bool contains(const std::vector<std::int32_t>& cameras, std::int32_t camera) {
  return std::find(cameras.begin(), cameras.end(), camera) != cameras.end();
}

/// What a group of points shows.
void append(UnknownThing& thing, const std::vector<MergedPoint>& points, const std::vector<std::uint32_t>& group) {
  for (const std::uint32_t i : group) {
    const Eigen::Vector3f p(points[i].x, points[i].y, points[i].z);
    thing.source.push_back(i);
    thing.points.push_back(p);
    thing.views[points[i].camera].push_back(p);
    thing.box.extend(p);
  }
}

void appendView(UnknownThing& thing, std::int32_t camera, const std::vector<Eigen::Vector3f>& view) {
  thing.points.insert(thing.points.end(), view.begin(), view.end());
  thing.box.extend(boxAround(view));
  thing.views[camera] = view;
}

}  // namespace

bool UnknownTracker::isBelieved(const UnknownThing& thing) const {
  const std::uint32_t window = (1U << static_cast<unsigned>(params_.unknown_window)) - 1U;
  return __builtin_popcount(thing.history & window) >= params_.unknown_hits;
}

int UnknownTracker::match(const std::vector<Eigen::Vector3f>& group) const {
  const auto radius = static_cast<float>(params_.search_radius);
  const Eigen::AlignedBox3f box = boxAround(group);
  int best = -1;
  float best_gap = radius * radius;
  for (std::size_t i = 0; i < things_.size(); ++i) {
    if (things_[i].box.squaredExteriorDistance(box) >= best_gap) {
      continue;
    }
    const float gap = squaredGap(group, things_[i].points);
    if (gap < best_gap) {
      best_gap = gap;
      best = static_cast<int>(i);
    }
  }
  return best;
}

void UnknownTracker::show(UnknownThing& thing, UnknownThing now, const std::vector<std::int32_t>& absent) const {
  const auto radius = static_cast<float>(params_.search_radius);
  now.number = thing.number;
  now.history = (thing.history << 1U) | 1U;
  const std::vector<Eigen::Vector3f> seen = now.points;
  for (const auto& [camera, view] : thing.views) {
    if (contains(absent, camera) && now.views.count(camera) == 0 && squaredGap(view, seen) < radius * radius) {
      appendView(now, camera, view);
    }
  }
  thing = std::move(now);
}

void UnknownTracker::miss(UnknownThing& thing, const std::vector<std::int32_t>& absent) const {
  thing.source.clear();
  UnknownThing kept;
  for (const auto& [camera, view] : thing.views) {
    if (contains(absent, camera)) {
      appendView(kept, camera, view);
    }
  }
  if (isBelieved(thing) && 2 * kept.points.size() > thing.points.size()) {
    thing.points = std::move(kept.points);
    thing.views = std::move(kept.views);
    thing.box = kept.box;
    return;
  }
  thing.history <<= 1U;
}

void UnknownTracker::update(const std::vector<MergedPoint>& points,
                            const std::vector<std::vector<std::uint32_t>>& groups,
                            const std::vector<std::int32_t>& absent) {
  std::vector<UnknownThing> shown(things_.size());
  std::vector<UnknownThing> fresh;
  for (const auto& group : groups) {
    UnknownThing now;
    append(now, points, group);
    const int known = match(now.points);
    if (known >= 0) {
      append(shown[static_cast<std::size_t>(known)], points, group);
    } else {
      now.history = 1U;
      fresh.push_back(std::move(now));
    }
  }
  for (std::size_t i = 0; i < things_.size(); ++i) {
    if (shown[i].points.empty()) {
      miss(things_[i], absent);
    } else {
      show(things_[i], std::move(shown[i]), absent);
    }
  }
  things_.insert(things_.end(), fresh.begin(), fresh.end());
  const std::uint32_t window = (1U << static_cast<unsigned>(params_.unknown_window)) - 1U;
  things_.erase(std::remove_if(things_.begin(), things_.end(),
                               [&](const UnknownThing& thing) { return (thing.history & window) == 0; }),
                things_.end());
}

void UnknownTracker::name(ObjectTracks& tracks) {
  for (UnknownThing& thing : things_) {
    if (thing.number != 0 || !isBelieved(thing)) {
      continue;
    }
    const int number = tracks.numberOf(thing.source);
    const bool taken = std::any_of(things_.begin(), things_.end(),
                                   [number](const UnknownThing& other) { return other.number == number; });
    thing.number = number == 0 || taken ? tracks.newNumber() : number;
  }
}

void UnknownTracker::dissolve(const std::function<bool(const Eigen::Vector3f&)>& explained) {
  const auto is_explained = [&](const UnknownThing& thing) {
    const std::size_t step = 1 + thing.points.size() / kSamples;
    std::size_t asked = 0;
    std::size_t yes = 0;
    for (std::size_t i = 0; i < thing.points.size(); i += step) {
      ++asked;
      yes += explained(thing.points[i]) ? 1U : 0U;
    }
    return 2 * yes > asked;
  };
  things_.erase(std::remove_if(things_.begin(), things_.end(), is_explained), things_.end());
}

std::vector<const UnknownThing*> UnknownTracker::believed() const {
  std::vector<const UnknownThing*> result;
  for (const UnknownThing& thing : things_) {
    if (isBelieved(thing)) {
      result.push_back(&thing);
    }
  }
  return result;
}

bool UnknownTracker::covers(const Eigen::Vector3f& point, float reach) const {
  for (const UnknownThing& thing : things_) {
    if (!isBelieved(thing) || thing.box.squaredExteriorDistance(point) > reach * reach) {
      continue;
    }
    for (const Eigen::Vector3f& p : thing.points) {
      if ((p - point).squaredNorm() <= reach * reach) {
        return true;
      }
    }
  }
  return false;
}

void UnknownTracker::reset() {
  things_.clear();
}

}  // namespace yarm::perception
