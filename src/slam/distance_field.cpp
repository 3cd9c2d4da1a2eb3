#include "yarm/slam/distance_field.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace yarm::slam {

namespace {

constexpr float kFar = 1e12F;  // squared cells: no surface

// Lower envelope of the parabolas that stand on a line's values; gives the squared distances along it.
class LineTransform {
 public:
  explicit LineTransform(int longest) : places_(longest), bounds_(longest + 1), values_(longest) {}

  // Reads and writes `count` values that lie `stride` apart.
  void operator()(float* line, int count, int stride) {
    for (int i = 0; i < count; ++i) {
      values_[i] = line[static_cast<std::size_t>(i) * stride];
    }
    int last = -1;
    for (int i = 0; i < count; ++i) {
      if (values_[i] >= kFar) {
        continue;
      }
      float crossing = -std::numeric_limits<float>::infinity();
      while (last >= 0 && (crossing = crossingOf(places_[last], i)) <= bounds_[last]) {
        --last;
      }
      ++last;
      places_[last] = i;
      bounds_[last] = last == 0 ? -std::numeric_limits<float>::infinity() : crossing;
    }
    if (last < 0) {
      return;
    }
    int k = 0;
    for (int i = 0; i < count; ++i) {
      while (k < last && bounds_[k + 1] < static_cast<float>(i)) {
        ++k;
      }
      const auto away = static_cast<float>(i - places_[k]);
      line[static_cast<std::size_t>(i) * stride] = away * away + values_[places_[k]];
    }
  }

 private:
  [[nodiscard]] float crossingOf(int a, int b) const {
    const auto da = static_cast<double>(a);
    const auto db = static_cast<double>(b);
    return static_cast<float>(((values_[b] + db * db) - (values_[a] + da * da)) / (2.0 * (db - da)));
  }

  std::vector<int> places_;
  std::vector<float> bounds_;
  std::vector<float> values_;
};

}  // namespace

DistanceField::DistanceField(const GridMap& map, const FieldParams& params)
    : width_(map.width),
      height_(map.height),
      resolution_(map.resolution),
      reach_(params.reach),
      origin_(map.origin_x, map.origin_y) {
  if (width_ < 1 || height_ < 1 || !(resolution_ > 0.0) || !origin_.allFinite() ||
      map.cells.size() != static_cast<std::size_t>(width_) * height_) {
    throw std::invalid_argument("the map has " + std::to_string(map.cells.size()) + " cells for " +
                                std::to_string(width_) + " x " + std::to_string(height_) + " of " +
                                std::to_string(resolution_) + " m");
  }
  markSurfaces(map, params);
  transform();
}

void DistanceField::markSurfaces(const GridMap& map, const FieldParams& params) {
  distances_.assign(map.cells.size(), kFar);
  free_.assign(map.cells.size(), false);
  const auto open = [&](int column, int row) {
    if (column < 0 || row < 0 || column >= width_ || row >= height_) {
      return false;
    }
    const auto cell = map.cells[indexOf(column, row)];
    return cell >= 0 && cell < params.occupied_at_least;
  };
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      const std::size_t index = indexOf(column, row);
      if (map.cells[index] >= 0 && map.cells[index] <= params.free_at_most) {
        free_[index] = true;
        ++free_cells_;
      }
      const bool faces =
          open(column - 1, row) || open(column + 1, row) || open(column, row - 1) || open(column, row + 1);
      if (map.cells[index] >= params.occupied_at_least && faces) {
        distances_[index] = 0.0F;
        ++surface_cells_;
      }
    }
  }
}

void DistanceField::transform() {
  LineTransform along(std::max(width_, height_));
  for (int column = 0; column < width_; ++column) {
    along(distances_.data() + column, height_, width_);
  }
  for (int row = 0; row < height_; ++row) {
    along(distances_.data() + indexOf(0, row), width_, 1);
  }
  const auto reach = static_cast<float>(reach_);
  for (float& distance : distances_) {
    distance = std::min(reach, static_cast<float>(resolution_) * std::sqrt(distance));
  }
}

FieldSample DistanceField::at(const Eigen::Vector2d& point) const {
  const double x = (point.x() - origin_.x()) / resolution_ - 0.5;
  const double y = (point.y() - origin_.y()) / resolution_ - 0.5;
  if (!(x >= 0.0 && y >= 0.0 && x < width_ - 1 && y < height_ - 1)) {
    return {reach_, Eigen::Vector2d::Zero()};
  }
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const double u = x - column;
  const double v = y - row;
  const float* lower = distances_.data() + indexOf(column, row);
  const float* upper = lower + width_;
  const double below = (1.0 - u) * lower[0] + u * lower[1];
  const double above = (1.0 - u) * upper[0] + u * upper[1];
  const double slope = (1.0 - v) * (lower[1] - lower[0]) + v * (upper[1] - upper[0]);
  return {(1.0 - v) * below + v * above, Eigen::Vector2d{slope, above - below} / resolution_};
}

bool DistanceField::isFree(const Eigen::Vector2d& point) const {
  const double column = std::floor((point.x() - origin_.x()) / resolution_);
  const double row = std::floor((point.y() - origin_.y()) / resolution_);
  return column >= 0.0 && row >= 0.0 && column < width_ && row < height_ &&
         free_[indexOf(static_cast<int>(column), static_cast<int>(row))];
}

}  // namespace yarm::slam
