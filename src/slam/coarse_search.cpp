#include "yarm/slam/coarse_search.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace yarm::slam {

namespace {

constexpr std::size_t kPoints = 60;  // as many of the scan's points are tried
constexpr int kSpread = 3;           // cells that a point's likelihood reaches
constexpr double kSigmaCells = 1.2;  // and its standard deviation, cells

// How likely a point of a wall lies in each cell, after the targets' points.
class Raster {
 public:
  Raster(const std::vector<MatchTarget>& targets, double edge) : edge_(edge) {
    std::vector<Eigen::Vector2d> points;
    for (const MatchTarget& target : targets) {
      for (const SurfacePoint& point : target.points->points()) {
        points.push_back(target.T_map_sensor * Eigen::Vector2d{point.x, point.y});
      }
    }
    if (points.empty()) {
      return;
    }
    Eigen::Vector2d low = points.front();
    Eigen::Vector2d high = low;
    for (const Eigen::Vector2d& point : points) {
      low = low.cwiseMin(point);
      high = high.cwiseMax(point);
    }
    origin_ = low - Eigen::Vector2d::Constant((kSpread + 1) * edge);
    width_ = static_cast<int>((high.x() - origin_.x()) / edge) + kSpread + 2;
    height_ = static_cast<int>((high.y() - origin_.y()) / edge) + kSpread + 2;
    cells_.assign(static_cast<std::size_t>(width_) * height_, 0.0F);
    for (const Eigen::Vector2d& point : points) {
      stamp(point);
    }
  }

  [[nodiscard]] float at(double x, double y) const {
    const int column = static_cast<int>(std::floor((x - origin_.x()) / edge_));
    const int row = static_cast<int>(std::floor((y - origin_.y()) / edge_));
    const bool inside = column >= 0 && row >= 0 && column < width_ && row < height_;
    return inside ? cells_[static_cast<std::size_t>(row) * width_ + column] : 0.0F;
  }

 private:
  void stamp(const Eigen::Vector2d& point) {
    const int column = static_cast<int>((point.x() - origin_.x()) / edge_);
    const int row = static_cast<int>((point.y() - origin_.y()) / edge_);
    for (int dy = -kSpread; dy <= kSpread; ++dy) {
      for (int dx = -kSpread; dx <= kSpread; ++dx) {
        float& cell = cells_[static_cast<std::size_t>(row + dy) * width_ + column + dx];
        const double squared = (dx * dx + dy * dy) / (kSigmaCells * kSigmaCells);
        cell = std::max(cell, static_cast<float>(std::exp(-0.5 * squared)));
      }
    }
  }

  double edge_;
  Eigen::Vector2d origin_{Eigen::Vector2d::Zero()};
  int width_{0};
  int height_{0};
  std::vector<float> cells_;
};

std::vector<Eigen::Vector2d> sample(const ScanPoints& scan) {
  std::vector<Eigen::Vector2d> points;
  const std::size_t count = scan.points().size();
  const std::size_t stride = std::max<std::size_t>(1, count / kPoints);
  for (std::size_t i = 0; i < count; i += stride) {
    points.emplace_back(scan.points()[i].x, scan.points()[i].y);
  }
  return points;
}

}  // namespace

SearchResult searchCoarsely(const ScanPoints& scan, const Pose2& start, const std::vector<MatchTarget>& targets,
                            const KeyframeParams& params) {
  SearchResult best{false, start, 0.0};
  const Raster raster(targets, params.search_step);
  const std::vector<Eigen::Vector2d> points = sample(scan);
  if (points.empty()) {
    return best;
  }
  const int turns = static_cast<int>(params.search_angle / params.search_angle_step);
  const int steps = static_cast<int>(params.search_distance / params.search_step);
  std::vector<Eigen::Vector2d> turned(points.size());
  for (int turn = -turns; turn <= turns; ++turn) {
    const Pose2 rotated{start.x, start.y, wrapAngle(start.yaw + turn * params.search_angle_step)};
    std::transform(points.begin(), points.end(), turned.begin(), [&](const auto& point) { return rotated * point; });
    for (int iy = -steps; iy <= steps; ++iy) {
      for (int ix = -steps; ix <= steps; ++ix) {
        const double dx = ix * params.search_step;
        const double dy = iy * params.search_step;
        double sum = 0.0;
        for (const Eigen::Vector2d& point : turned) {
          sum += raster.at(point.x() + dx, point.y() + dy);
        }
        const double score = sum / static_cast<double>(points.size());
        if (score > best.score) {
          best = {false, {rotated.x + dx, rotated.y + dy, rotated.yaw}, score};
        }
      }
    }
  }
  best.found = best.score >= params.search_score;
  return best;
}

}  // namespace yarm::slam
