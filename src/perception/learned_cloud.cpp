#include "learned_cloud.hpp"

#include "safe_cast.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace yarm::perception {

namespace {
constexpr std::int64_t kLeastRate = 5;    // a cell must be hit in one set of so many since it was first hit
constexpr int kFarthest = (1 << 20) - 2;  // cells from the origin; the neighbours' keys must fit, too
}  // namespace

bool LearnedCloud::counts(const Entry& entry) const {
  const bool often = least_hits_ == 1 || kLeastRate * entry.hits > newest_set_ - entry.first_set;
  return entry.hits >= least_hits_ && often;
}

std::int64_t LearnedCloud::keyOf(int x, int y, int z) const {
  constexpr std::int64_t kBias = 1 << 20;
  return ((x + kBias) << 42) | ((y + kBias) << 21) | (z + kBias);
}

Eigen::Vector3i LearnedCloud::cellOf(const Eigen::Vector3f& point) const {
  const auto along = [&](int axis) { return intWithin(std::floor(point[axis] / spacing_), -kFarthest, kFarthest); };
  return {along(0), along(1), along(2)};
}

void LearnedCloud::add(const Eigen::Vector3f& point, std::int64_t set) {
  const Eigen::Vector3i c = cellOf(point);
  Entry& entry = cells_[keyOf(c.x(), c.y(), c.z())];
  entry.first_set = entry.points == 0 ? set : entry.first_set;
  newest_set_ = set;
  entry.sum += point;
  ++entry.points;
  if (entry.last_set != set) {
    entry.last_set = set;
    ++entry.hits;
    counted_ += entry.hits == least_hits_ ? 1 : 0;
  }
  low_ = low_.min(point.array());
  high_ = high_.max(point.array());
}

float LearnedCloud::distance(const Eigen::Vector3f& point) const {
  float best = std::numeric_limits<float>::infinity();
  if (counted_ == 0 || (point.array() < low_ - 2.F * spacing_).any() ||
      (point.array() > high_ + 2.F * spacing_).any()) {
    return best;
  }
  const Eigen::Vector3i c = cellOf(point);
  for (int x = c.x() - 1; x <= c.x() + 1; ++x) {
    for (int y = c.y() - 1; y <= c.y() + 1; ++y) {
      for (int z = c.z() - 1; z <= c.z() + 1; ++z) {
        const auto found = cells_.find(keyOf(x, y, z));
        if (found != cells_.end() && counts(found->second)) {
          best = std::min(best, (found->second.sum / static_cast<float>(found->second.points) - point).norm());
        }
      }
    }
  }
  return best;
}

std::vector<Eigen::Vector3f> LearnedCloud::points() const {
  std::vector<std::pair<std::int64_t, Eigen::Vector3f>> keyed;
  for (const auto& [key, entry] : cells_) {
    if (counts(entry)) {
      keyed.emplace_back(key, entry.sum / static_cast<float>(entry.points));
    }
  }
  std::sort(keyed.begin(), keyed.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Eigen::Vector3f> result;
  for (const auto& [key, point] : keyed) {
    result.push_back(point);
  }
  return result;
}

}  // namespace yarm::perception
