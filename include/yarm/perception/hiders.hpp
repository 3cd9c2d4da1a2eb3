// Who hides a cell from the cameras.
#pragma once

#include "yarm/perception/occupancy.hpp"
#include "yarm/perception/visibility.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace yarm::perception {

/// Objects that have a bit of their own; all others share kOtherHiders.
constexpr std::size_t kNamedHiders = 30;
/// Bit of the objects from the 31st on.
constexpr std::uint32_t kOtherHiders = 1U << 30;
/// A camera that would see the cell, were nothing there, does not, and nobody on the map is the reason: it has no view
/// or no reading, or what hides the cell is outside of the map.
constexpr std::uint32_t kNoHider = 1U << 31;

/// Finds who may hide each cell that no camera sees: whoever has a cell on the line from the middle of it to a camera,
/// or one of the 26 neighbours of those (and of a few cells beside the line, at its corners). The pixels that a cell
/// falls onto look past that line at less than a cell's distance, so whoever does hide it is among them; others may be,
/// too. So is what is just behind it, within the readings' noise. Which cells these are is found once for each cell and
/// camera, when it is first asked for. Keeps its buffers: not thread safe.
class HiderFinder {
 public:
  explicit HiderFinder(const GridSpec& spec);

  /// Bit k of an entry is object k of the grid (kOtherHiders for those without a bit of their own); one entry for each
  /// cell that is hidden or never seen, in their order; 0 for one that no camera would see anyway, which is not known
  /// (kNoHider) while a camera has not had a view yet. Valid until the next call. O(cells + hidden cells * cameras).
  const std::vector<std::uint32_t>& find(const OccupancyGrid& grid, const SeenCells& seen);

 private:
  /// The layers of the grid along an axis.
  struct Layers {
    int count;
    std::ptrdiff_t stride;  // of the index, from one to the next

    /// Index of the one that a place is in, cells; the nearest one for a place outside.
    [[nodiscard]] std::ptrdiff_t at(double place) const {
      return std::clamp(static_cast<int>(place), 0, count - 1) * stride;
    }
  };

  /// Cells whose owners count for the lines from hidden cells to one camera. They are looked at in each set, so they
  /// take as little room as the grid allows.
  template <class Index>
  struct Lines {
    Eigen::Vector3d camera{Eigen::Vector3d::Zero()};
    std::vector<std::uint32_t> first;  // of each cell's in `cells`, the number of them; 0 for one not asked for yet
    std::vector<Index> cells;
  };

  void gatherOwners(const OccupancyGrid& grid);
  void spread(std::size_t stride, std::size_t length);
  template <class Index>
  void findAlong(std::vector<Lines<Index>>& lines, const SeenCells& seen);
  template <class Index>
  void follow(const std::vector<Eigen::Vector3d>& cameras, std::vector<Lines<Index>>& lines) const;
  template <class Index>
  static void fetch(std::size_t far, std::size_t near, const std::vector<Lines<Index>>& lines);
  template <class Index>
  [[nodiscard]] std::uint32_t ownersBetween(std::size_t cell, Lines<Index>& lines) const;
  template <class Index>
  void addLine(const Cell& cell, Lines<Index>& lines) const;
  template <class Index>
  void addCells(const Eigen::Vector3d& from, const Eigen::Vector3d& way, double share, Lines<Index>& lines) const;
  [[nodiscard]] Layers layers(Eigen::Index axis) const;

  GridSpec spec_;
  std::vector<std::uint32_t> owners_;  // bits of who has a cell or is beside it
  std::vector<std::uint32_t> spread_;
  std::vector<std::size_t> unseen_;  // the cells that are asked about
  std::vector<std::uint32_t> found_;
  std::vector<Lines<std::uint16_t>> narrow_;  // of each camera, in grids whose cells two bytes number
  std::vector<Lines<std::uint32_t>> wide_;    // and in others
};

}  // namespace yarm::perception
