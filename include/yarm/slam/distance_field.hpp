// How far every place of a map is from the nearest surface.
//
// Exact Euclidean distances in linear time after P. Felzenszwalb and D. Huttenlocher, "Distance transforms of sampled
// functions", Theory of Computing 8, 2012.
#pragma once

#include "yarm/slam/localiser_params.hpp"
#include "yarm/slam/types.hpp"

#include <Eigen/Core>

#include <cmath>
#include <cstddef>
#include <vector>

namespace yarm::slam {

/// Distance to the nearest surface and the direction away from it.
struct FieldSample {
  double distance{0};                                 ///< metres, at most the field's reach
  Eigen::Vector2d gradient{Eigen::Vector2d::Zero()};  ///< of the distance; zero where no surface is in reach
};

/// The field of one map, in the map's frame. Surfaces are the centres of the occupied cells beside one that is known
/// and not occupied: what a beam can end on. The back of a wall, beside cells that are not known, is none. Not changed
/// once made.
class DistanceField {
 public:
  /// O(cells). Throws std::invalid_argument when the map's size and cells do not fit together.
  DistanceField(const GridMap& map, const FieldParams& params);

  /// Bilinear between the cells' centres; outside of the map there is no surface.
  [[nodiscard]] FieldSample at(const Eigen::Vector2d& point) const;
  /// Whether a point lies in a cell known to be free.
  [[nodiscard]] bool isFree(const Eigen::Vector2d& point) const;
  /// Distance of a cell's centre, metres; the cell must be in the map.
  [[nodiscard]] float cell(int column, int row) const { return distances_[indexOf(column, row)]; }
  [[nodiscard]] bool isFreeCell(int column, int row) const { return free_[indexOf(column, row)]; }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] double resolution() const { return resolution_; }
  [[nodiscard]] double reach() const { return reach_; }
  [[nodiscard]] int surfaceCells() const { return surface_cells_; }
  [[nodiscard]] int freeCells() const { return free_cells_; }
  /// Centre of a cell, map frame, metres.
  [[nodiscard]] Eigen::Vector2d centre(int column, int row) const {
    return origin_ + resolution_ * Eigen::Vector2d{column + 0.5, row + 0.5};
  }

 private:
  [[nodiscard]] std::size_t indexOf(int column, int row) const {
    return static_cast<std::size_t>(row) * width_ + column;
  }
  void markSurfaces(const GridMap& map, const FieldParams& params);
  void transform();

  int width_;
  int height_;
  double resolution_;
  double reach_;
  Eigen::Vector2d origin_;
  int surface_cells_{0};
  int free_cells_{0};
  std::vector<float> distances_;  ///< metres
  std::vector<bool> free_;
};

}  // namespace yarm::slam
