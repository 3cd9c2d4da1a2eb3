// Onto which pixels each cell of the grid falls in one camera's image, and the votes that follow from its depths.
#pragma once

#include "depth_view.hpp"

#include "yarm/perception/visibility.hpp"

#include <cstdint>
#include <vector>

namespace yarm::perception {

/// The cells of a grid as one camera sees them. Computed once; the votes are cast block by block: most blocks of
/// 4 x 4 x 4 cells are seen through as a whole.
class CellViews {
 public:
  CellViews(const GridSpec& grid, const Pinhole& optics, const Eigen::Isometry3f& T_world_camera);

  /// Pixels, inclusive, between which every point of a cell or block falls; none where `right` < `left`.
  struct View {
    std::uint16_t left{1}, right{0}, top{0}, bottom{0};
    float deepest{0.F};  ///< depth of its farthest point, metres
  };

  /// Sets this camera's bit (`bit`: one of 16) for the cells seen through, and for those something nearer hides.
  /// `clear`: what clearDepths gives. Votes must have one entry a cell. `force_scalar`: the portable path, for tests.
  void vote(const std::vector<float>& clear, std::uint16_t bit, CellVotes& votes, bool force_scalar = false) const;

 private:
  struct Corner {
    float column, row, depth;
  };

  void project(const GridSpec& grid, const Pinhole& optics, const Eigen::Isometry3f& T_world_camera);
  [[nodiscard]] View viewOf(const std::array<int, 3>& low, const std::array<int, 3>& high) const;

  std::array<int, 3> size_;
  std::size_t width_;
  std::size_t height_;
  std::vector<Corner> corners_;  // (size + 1)^3, row-major; only while computing
  std::vector<View> cells_;      // block by block, in each row-major: the order they are looked at
  std::vector<View> blocks_;
};

}  // namespace yarm::perception
