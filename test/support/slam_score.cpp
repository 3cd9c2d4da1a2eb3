#include "slam_score.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace yarm::test {

namespace {

using Vec2 = Eigen::Vector2d;

constexpr double kPointStep = 0.02;  // m
constexpr int kFitRounds = 20;
constexpr double kFitGate = 0.3;  // m: cells farther off are left out of the fit

struct Spread {
  double rms{0}, p95{0}, most{0};
};

Spread spreadOf(std::vector<double> values) {
  if (values.empty()) {
    return {};
  }
  std::sort(values.begin(), values.end());
  double squares = 0.0;
  for (const double value : values) {
    squares += value * value;
  }
  const auto count = static_cast<double>(values.size());
  return {std::sqrt(squares / count), values[static_cast<std::size_t>(0.95 * (count - 1))], values.back()};
}

std::vector<Vec2> occupiedCells(const slam::GridMap& map) {
  std::vector<Vec2> cells;
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      if (map.cells[static_cast<std::size_t>(row) * map.width + column] > 50) {
        cells.push_back(map.centre(column, row));
      }
    }
  }
  return cells;
}

const Segment& nearestSurface(const Arena& arena, const Vec2& point) {
  const auto& surfaces = arena.surfaces();
  return *std::min_element(surfaces.begin(), surfaces.end(), [&](const Segment& a, const Segment& b) {
    return a.distanceTo(point) < b.distanceTo(point);
  });
}

// Point-to-line fit of the cells to the surfaces.
slam::Pose2 fitted(const std::vector<Vec2>& cells, const Arena& arena, slam::Pose2 pose) {
  for (int round = 0; round < kFitRounds; ++round) {
    Eigen::Matrix3d hessian = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (const Vec2& cell : cells) {
      const Vec2 at = pose * cell;
      const Segment& surface = nearestSurface(arena, at);
      const Vec2 along = (surface.b - surface.a).normalized();
      const Vec2 normal{-along.y(), along.x()};
      const double distance = normal.dot(at - surface.a);
      if (surface.distanceTo(at) > kFitGate) {
        continue;
      }
      const Vec2 arm{-(at.y() - pose.y), at.x() - pose.x};
      const Eigen::Vector3d jacobian{normal.x(), normal.y(), normal.dot(arm)};
      hessian += jacobian * jacobian.transpose();
      gradient += distance * jacobian;
    }
    const Eigen::Vector3d step = hessian.ldlt().solve(-gradient);
    pose = {pose.x + step.x(), pose.y + step.y(), slam::wrapAngle(pose.yaw + step.z())};
  }
  return pose;
}

double shareNear(const std::vector<Vec2>& points, const std::vector<Vec2>& cells, double reach) {
  const auto near = std::count_if(points.begin(), points.end(), [&](const Vec2& point) {
    return std::any_of(cells.begin(), cells.end(),
                       [&](const Vec2& cell) { return (cell - point).squaredNorm() <= reach * reach; });
  });
  return points.empty() ? 0.0 : static_cast<double>(near) / static_cast<double>(points.size());
}

}  // namespace

SeenSurfaces::SeenSurfaces(const Arena& arena) : arena_(arena) {
  for (const Segment& surface : arena.surfaces()) {
    first_of_surface_.push_back(static_cast<int>(points_.size()));
    const int steps = std::max(1, static_cast<int>((surface.b - surface.a).norm() / kPointStep));
    for (int i = 0; i < steps; ++i) {
      points_.push_back(surface.a + (surface.b - surface.a) * ((i + 0.5) / steps));
    }
  }
  first_of_surface_.push_back(static_cast<int>(points_.size()));
  scans_.assign(points_.size(), 0);
  last_.assign(points_.size(), 0);
}

void SeenSurfaces::add(const Moment& moment, double most_range) {
  const slam::Pose2 sensor = moment.T_arena_base * moment.scan.T_base_sensor;
  ++moments_;
  for (std::size_t beam = 0; beam < moment.exact.size(); ++beam) {
    const double range = moment.exact[beam];
    if (range < moment.scan.range_min || range > most_range) {
      continue;
    }
    const double bearing = sensor.yaw + moment.scan.angle_min + static_cast<double>(beam) * moment.scan.angle_increment;
    const int hit = moment.surface[beam];
    const Segment& surface = arena_.surfaces()[hit];
    const Vec2 end{sensor.x + range * std::cos(bearing), sensor.y + range * std::sin(bearing)};
    const double share = (end - surface.a).norm() / (surface.b - surface.a).norm();
    const int first = first_of_surface_[hit];
    const int count = first_of_surface_[hit + 1] - first;
    const int point = first + std::clamp(static_cast<int>(share * count), 0, count - 1);
    scans_[point] += last_[point] == moments_ ? 0 : 1;
    last_[point] = moments_;
  }
}

std::vector<Vec2> SeenSurfaces::seen(int scans) const {
  std::vector<Vec2> result;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (scans_[i] >= scans) {
      result.push_back(points_[i]);
    }
  }
  return result;
}

MapScore scoreMap(const slam::GridMap& map, const Arena& arena, const std::vector<Vec2>& seen,
                  const slam::Pose2& T_arena_map, bool fit) {
  std::vector<Vec2> cells = occupiedCells(map);
  MapScore score;
  score.occupied = static_cast<int>(cells.size());
  score.T_arena_map = fit ? fitted(cells, arena, T_arena_map) : T_arena_map;
  std::vector<double> distances;
  for (Vec2& cell : cells) {
    cell = score.T_arena_map * cell;
    distances.push_back(arena.clearance(cell));
    score.mean += distances.back();
    score.spurious += distances.back() > 0.10 ? 1.0 : 0.0;
  }
  if (cells.empty()) {
    return score;
  }
  const auto count = static_cast<double>(cells.size());
  score.mean /= count;
  score.spurious /= count;
  const Spread spread = spreadOf(std::move(distances));
  score.most = spread.most;
  score.p95 = spread.p95;
  score.within_5cm = shareNear(seen, cells, 0.05);
  score.within_10cm = shareNear(seen, cells, 0.10);
  return score;
}

void PoseErrors::add(const slam::Pose2& estimate, const slam::Pose2& truth) {
  off_.push_back(estimate.distanceTo(truth));
  turned_.push_back(std::abs(slam::wrapAngle(estimate.yaw - truth.yaw)));
}

PoseScore PoseErrors::score() const {
  const Spread off = spreadOf(off_);
  const Spread turned = spreadOf(turned_);
  return {off.rms, off.p95, off.most, turned.rms, turned.p95, turned.most};
}

}  // namespace yarm::test
