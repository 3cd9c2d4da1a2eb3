#include "yarm/slam/map_drawer.hpp"

#include "yarm/slam/scan_points.hpp"

#include <algorithm>

namespace yarm::slam {

namespace {

constexpr double kUnit = 256.0;         // a weight of one, as a whole number
constexpr int kGrowCells = 20;          // the grid grows by at least so many
constexpr std::size_t kMissStride = 4;  // beams lie much closer than cells: every fourth clears
constexpr std::size_t kMostCells = 16'000'000;

int cellOf(double coordinate, double resolution) {
  return static_cast<int>(std::floor(coordinate / resolution));
}

}  // namespace

MapScan toMapScan(const Scan& scan, const ScanParams& params, int keyframe, const Pose2& T_keyframe_sensor) {
  MapScan result{keyframe, T_keyframe_sensor, scan.angle_min, scan.angle_increment, {}};
  result.ranges_mm.resize(scan.ranges.size());
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const auto range = usableRange(scan, beam, params);
    result.ranges_mm[beam] = range ? static_cast<std::uint16_t>(std::clamp(*range * 1e3, 1.0, 65535.0)) : 0;
  }
  return result;
}

void MapDrawer::grow(int left, int below, int right, int above) {
  const int width = left + width_ + right;
  const int height = below + height_ + above;
  if (static_cast<std::size_t>(width) * static_cast<std::size_t>(height) > kMostCells) {
    return;  // what lies outside is not drawn
  }
  std::vector<Marks> cells(static_cast<std::size_t>(width) * height);
  for (int row = 0; row < height_; ++row) {
    std::copy_n(cells_.begin() + static_cast<std::ptrdiff_t>(row) * width_, width_,
                cells.begin() + static_cast<std::ptrdiff_t>(row + below) * width + left);
  }
  cells_ = std::move(cells);
  first_x_ -= left;
  first_y_ -= below;
  width_ = width;
  height_ = height;
}

void MapDrawer::include(double x, double y, double reach) {
  if (width_ == 0) {
    first_x_ = cellOf(x, map_.resolution);
    first_y_ = cellOf(y, map_.resolution);
  }
  const auto missing = [](int cells) { return cells > 0 ? cells + kGrowCells : 0; };
  const int left = missing(first_x_ - cellOf(x - reach, map_.resolution));
  const int below = missing(first_y_ - cellOf(y - reach, map_.resolution));
  const int right = missing(cellOf(x + reach, map_.resolution) - (first_x_ + width_ - 1));
  const int above = missing(cellOf(y + reach, map_.resolution) - (first_y_ + height_ - 1));
  if (left + below + right + above > 0) {
    grow(left, below, right, above);
  }
}

void MapDrawer::markHits(const MapScan& scan, const Pose2& T_map_sensor, int sign) {
  for (std::size_t beam = 0; beam < scan.ranges_mm.size(); ++beam) {
    const double range = 1e-3 * scan.ranges_mm[beam];
    if (scan.ranges_mm[beam] == 0 || range > map_.max_range) {
      continue;
    }
    const double bearing = T_map_sensor.yaw + scan.angle_min + static_cast<double>(beam) * scan.angle_increment;
    const int column = cellOf(T_map_sensor.x + range * std::cos(bearing), map_.resolution) - first_x_;
    const int row = cellOf(T_map_sensor.y + range * std::sin(bearing), map_.resolution) - first_y_;
    if (column < 0 || row < 0 || column >= width_ || row >= height_) {
      continue;
    }
    Marks& cell = cells_[static_cast<std::size_t>(row) * width_ + column];
    if (cell.stamp != pass_) {
      const double sigmas = rangeSigma(scan_, range) / map_.range_weight;
      cell.stamp = pass_;
      cell.hits += sign * static_cast<int>(std::lround(kUnit / (1.0 + sigmas * sigmas)));
    }
  }
}

// Walks the cells of a ray: J. Amanatides and A. Woo, "A fast voxel traversal algorithm for ray tracing", 1987.
void MapDrawer::clear(const Pose2& from, double bearing, double range, int weight) {
  const double dx = std::cos(bearing);
  const double dy = std::sin(bearing);
  const double edge = map_.resolution;
  int column = cellOf(from.x, edge) - first_x_;
  int row = cellOf(from.y, edge) - first_y_;
  const int step_x = dx > 0.0 ? 1 : -1;
  const int step_y = dy > 0.0 ? 1 : -1;
  const double per_x = std::abs(edge / dx);
  const double per_y = std::abs(edge / dy);
  double next_x = ((column + first_x_ + (step_x > 0 ? 1 : 0)) * edge - from.x) / dx;
  double next_y = ((row + first_y_ + (step_y > 0 ? 1 : 0)) * edge - from.y) / dy;
  while (column >= 0 && row >= 0 && column < width_ && row < height_) {
    Marks& cell = cells_[static_cast<std::size_t>(row) * width_ + column];
    if (cell.stamp != pass_) {
      cell.stamp = pass_;
      cell.misses += weight;
    }
    if (std::min(next_x, next_y) > range) {
      return;
    }
    if (next_x < next_y) {
      column += step_x;
      next_x += per_x;
    } else {
      row += step_y;
      next_y += per_y;
    }
  }
}

void MapDrawer::mark(const MapScan& scan, const Pose2& T_map_sensor, int sign) {
  include(T_map_sensor.x, T_map_sensor.y, map_.max_range + map_.resolution);
  ++pass_;
  markHits(scan, T_map_sensor, sign);
  for (std::size_t beam = 0; beam < scan.ranges_mm.size(); beam += kMissStride) {
    if (scan.ranges_mm[beam] == 0) {
      continue;
    }
    const double range = std::min(1e-3 * scan.ranges_mm[beam], map_.max_range);
    const double sigmas = rangeSigma(scan_, range) / map_.range_weight;
    const int weight = static_cast<int>(std::lround(kUnit / (1.0 + sigmas * sigmas)));
    const double bearing = T_map_sensor.yaw + scan.angle_min + static_cast<double>(beam) * scan.angle_increment;
    clear(T_map_sensor, bearing, range, sign * weight);
  }
}

GridMap MapDrawer::draw(const std::vector<std::shared_ptr<const MapScan>>& scans, const std::vector<Pose2>& keyframes,
                        const std::vector<std::shared_ptr<const MapScan>>& unproved) {
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const MapScan& scan = *scans[i];
    const Pose2 pose = keyframes[scan.keyframe] * scan.T_keyframe_sensor;
    if (i >= drawn_.size()) {
      drawn_.push_back(pose);
      mark(scan, pose, 1);
    } else if (pose.distanceTo(drawn_[i]) > map_.move_m ||
               std::abs(wrapAngle(pose.yaw - drawn_[i].yaw)) > map_.move_rad) {
      mark(scan, drawn_[i], -1);
      mark(scan, pose, 1);
      drawn_[i] = pose;
    }
  }
  for (const auto& scan : unproved) {
    mark(*scan, keyframes[scan->keyframe] * scan->T_keyframe_sensor, 1);
  }
  GridMap map = toMap();
  for (const auto& scan : unproved) {
    mark(*scan, keyframes[scan->keyframe] * scan->T_keyframe_sensor, -1);
  }
  return map;
}

std::int32_t MapDrawer::mostHitsAround(int cell) const {
  const int column = cell % width_;
  const int row = cell / width_;
  std::int32_t most = 0;
  for (int y = std::max(0, row - 1); y <= std::min(height_ - 1, row + 1); ++y) {
    for (int x = std::max(0, column - 1); x <= std::min(width_ - 1, column + 1); ++x) {
      most = std::max(most, cells_[static_cast<std::size_t>(y) * width_ + x].hits);
    }
  }
  return most;
}

std::int8_t MapDrawer::valueOf(int cell) const {
  const double hits = cells_[cell].hits / kUnit;
  const double misses = cells_[cell].misses / kUnit;
  if (hits + misses <= 0.0) {
    return -1;
  }
  const bool is_wall = hits > map_.occupied_hits && hits > map_.occupied_share * (hits + misses) &&
                       cells_[cell].hits >= map_.blur_share * mostHitsAround(cell);
  if (is_wall) {
    return 100;
  }
  return misses > hits ? 0 : -1;  // ranges that read too long end behind a wall, where nobody has looked
}

GridMap MapDrawer::toMap() const {
  const double edge = map_.resolution;
  const int margin = static_cast<int>(std::lround(map_.margin / edge));
  int left = cellOf(map_.x_min, edge);
  int below = cellOf(map_.y_min, edge);
  int right = static_cast<int>(std::ceil(map_.x_max / edge)) - 1;
  int above = static_cast<int>(std::ceil(map_.y_max / edge)) - 1;
  std::vector<std::int8_t> values(cells_.size());
  for (int i = 0; i < width_ * height_; ++i) {
    values[i] = valueOf(i);
    if (values[i] >= 0) {
      left = std::min(left, i % width_ + first_x_ - margin);
      right = std::max(right, i % width_ + first_x_ + margin);
      below = std::min(below, i / width_ + first_y_ - margin);
      above = std::max(above, i / width_ + first_y_ + margin);
    }
  }
  GridMap map{std::max(0, right - left + 1), std::max(0, above - below + 1), edge, left * edge, below * edge, {}};
  map.cells.assign(static_cast<std::size_t>(map.width) * map.height, -1);
  for (int i = 0; i < width_ * height_; ++i) {
    if (values[i] >= 0) {
      const int column = i % width_ + first_x_ - left;
      const int row = i / width_ + first_y_ - below;
      map.cells[static_cast<std::size_t>(row) * map.width + column] = values[i];
    }
  }
  return map;
}

}  // namespace yarm::slam
