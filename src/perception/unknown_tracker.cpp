#include "unknown_tracker.hpp"

#include <algorithm>
#include <limits>

namespace yarm::perception {

namespace {

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

}  // namespace

bool UnknownTracker::isBelieved(const UnknownThing& thing) const {
  const std::uint32_t window = (1U << static_cast<unsigned>(params_.unknown_window)) - 1U;
  return __builtin_popcount(thing.history & window) >= params_.unknown_hits;
}

UnknownThing* UnknownTracker::match(const std::vector<Eigen::Vector3f>& group) {
  const auto radius = static_cast<float>(params_.search_radius);
  const Eigen::AlignedBox3f box = boxAround(group);
  UnknownThing* best = nullptr;
  float best_gap = radius * radius;
  for (UnknownThing& thing : things_) {
    if (thing.box.squaredExteriorDistance(box) >= best_gap) {
      continue;
    }
    const float gap = squaredGap(group, thing.points);
    if (gap < best_gap) {
      best_gap = gap;
      best = &thing;
    }
  }
  return best;
}

void UnknownTracker::update(const std::vector<MergedPoint>& points,
                            const std::vector<std::vector<std::uint32_t>>& groups) {
  for (UnknownThing& thing : things_) {
    thing.history <<= 1U;
    thing.source.clear();
  }
  std::vector<UnknownThing*> matches;
  std::vector<std::vector<Eigen::Vector3f>> clouds;
  for (const auto& group : groups) {
    std::vector<Eigen::Vector3f> cloud;
    for (const std::uint32_t i : group) {
      cloud.emplace_back(points[i].x, points[i].y, points[i].z);
    }
    matches.push_back(match(cloud));
    clouds.push_back(std::move(cloud));
  }
  std::vector<UnknownThing> fresh;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (matches[g] == nullptr) {
      fresh.push_back({0, 1U, groups[g], clouds[g], boxAround(clouds[g])});
      continue;
    }
    UnknownThing& thing = *matches[g];
    if (thing.source.empty()) {
      thing.points.clear();
      thing.box.setEmpty();
    }
    thing.history |= 1U;
    thing.source.insert(thing.source.end(), groups[g].begin(), groups[g].end());
    thing.points.insert(thing.points.end(), clouds[g].begin(), clouds[g].end());
    thing.box.extend(boxAround(clouds[g]));
  }
  things_.insert(things_.end(), fresh.begin(), fresh.end());
  const std::uint32_t window = (1U << static_cast<unsigned>(params_.unknown_window)) - 1U;
  things_.erase(std::remove_if(things_.begin(), things_.end(),
                               [&](const UnknownThing& thing) { return (thing.history & window) == 0; }),
                things_.end());
  for (UnknownThing& thing : things_) {
    if (thing.number == 0 && isBelieved(thing)) {
      thing.number = next_number_++;
    }
  }
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
