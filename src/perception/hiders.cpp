#include "yarm/perception/hiders.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace yarm::perception {

namespace {

/// Cells behind a cell whose owners count: a reading there may still be in it, for all that its noise says.
constexpr int kStepsBehind = 3;

/// A walk through the cells that a line meets, from the middle of one of them (Amanatides and Woo, 1987).
class Walk {
 public:
  Walk(const GridSpec& spec, const Cell& from, const Eigen::Vector3d& to) : spec_(spec), at_{from.x, from.y, from.z} {
    const Eigen::Vector3d way = to - spec.centre(from);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double cells = way[static_cast<Eigen::Index>(axis)] / spec.resolution(static_cast<int>(axis));
      step_[axis] = cells < 0.0 ? -1 : 1;
      share_[axis] = cells == 0.0 ? std::numeric_limits<double>::infinity() : 1.0 / std::abs(cells);
      next_[axis] = 0.5 * share_[axis];
    }
  }

  /// Goes on to the next cell; false when it lies outside, or beyond the end of the line.
  bool go() {
    const auto axis = static_cast<std::size_t>(std::min_element(next_.begin(), next_.end()) - next_.begin());
    if (!(next_[axis] < 1.0)) {
      return false;
    }
    next_[axis] += share_[axis];
    at_[axis] += step_[axis];
    return at_[axis] >= 0 && at_[axis] < spec_.size[axis];
  }

  [[nodiscard]] std::size_t index() const {
    return static_cast<std::size_t>(spec_.indexOf(Cell{at_[0], at_[1], at_[2]}));
  }

 private:
  const GridSpec& spec_;
  std::array<int, 3> at_;
  std::array<int, 3> step_{};
  std::array<double, 3> share_{};  // of the line, from one cell to the next along an axis
  std::array<double, 3> next_{};   // share of the line at which the next cell along an axis begins
};

std::uint32_t bitOf(std::size_t object) {
  return object < kNamedHiders ? 1U << object : kOtherHiders;
}

}  // namespace

HiderFinder::HiderFinder(const GridSpec& spec) : spec_(spec) {}

const std::vector<std::uint32_t>& HiderFinder::find(const OccupancyGrid& grid, const SeenCells& seen) {
  gatherOwners(grid);
  found_.clear();
  const bool all_placed = std::all_of(seen.cameras.begin(), seen.cameras.end(),
                                      [](const Eigen::Vector3d& camera) { return camera.allFinite(); });
  const std::uint32_t where_none_looks = all_placed ? 0U : kNoHider;
  for (std::size_t i = 0; i < seen.states.size(); ++i) {
    if (isSeen(seen.states[i])) {
      continue;
    }
    const std::uint16_t behind = seen.behind[found_.size()];
    const std::uint16_t silent = seen.unseen[found_.size()];
    std::uint32_t hiders = silent != 0 ? kNoHider : (behind == 0 ? where_none_looks : 0U);
    for (std::size_t c = 0; c < seen.cameras.size(); ++c) {
      if ((behind >> c & 1U) != 0) {
        const std::uint32_t on_the_line = along(spec_.cellOf(static_cast<int>(i)), seen.cameras[c]);
        hiders |= on_the_line == 0 ? kNoHider : on_the_line;
      }
    }
    found_.push_back(hiders);
  }
  return found_;
}

void HiderFinder::gatherOwners(const OccupancyGrid& grid) {
  owners_.assign(spec_.count(), 0);
  for (std::size_t object = 0; object < grid.object_cells.size(); ++object) {
    for (const std::int32_t cell : grid.object_cells[object]) {
      owners_[static_cast<std::size_t>(cell)] |= bitOf(object);
    }
  }
  const auto gy = static_cast<std::size_t>(spec_.size[1]);
  const auto gz = static_cast<std::size_t>(spec_.size[2]);
  spread(1, gz);
  spread(gz, gy * gz);
  spread(gy * gz, spec_.count());
}

/// Every cell takes on the bits of its two neighbours `stride` apart, within runs of `length` cells.
void HiderFinder::spread(std::size_t stride, std::size_t length) {
  spread_ = owners_;
  for (std::size_t run = 0; run < owners_.size(); run += length) {
    for (std::size_t i = run; i + stride < run + length; ++i) {
      spread_[i] |= owners_[i + stride];
      spread_[i + stride] |= owners_[i];
    }
  }
  owners_.swap(spread_);
}

std::uint32_t HiderFinder::along(const Cell& cell, const Eigen::Vector3d& camera) const {
  std::uint32_t bits = owners_[static_cast<std::size_t>(spec_.indexOf(cell))];
  for (Walk walk(spec_, cell, camera); walk.go();) {
    bits |= owners_[walk.index()];
  }
  Walk away(spec_, cell, 2.0 * spec_.centre(cell) - camera);
  for (int step = 0; step < kStepsBehind && away.go(); ++step) {
    bits |= owners_[away.index()];
  }
  return bits;
}

}  // namespace yarm::perception
