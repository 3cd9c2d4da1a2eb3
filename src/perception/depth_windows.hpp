// What the pixels of boxes of an image say about depths, eight boxes at a time, from windows that are looked at once.
#pragma once

#include "depth_view.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace yarm::perception {

/// Sizes of windows: 2 and 4 pixels along an edge.
constexpr std::size_t kWindowSizes = 2;

/// A clear depth greater than 0 as a number that keeps its order; the lowest bit says that a reading is missing.
using DepthKey = std::int32_t;

/// Pixels of an image, inclusive, two columns and two rows at least, and the depths that theirs are compared with,
/// metres. None where `right` < `left`.
struct DepthBox {
  std::uint16_t left{1}, right{0}, top{0}, bottom{0};
  float deepest{0.F}, shallowest{0.F};

  [[nodiscard]] bool isNone() const { return right < left; }
};

/// Up to eight boxes that are looked at together; without `shallowest`, which only groups have a use for: there are
/// many, and reading them costs as much as their windows.
class EightBoxes {
 public:
  explicit EightBoxes(const std::array<DepthBox, 8>& boxes);

  std::array<std::uint16_t, 8> left{}, top{};
  std::array<std::uint16_t, 8> last_column{}, last_row{};  ///< where the last of their windows begin
  std::array<DepthKey, 8> deepest{};
  std::uint8_t taken{0};                             ///< a bit for each that is a box
  std::uint8_t level{0}, edge{2};                    ///< of the windows: number of their size, and the size, pixels
  std::uint16_t windows_across{0}, windows_down{0};  ///< so many cover any of the boxes
};

/// The same of groups of cells.
class EightGroups : public EightBoxes {
 public:
  explicit EightGroups(const std::array<DepthBox, 8>& boxes);

  std::array<float, 8> shallowest{};
};

/// A bit for each of eight boxes; those of boxes that are not taken mean nothing.
struct EightFound {
  unsigned before;   ///< something nearer than its deepest was read
  unsigned missing;  ///< some reading is missing
  unsigned beyond;   ///< some depth is as great as its shallowest
  unsigned read;     ///< there is some reading
};

/// For every pixel the windows of each size that begin there: any box is covered by a few, which may overlap.
class DepthWindows {
 public:
  /// Looks at the rows of an image of clear depths (clearDepths); what was asked before means nothing any more.
  /// `force_scalar` keeps the portable path, for the tests. O(pixels of the rows).
  void take(const std::vector<float>& clear, std::size_t width, const Rows& rows, bool force_scalar = false);

  /// `before` and `missing` only.
  [[nodiscard]] EightFound lookAt(const EightBoxes& boxes) const { return look_(squares_[boxes.level], width_, boxes); }
  [[nodiscard]] EightFound lookAtGroups(const EightGroups& groups) const {
    return look_at_groups_(squares_[groups.level], width_, groups);
  }

  /// What windows of one size say, those of a row after the other; some behind the last of a row mean nothing.
  struct Level {
    std::vector<DepthKey> nearest;  ///< of the readings
    std::vector<float> farthest;    ///< metres; 0 without a reading
  };

 private:
  template <class Boxes>
  using Look = EightFound (*)(const Level& windows, std::size_t width, const Boxes& boxes);

  std::size_t width_{0};
  Look<EightBoxes> look_{nullptr};
  Look<EightGroups> look_at_groups_{nullptr};
  Level pairs_;  // of two rows and two columns each, while looking
  std::array<Level, kWindowSizes> squares_;
};

}  // namespace yarm::perception
