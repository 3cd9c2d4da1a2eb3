#include "euclidean.hpp"

#include "safe_cast.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

namespace yarm::perception {

namespace {
// Sites whose diagonal is just below the tolerance: points of one site are always connected, so that sites are the
// nodes.
constexpr float kEdgeFraction = 0.577F;
constexpr int kRim = 2;
constexpr int kReach = 2;
}  // namespace

EuclideanClusters::EuclideanClusters(const Eigen::Vector3f& min, const Eigen::Vector3f& max, float tolerance)
    : min_(min), inverse_edge_(1.F / (kEdgeFraction * tolerance)), tolerance2_(tolerance * tolerance) {
  const auto sites = [&](int axis) {
    return static_cast<int>(std::floor((max[axis] - min[axis]) * inverse_edge_)) + 1 + 2 * kRim;
  };
  nx_ = sites(0);
  ny_ = sites(1);
  nz_ = sites(2);
  table_.assign(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) * static_cast<std::size_t>(nz_), -1);
  taken_.assign(table_.size() / 64 + 2, 0);
  for (int dz = 0; dz <= kReach; ++dz) {
    for (int dy = -kReach; dy <= kReach; ++dy) {
      Row near{(dz * ny_ + dy) * nx_ - kReach, 0};
      Row far = near;
      for (int dx = -kReach; dx <= kReach; ++dx) {
        if (dz > 0 || dy > 0 || (dy == 0 && dx > 0)) {
          (std::max({std::abs(dx), std::abs(dy), dz}) == 1 ? near : far).sites |= 1U << (dx + kReach);
        }
      }
      for (auto* rows : {&near_, &far_}) {
        const Row& row = rows == &near_ ? near : far;
        if (row.sites != 0) {
          rows->push_back(row);
        }
      }
    }
  }
}

std::int32_t EuclideanClusters::find(std::int32_t node) {
  while (parent_[node] != node) {
    parent_[node] = parent_[parent_[node]];
    node = parent_[node];
  }
  return node;
}

void EuclideanClusters::bin(const std::vector<Eigen::Vector3f>& points) {
  const auto n = points.size();
  bin_of_.resize(n);
  next_.resize(n);
  site_.clear();
  first_.clear();
  const auto along = [&](float value, float low, int sites) {
    return intWithin((value - low) * inverse_edge_, 0, sites - 1 - 2 * kRim) + kRim;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const int x = along(points[i].x(), min_.x(), nx_);
    const int y = along(points[i].y(), min_.y(), ny_);
    const int z = along(points[i].z(), min_.z(), nz_);
    const std::int32_t site = (z * ny_ + y) * nx_ + x;
    std::int32_t& bin = table_[site];
    if (bin < 0) {
      bin = static_cast<std::int32_t>(site_.size());
      site_.push_back(site);
      taken_[static_cast<std::size_t>(site) / 64] |= std::uint64_t{1} << (site % 64);
      first_.push_back(-1);
    }
    bin_of_[i] = bin;
    next_[i] = first_[bin];
    first_[bin] = static_cast<std::int32_t>(i);
  }
}

bool EuclideanClusters::reaches(const std::vector<Eigen::Vector3f>& points, std::int32_t a, std::int32_t b) const {
  for (std::int32_t i = first_[a]; i >= 0; i = next_[i]) {
    for (std::int32_t j = first_[b]; j >= 0; j = next_[j]) {
      if ((points[i] - points[j]).squaredNorm() < tolerance2_) {
        return true;
      }
    }
  }
  return false;
}

std::uint32_t EuclideanClusters::taken(std::int32_t site, const Row& row) const {
  const auto first = static_cast<std::size_t>(site + row.offset);
  const std::size_t shift = first % 64;
  const std::uint64_t low = taken_[first / 64] >> shift;
  const std::uint64_t high = taken_[first / 64 + 1] << 1 << (63 - shift);
  return static_cast<std::uint32_t>(low | high) & row.sites;
}

void EuclideanClusters::joinAlong(const std::vector<Eigen::Vector3f>& points, const std::vector<Row>& rows) {
  const auto bins = static_cast<std::int32_t>(site_.size());
  for (std::int32_t b = 0; b < bins; ++b) {
    for (const Row& row : rows) {
      for (std::uint32_t sites = taken(site_[b], row); sites != 0; sites &= sites - 1) {
        const std::int32_t other = table_[site_[b] + row.offset + __builtin_ctz(sites)];
        if (root_[other] == root_[b]) {
          continue;
        }
        const std::int32_t root_a = find(b);
        const std::int32_t root_b = find(other);
        if (root_a != root_b && reaches(points, b, other)) {
          parent_[std::max(root_a, root_b)] = std::min(root_a, root_b);
        }
      }
    }
  }
  for (std::int32_t b = 0; b < bins; ++b) {
    root_[b] = find(b);
  }
}

Components EuclideanClusters::label(const std::vector<Eigen::Vector3f>& points) {
  bin(points);
  parent_.resize(site_.size());
  std::iota(parent_.begin(), parent_.end(), 0);
  root_ = parent_;
  joinAlong(points, near_);  // most of what is connected is so through direct neighbours
  joinAlong(points, far_);
  for (const std::int32_t site : site_) {
    table_[site] = -1;
    taken_[static_cast<std::size_t>(site) / 64] = 0;
  }
  labels_.resize(points.size());
  int count = 0;
  std::fill(first_.begin(), first_.end(), -1);  // from here on: label of a root
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::int32_t& name = first_[root_[bin_of_[i]]];
    name = name < 0 ? count++ : name;
    labels_[i] = name;
  }
  return {labels_, count};
}

}  // namespace yarm::perception
