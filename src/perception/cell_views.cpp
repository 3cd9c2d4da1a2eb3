#include "cell_views.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <type_traits>

namespace yarm::perception {

namespace {

constexpr int kHall = 8;               // cells along an edge of eight blocks
constexpr int kBlock = 4;              // of a block
constexpr int kPart = 2;               // and of a part of one
constexpr float kNearest = 0.05F;      // what comes nearer to the camera's plane than this is not in its image, metres
constexpr float kPixelSlack = 0.01F;   // of rounding, pixels
constexpr float kDepthSlack = 0.001F;  // of rounding, metres

enum class Verdict { kThrough, kBehind, kUnread, kMixed };

/// What holds for every cell of the k-th of eight groups.
Verdict verdictOn(const EightFound& found, const EightGroups& groups, unsigned k) {
  const auto is = [k](unsigned bits) { return (bits >> k & 1U) != 0; };
  if (!is(groups.taken)) {
    return Verdict::kMixed;
  }
  if (is(found.missing)) {
    return is(found.read) ? Verdict::kMixed : Verdict::kUnread;
  }
  if (!is(found.before)) {
    return Verdict::kThrough;
  }
  return is(found.beyond) ? Verdict::kMixed : Verdict::kBehind;
}

/// None when one of them is.
DepthBox unionOf(const DepthBox& a, const DepthBox& b) {
  if (a.isNone() || b.isNone()) {
    return {};
  }
  return {std::min(a.left, b.left),     std::max(a.right, b.right),     std::min(a.top, b.top),
          std::max(a.bottom, b.bottom), std::max(a.deepest, b.deepest), std::min(a.shallowest, b.shallowest)};
}

}  // namespace

/// One camera's votes on one set.
class CellViews::Ballot {
 public:
  Ballot(const CellViews& views, const DepthWindows& clear, std::uint16_t bit, SeenThrough& seen, CellVotes& votes)
      : views_(views),
        clear_(clear),
        bit_(bit),
        seen_(seen),
        votes_(votes),
        pairs_{{{0, 0}, {bit, 0}, {0, bit}, {bit, bit}}} {
    seen_.halls.resize(views.halls_.size(), 0);
    seen_.blocks.resize(views.blocks_.size(), 0);
  }

  void castAll() {
    std::size_t hall = 0;
    forEachPart({{0, 0, 0}, views_.size_}, kHall, [this, &hall](const Cells& cells) {
      const std::size_t blocks = groupsOf(cells, kBlock);
      if (allOf(blocks, seen_.halls[hall])) {
        block_ += blocks;
        part_ += groupsOf(cells, kPart);
      } else {
        fetch(views_.blocks_, block_, block_ + blocks);
        castGroups(cells, kBlock, views_.halls_[hall], seen_.halls[hall],
                   [this](Verdict of_block, const Cells& block) { return castBlock(of_block, block); });
      }
      ++hall;
    });
  }

 private:
  /// Of all eight bits, or of the fewer groups of a hall or block at the grid's end.
  static bool allOf(std::size_t groups, unsigned bits) {
    return static_cast<std::size_t>(__builtin_popcount(bits)) == groups;
  }

  /// Asks for boxes that are soon looked at: others have pushed them out of the nearer caches since the last set.
  template <class Boxes>
  static void fetch(const std::vector<Boxes>& all, std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      __builtin_prefetch(&all[i]);
      __builtin_prefetch(&all[i].deepest);
    }
  }

  /// Casts the votes of those of eight groups whose cells all have the same, and tells `use` of each what it is, which
  /// says whether it is seen through as a whole. `seen`: those that are.
  template <class Use>
  void castGroups(const Cells& whole, int edge, const EightGroups& groups, std::uint8_t& seen, Use&& use) {
    const EightFound found = clear_.lookAtGroups(groups);
    const unsigned before = seen;
    forEachPart(whole, edge, [&](const Cells& group) {
      const unsigned lane = laneOf(whole, group);
      Verdict verdict = Verdict::kThrough;
      if ((before >> lane & 1U) == 0) {
        verdict = verdictOn(found, groups, lane);
        cast(verdict, group);
      }
      seen = static_cast<std::uint8_t>(seen | static_cast<unsigned>(use(verdict, group)) << lane);
    });
  }

  bool castBlock(Verdict of_block, const Cells& block) {
    std::uint8_t& seen = seen_.blocks[block_];
    const EightGroups& parts = views_.blocks_[block_++];
    const std::size_t first = part_;
    part_ += groupsOf(block, kPart);
    if (of_block == Verdict::kMixed) {
      std::size_t part = first;
      fetch(views_.parts_, first, part_);
      castGroups(block, kPart, parts, seen, [this, &part](Verdict of_part, const Cells& cells) {
        const EightBoxes& each = views_.parts_[part++];
        return of_part == Verdict::kThrough || (of_part == Verdict::kMixed && castEach(cells, each));
      });
    }
    return of_block == Verdict::kThrough || allOf(part_ - first, seen);
  }

  void cast(Verdict verdict, const Cells& cells) {
    if (verdict == Verdict::kUnread || verdict == Verdict::kMixed) {
      return;
    }
    std::vector<std::uint16_t>& mine = verdict == Verdict::kThrough ? votes_.through : votes_.behind;
    for (int x = cells.low[0]; x < cells.high[0]; ++x) {
      for (int y = cells.low[1]; y < cells.high[1]; ++y) {
        std::uint16_t* const column = &mine[indexOf(x, y, cells.low[2])];
        if (cells.high[2] - cells.low[2] == kBlock) {
          addBits<kBlock>(column, {bit_, bit_, bit_, bit_});
        } else {
          std::for_each(column, column + cells.high[2] - cells.low[2], [this](std::uint16_t& votes) { votes |= bit_; });
        }
      }
    }
  }

  /// Each of the cells of a part on its own; whether all of them are seen through now, by whomever.
  bool castEach(const Cells& part, const EightBoxes& boxes) {
    const EightFound found = clear_.lookAt(boxes);
    const unsigned behind = found.before & boxes.taken;
    const unsigned through = ~(found.before | found.missing) & boxes.taken;
    bool all = true;
    unsigned lane = 0;
    for (int x = part.low[0]; x < part.high[0]; ++x, lane = 4) {
      for (int y = part.low[1]; y < part.high[1]; ++y, lane += 2) {
        const std::size_t first = indexOf(x, y, part.low[2]);
        if (part.high[2] - part.low[2] == kPart) {
          addBits<kPart>(&votes_.through[first], pairs_[through >> lane & 3U]);
          addBits<kPart>(&votes_.behind[first], pairs_[behind >> lane & 3U]);
          all = all && votes_.through[first] != 0 && votes_.through[first + 1] != 0;
        } else {
          votes_.through[first] |= pairs_[through >> lane & 1U][0];
          votes_.behind[first] |= pairs_[behind >> lane & 1U][0];
          all = all && votes_.through[first] != 0;
        }
      }
    }
    return all;
  }

  /// To several cells at once.
  template <std::size_t kCount>
  static void addBits(std::uint16_t* cells, const std::array<std::uint16_t, kCount>& bits) {
    using Word = std::conditional_t<kCount == 2, std::uint32_t, std::uint64_t>;
    static_assert(sizeof(Word) == sizeof bits);
    Word to = 0;
    Word more = 0;
    std::memcpy(&to, cells, sizeof to);
    std::memcpy(&more, bits.data(), sizeof more);
    to |= more;
    std::memcpy(cells, &to, sizeof to);
  }

  [[nodiscard]] std::size_t indexOf(int x, int y, int z) const {
    return static_cast<std::size_t>((x * views_.size_[1] + y) * views_.size_[2] + z);
  }

  const CellViews& views_;
  const DepthWindows& clear_;
  std::uint16_t bit_;
  SeenThrough& seen_;
  CellVotes& votes_;
  std::array<std::array<std::uint16_t, kPart>, 4> pairs_;  // two cells: the bit in neither, the first, the second, both
  std::size_t block_{0};
  std::size_t part_{0};
};

template <class Use>
void CellViews::forEachPart(const Cells& whole, int edge, Use&& use) {
  for (int x = whole.low[0]; x < whole.high[0]; x += edge) {
    for (int y = whole.low[1]; y < whole.high[1]; y += edge) {
      for (int z = whole.low[2]; z < whole.high[2]; z += edge) {
        use(Cells{
            {x, y, z},
            {std::min(x + edge, whole.high[0]), std::min(y + edge, whole.high[1]), std::min(z + edge, whole.high[2])}});
      }
    }
  }
}

/// Which of the eight parts of a whole one is: of two along each axis.
unsigned CellViews::laneOf(const Cells& whole, const Cells& part) {
  const auto along = [&](std::size_t axis) { return part.low[axis] > whole.low[axis] ? 1U : 0U; };
  return 4 * along(0) + 2 * along(1) + along(2);
}

/// How many groups of an edge some cells are.
std::size_t CellViews::groupsOf(const Cells& whole, int edge) {
  const auto along = [&](std::size_t axis) {
    return static_cast<std::size_t>((whole.high[axis] - whole.low[axis] + edge - 1) / edge);
  };
  return along(0) * along(1) * along(2);
}

CellViews::CellViews(const GridSpec& grid, const Pinhole& optics, const Eigen::Isometry3f& T_world_camera)
    : size_(grid.size), width_(optics.width), height_(optics.height), rows_{optics.height, 0} {
  project(grid, optics, T_world_camera);
  forEachPart({{0, 0, 0}, size_}, kHall, [this](const Cells& hall) {
    addEight(hall, kBlock, halls_, [this](const Cells& block) {
      return addEight(block, kPart, blocks_, [this](const Cells& part) {
        return addEight(part, 1, parts_, [this](const Cells& cell) { return boxOf(cell); });
      });
    });
  });
  corners_ = {};
}

/// Adds the boxes of the eight parts of some cells, as `box_of` gives them; gives back that of all.
template <class Boxes, class BoxOf>
DepthBox CellViews::addEight(const Cells& whole, int edge, std::vector<Boxes>& to, BoxOf&& box_of) {
  std::array<DepthBox, 8> boxes;
  std::optional<DepthBox> all;
  forEachPart(whole, edge, [&](const Cells& part) {
    const DepthBox box = box_of(part);
    boxes[laneOf(whole, part)] = box;
    all = all ? unionOf(*all, box) : box;
  });
  to.emplace_back(boxes);
  return *all;
}

void CellViews::project(const GridSpec& grid, const Pinhole& optics, const Eigen::Isometry3f& T_world_camera) {
  const Eigen::Isometry3d T_camera_world = T_world_camera.cast<double>().inverse();
  for (int x = 0; x <= size_[0]; ++x) {
    for (int y = 0; y <= size_[1]; ++y) {
      for (int z = 0; z <= size_[2]; ++z) {
        const Eigen::Vector3d p =
            T_camera_world * Eigen::Vector3d(grid.min[0] + x * grid.resolution(0), grid.min[1] + y * grid.resolution(1),
                                             grid.min[2] + z * grid.resolution(2));
        corners_.push_back({static_cast<float>(optics.fx * p.x() / p.z() + optics.cx),
                            static_cast<float>(optics.fy * p.y() / p.z() + optics.cy), static_cast<float>(p.z())});
      }
    }
  }
}

/// Pixels between which every point of a cell falls, and the depth of the farthest; none when they are not in the
/// image.
DepthBox CellViews::boxOf(const Cells& cell) {
  Corner least{1e9F, 1e9F, 1e9F};
  Corner most{-1e9F, -1e9F, -1e9F};
  for (int corner = 0; corner < 8; ++corner) {
    const int at_x = cell.low[0] + (corner & 1);
    const int at_y = cell.low[1] + (corner >> 1 & 1);
    const int at_z = cell.low[2] + (corner >> 2);
    const Corner& c = corners_[static_cast<std::size_t>((at_x * (size_[1] + 1) + at_y) * (size_[2] + 1) + at_z)];
    least = {std::min(least.column, c.column), std::min(least.row, c.row), std::min(least.depth, c.depth)};
    most = {std::max(most.column, c.column), std::max(most.row, c.row), std::max(most.depth, c.depth)};
  }
  const float left = std::floor(least.column - kPixelSlack);
  const float top = std::floor(least.row - kPixelSlack);
  const float right = std::ceil(most.column + kPixelSlack);
  const float bottom = std::ceil(most.row + kPixelSlack);
  const bool in_image = least.depth >= kNearest && left >= 0.F && top >= 0.F &&
                        right <= static_cast<float>(width_ - 1) && bottom <= static_cast<float>(height_ - 1);
  if (!in_image) {
    return {};
  }
  const float deepest = most.depth + kDepthSlack;
  const DepthBox box{static_cast<std::uint16_t>(left),
                     static_cast<std::uint16_t>(right),
                     static_cast<std::uint16_t>(top),
                     static_cast<std::uint16_t>(bottom),
                     deepest,
                     deepest};
  rows_ = {std::min<std::size_t>(rows_.first, box.top), std::max<std::size_t>(rows_.end, box.bottom + 1U)};
  return box;
}

void CellViews::vote(const DepthWindows& clear, std::uint16_t bit, SeenThrough& seen, CellVotes& votes) const {
  Ballot(*this, clear, bit, seen, votes).castAll();
}

}  // namespace yarm::perception
