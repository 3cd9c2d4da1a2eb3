#include "yarm/perception/hiders.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace yarm::perception {

namespace {

/// Cells behind a cell whose owners count: a reading there may still be in it, for all that its noise says.
constexpr double kBehind = 3.0;
/// Cells ahead whose lines are fetched: what others did since the last set has pushed them out of the nearer caches.
constexpr std::size_t kAhead = 16;
/// Cells of all lines to a camera that are kept; then they are found anew.
constexpr std::size_t kMostKept = std::size_t{1} << 21;

std::uint32_t bitOf(std::size_t object) {
  return object < kNamedHiders ? 1U << object : kOtherHiders;
}

}  // namespace

HiderFinder::HiderFinder(const GridSpec& spec) : spec_(spec) {}

const std::vector<std::uint32_t>& HiderFinder::find(const OccupancyGrid& grid, const SeenCells& seen) {
  gatherOwners(grid);
  found_.clear();
  unseen_.clear();
  for (std::size_t i = 0; i < seen.states.size(); ++i) {
    if (!isSeen(seen.states[i])) {
      unseen_.push_back(i);
    }
  }
  if (spec_.count() - 1 <= std::numeric_limits<std::uint16_t>::max()) {
    findAlong(narrow_, seen);
  } else {
    findAlong(wide_, seen);
  }
  return found_;
}

template <class Index>
void HiderFinder::findAlong(std::vector<Lines<Index>>& lines, const SeenCells& seen) {
  follow(seen.cameras, lines);
  const bool all_placed = std::all_of(seen.cameras.begin(), seen.cameras.end(),
                                      [](const Eigen::Vector3d& camera) { return camera.allFinite(); });
  const std::uint32_t where_none_looks = all_placed ? 0U : kNoHider;
  for (std::size_t k = 0; k < unseen_.size(); ++k) {
    if (k + kAhead < unseen_.size()) {
      fetch(unseen_[k + kAhead], unseen_[k + kAhead / 2], lines);
    }
    const std::uint16_t behind = seen.behind[k];
    std::uint32_t hiders = seen.unseen[k] != 0 ? kNoHider : (behind == 0 ? where_none_looks : 0U);
    for (std::size_t c = 0; c < seen.cameras.size(); ++c) {
      if ((behind >> c & 1U) != 0) {
        const std::uint32_t on_the_line = ownersBetween(unseen_[k], lines[c]);
        hiders |= on_the_line == 0 ? kNoHider : on_the_line;
      }
    }
    found_.push_back(hiders);
  }
}

/// Asks for what is soon needed of two cells, of the first where its lines are, of the second the lines.
template <class Index>
void HiderFinder::fetch(std::size_t far, std::size_t near, const std::vector<Lines<Index>>& lines) {
  for (const Lines<Index>& of_camera : lines) {
    __builtin_prefetch(&of_camera.first[far]);
    __builtin_prefetch(&of_camera.cells[of_camera.first[near]]);
  }
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
  spread_.resize(owners_.size());
  for (std::size_t run = 0; run < owners_.size(); run += length) {
    const std::uint32_t* const own = owners_.data() + run;
    std::uint32_t* __restrict const to = spread_.data() + run;
    if (length == stride) {
      std::copy(own, own + length, to);
      continue;
    }
    const std::size_t last = length - stride;
    for (std::size_t i = 0; i < stride; ++i) {
      to[i] = own[i] | own[i + stride];
      to[last + i] = own[last + i] | own[last + i - stride];
    }
    for (std::size_t i = stride; i < last; ++i) {
      to[i] = own[i] | own[i - stride] | own[i + stride];
    }
  }
  owners_.swap(spread_);
}

/// Forgets the lines to a camera that stands elsewhere now.
template <class Index>
void HiderFinder::follow(const std::vector<Eigen::Vector3d>& cameras, std::vector<Lines<Index>>& lines) const {
  lines.resize(cameras.size());
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    Lines<Index>& mine = lines[c];
    if (mine.first.empty() || mine.camera != cameras[c] || mine.cells.size() > kMostKept) {
      mine.camera = cameras[c];
      mine.first.assign(spec_.count(), 0);
      mine.cells.assign(1, 0);
    }
  }
}

/// Bits of all who have a cell on the line from the middle of a cell to a camera, or just behind it, or beside those.
template <class Index>
std::uint32_t HiderFinder::ownersBetween(std::size_t cell, Lines<Index>& lines) const {
  if (lines.first[cell] == 0) {
    lines.first[cell] = static_cast<std::uint32_t>(lines.cells.size());
    addLine(spec_.cellOf(static_cast<int>(cell)), lines);
  }
  const Index* const number = lines.cells.data() + lines.first[cell];
  std::uint32_t bits = 0;
  for (std::size_t i = 1; i <= *number; ++i) {
    bits |= owners_[number[i]];
  }
  return bits;
}

template <class Index>
void HiderFinder::addLine(const Cell& cell, Lines<Index>& lines) const {
  const Eigen::Vector3d middle(cell.x + 0.5, cell.y + 0.5, cell.z + 0.5);
  const Eigen::Vector3d way =
      (lines.camera - spec_.centre(cell))
          .cwiseQuotient(Eigen::Vector3d(spec_.resolution(0), spec_.resolution(1), spec_.resolution(2)));
  const double longest = way.cwiseAbs().maxCoeff();
  const std::size_t number = lines.cells.size();
  lines.cells.push_back(0);
  addCells(middle, way, 1.0, lines);
  addCells(middle, -way, longest > 0.0 ? kBehind / longest : 0.0, lines);
  lines.cells[number] = static_cast<Index>(lines.cells.size() - number - 1);
}

/// All cells that a line meets, from a point in cells on, for a share of a way; and some right beside it.
template <class Index>
void HiderFinder::addCells(const Eigen::Vector3d& from, const Eigen::Vector3d& way, double share,
                           Lines<Index>& lines) const {
  Eigen::Index along = 0;
  const double longest = way.cwiseAbs().maxCoeff(&along);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {  // it ends at the grid's border at the latest
    const double room = way[axis] < 0.0 ? from[axis] : spec_.size[static_cast<std::size_t>(axis)] - from[axis];
    share = way[axis] == 0.0 ? share : std::min(share, room / std::abs(way[axis]));
  }
  // Layer by layer along the axis in which it is longest: in one it meets at most two cells along each other axis.
  const Eigen::Index across = (along + 1) % 3;
  const Eigen::Index other = (along + 2) % 3;
  const Layers a = layers(along);
  const Layers b = layers(across);
  const Layers c = layers(other);
  const int step = way[along] < 0.0 ? -1 : 1;
  const double length = share * longest;
  const double slope_b = longest > 0.0 ? way[across] / longest : 0.0;
  const double slope_c = longest > 0.0 ? way[other] / longest : 0.0;
  int layer = static_cast<int>(from[along]);
  std::ptrdiff_t b0 = b.at(from[across]);
  std::ptrdiff_t c0 = c.at(from[other]);
  for (double reached = 0.5; layer >= 0 && layer < a.count; reached += 1.0, layer += step) {
    const double until = std::min(reached, length);
    const std::ptrdiff_t b1 = b.at(from[across] + slope_b * until);
    const std::ptrdiff_t c1 = c.at(from[other] + slope_c * until);
    for (const std::ptrdiff_t b_at : {b0, b1}) {
      for (const std::ptrdiff_t c_at : {c0, c1}) {
        lines.cells.push_back(static_cast<Index>(layer * a.stride + b_at + c_at));
        if (c1 == c0) {
          break;
        }
      }
      if (b1 == b0) {
        break;
      }
    }
    if (reached >= length) {
      break;
    }
    b0 = b1;
    c0 = c1;
  }
}

HiderFinder::Layers HiderFinder::layers(Eigen::Index axis) const {
  const auto gy = static_cast<std::ptrdiff_t>(spec_.size[1]);
  const auto gz = static_cast<std::ptrdiff_t>(spec_.size[2]);
  return {spec_.size[static_cast<std::size_t>(axis)], axis == 0 ? gy * gz : (axis == 1 ? gz : 1)};
}

}  // namespace yarm::perception
