// Onto which pixels each cell of the grid falls in one camera's image, and the votes that follow from its depths.
#pragma once

#include "depth_view.hpp"

#include "yarm/perception/visibility.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace yarm::perception {

/// The cells of a grid as one camera sees them. Computed once; the votes are cast block by block: most blocks of
/// 4 x 4 x 4 cells, and of the others most parts of 2 x 2 x 2, are seen through or hidden as a whole.
class CellViews {
 public:
  CellViews(const GridSpec& grid, const Pinhole& optics, const Eigen::Isometry3f& T_world_camera);

  /// Pixels, inclusive, between which every point of a cell falls; none where `right` < `left`.
  struct View {
    std::uint16_t left{1}, right{0}, top{0}, bottom{0};
    float deepest{0.F};  ///< depth of its farthest point, metres
  };
  /// The same of all cells of a block or part; none when one of its cells has none.
  struct Group {
    View view;
    float shallowest{0.F};  ///< least of its cells' deepest, metres
  };

  /// Sets this camera's bit (`bit`: one of 16) for the cells seen through, and for those something nearer hides.
  /// `clear`: what clearDepths gives. Votes must have one entry a cell. `force_scalar`: the portable path, for tests.
  void vote(const std::vector<float>& clear, std::uint16_t bit, CellVotes& votes, bool force_scalar = false) const;

  /// Rows of the image that any cell falls onto; the others are never looked at.
  [[nodiscard]] const Rows& rows() const { return rows_; }

 private:
  struct Corner {
    float column, row, depth;
  };
  struct Cells {
    std::array<int, 3> low, high;
  };
  class Ballot;

  void project(const GridSpec& grid, const Pinhole& optics, const Eigen::Isometry3f& T_world_camera);
  [[nodiscard]] View viewOf(int x, int y, int z) const;
  [[nodiscard]] Group groupOf(std::size_t first_cell) const;
  void addBlock(const Cells& block);
  template <class Use>
  static void forEachPart(const Cells& whole, int edge, Use&& use);

  std::array<int, 3> size_;
  std::size_t width_;
  std::size_t height_;
  Rows rows_;
  std::vector<Corner> corners_;  // (size + 1)^3, row-major; only while computing
  std::vector<View> cells_;      // block by block, in each part by part: the order they are looked at
  std::vector<Group> parts_;     // block by block
  std::vector<Group> blocks_;
};

}  // namespace yarm::perception
