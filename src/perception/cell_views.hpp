// Onto which pixels each cell of the grid falls in one camera's image, and the votes that follow from its depths.
#pragma once

#include "depth_view.hpp"
#include "depth_windows.hpp"

#include "yarm/perception/visibility.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace yarm::perception {

/// Which groups of cells are seen through as a whole by a camera that has voted already: a bit for each of the eight
/// blocks of a hall, and of the eight parts of a block. Of one grid; empty before the first camera.
struct SeenThrough {
  std::vector<std::uint8_t> halls;
  std::vector<std::uint8_t> blocks;
};

/// The cells of a grid as one camera sees them. Computed once; the votes are cast block by block: most blocks of
/// 4 x 4 x 4 cells, and of the others most parts of 2 x 2 x 2, are seen through or hidden as a whole. Eight blocks (a
/// hall), the eight parts of one and the eight cells of one of these are looked at together.
class CellViews {
 public:
  CellViews(const GridSpec& grid, const Pinhole& optics, const Eigen::Isometry3f& T_world_camera);

  /// Sets this camera's bit (`bit`: one of 16) for the cells seen through, and for those something nearer hides; those
  /// in groups that are `seen` through already it leaves as they are, and adds the groups that it sees through.
  /// `clear`: windows of what clearDepths gives. Votes must have one entry a cell.
  void vote(const DepthWindows& clear, std::uint16_t bit, SeenThrough& seen, CellVotes& votes) const;

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
  [[nodiscard]] DepthBox boxOf(const Cells& cell);
  template <class Boxes, class BoxOf>
  static DepthBox addEight(const Cells& whole, int edge, std::vector<Boxes>& to, BoxOf&& box_of);
  [[nodiscard]] static unsigned laneOf(const Cells& whole, const Cells& part);
  [[nodiscard]] static std::size_t groupsOf(const Cells& whole, int edge);
  template <class Use>
  static void forEachPart(const Cells& whole, int edge, Use&& use);

  std::array<int, 3> size_;
  std::size_t width_;
  std::size_t height_;
  Rows rows_;
  std::vector<Corner> corners_;     // (size + 1)^3, row-major; only while computing
  std::vector<EightGroups> halls_;  // eight blocks each
  std::vector<EightGroups> blocks_;
  std::vector<EightBoxes> parts_;
};

}  // namespace yarm::perception
