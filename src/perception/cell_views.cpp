#include "cell_views.hpp"

#include "lanes_avx2.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace yarm::perception {

namespace {

constexpr int kBlock = 4;              // cells along an edge of a block
constexpr int kPart = 2;               // and of a part of one
constexpr float kNearest = 0.05F;      // what comes nearer to the camera's plane than this is not in its image, metres
constexpr float kPixelSlack = 0.01F;   // of rounding, pixels
constexpr float kDepthSlack = 0.001F;  // of rounding, metres
constexpr float kFar = std::numeric_limits<float>::infinity();

using View = CellViews::View;
using Group = CellViews::Group;

enum class Verdict { kThrough, kBehind, kUnread, kMixed };

bool isNone(const View& view) {
  return view.right < view.left;
}

/// Whether any pixel of a group has a clear depth that is less than its deepest, as much as its shallowest, none, some.
struct Depths {
  bool nearer, beyond, unread, read;
};

/// What holds for every cell of a group.
Verdict ofAll(const Depths& any) {
  if (!any.nearer) {
    return Verdict::kThrough;
  }
  if (!any.unread && !any.beyond) {
    return Verdict::kBehind;
  }
  return any.read ? Verdict::kMixed : Verdict::kUnread;
}

Verdict lookAtAll(const Group& group, const float* clear, std::size_t width) {
  const View& view = group.view;
  float least = kFar;
  float greatest = 0.F;
  for (std::size_t row = view.top; row <= view.bottom; ++row) {
    for (std::size_t column = view.left; column <= view.right; ++column) {
      least = std::min(least, clear[row * width + column]);
      greatest = std::max(greatest, clear[row * width + column]);
    }
  }
  Depths any{};
  any.nearer = least < view.deepest;
  any.beyond = greatest >= group.shallowest;
  any.unread = least <= 0.F;
  any.read = greatest > 0.F;
  return ofAll(any);
}

Verdict look(const View& view, const float* clear, std::size_t width) {
  bool blocked = false;
  for (std::size_t row = view.top; row <= view.bottom; ++row) {
    for (std::size_t column = view.left; column <= view.right; ++column) {
      const float depth = clear[row * width + column];
      if (depth < view.deepest && depth > 0.F) {
        return Verdict::kBehind;
      }
      blocked = blocked || depth < view.deepest;
    }
  }
  return blocked ? Verdict::kUnread : Verdict::kThrough;
}

#ifdef YARM_HAVE_AVX2_PATH

/// Mask of those of eight columns from `first` on that are in a view.
__attribute__((target("avx2"))) inline __m256 columnsIn(const View& view, int first) {
  const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  return _mm256_castsi256_ps(_mm256_cmpgt_epi32(_mm256_set1_epi32(view.right - first + 1), lane));
}

/// Eight pixels at a time; kClearPadding floats behind the last pixel must be readable.
__attribute__((target("avx2"))) Verdict lookAtAllAvx2(const Group& group, const float* clear, std::size_t width) {
  const View& view = group.view;
  const __m256 far = _mm256_set1_ps(kFar);
  __m256 least = far;
  __m256 greatest = _mm256_setzero_ps();
  for (int first = view.left; first <= view.right; first += 8) {
    const __m256 in = columnsIn(view, first);
    const float* pixels = clear + view.top * width + static_cast<std::size_t>(first);
    for (int row = view.top; row <= view.bottom; ++row, pixels += width) {
      const __m256 depth = _mm256_loadu_ps(pixels);
      least = _mm256_min_ps(least, _mm256_blendv_ps(far, depth, in));
      greatest = _mm256_max_ps(greatest, _mm256_and_ps(depth, in));
    }
  }
  const auto any = [](int mask) { return mask != 0; };
  const __m256 zero = _mm256_setzero_ps();
  const __m256 shallowest = _mm256_set1_ps(group.shallowest);
  return ofAll({any(_mm256_movemask_ps(_mm256_cmp_ps(least, _mm256_set1_ps(view.deepest), _CMP_LT_OQ))),
                any(_mm256_movemask_ps(_mm256_cmp_ps(greatest, shallowest, _CMP_GE_OQ))),
                any(_mm256_movemask_ps(_mm256_cmp_ps(least, zero, _CMP_LE_OQ))),
                any(_mm256_movemask_ps(_mm256_cmp_ps(greatest, zero, _CMP_GT_OQ)))});
}

__attribute__((target("avx2"))) Verdict lookAvx2(const View& view, const float* clear, std::size_t width) {
  const __m256 deepest = _mm256_set1_ps(view.deepest);
  __m256 blocked = _mm256_setzero_ps();
  for (int first = view.left; first <= view.right; first += 8) {
    const __m256 in = columnsIn(view, first);
    const float* pixels = clear + view.top * width + static_cast<std::size_t>(first);
    for (int row = view.top; row <= view.bottom; ++row, pixels += width) {
      const __m256 depth = _mm256_loadu_ps(pixels);
      const __m256 ends = _mm256_and_ps(in, _mm256_cmp_ps(depth, deepest, _CMP_LT_OQ));
      blocked = _mm256_or_ps(blocked, ends);
      if (_mm256_movemask_ps(_mm256_and_ps(ends, _mm256_cmp_ps(depth, _mm256_setzero_ps(), _CMP_GT_OQ))) != 0) {
        return Verdict::kBehind;
      }
    }
  }
  return _mm256_movemask_ps(blocked) != 0 ? Verdict::kUnread : Verdict::kThrough;
}

#endif

}  // namespace

/// One camera's votes on one set.
class CellViews::Ballot {
 public:
  Ballot(const CellViews& views, const float* clear, std::uint16_t bit, CellVotes& votes, bool force_scalar)
      : views_(views), clear_(clear), bit_(bit), votes_(votes) {
#ifdef YARM_HAVE_AVX2_PATH
    if (hasAvx2() && !force_scalar) {
      look_ = &lookAvx2;
      look_at_all_ = &lookAtAllAvx2;
    }
#else
    static_cast<void>(force_scalar);
#endif
  }

  [[nodiscard]] Verdict of(const Group& group) const {
    return isNone(group.view) ? Verdict::kMixed : look_at_all_(group, clear_, views_.width_);
  }

  void cast(Verdict verdict, const Cells& cells) {
    if (verdict == Verdict::kUnread) {
      return;
    }
    std::vector<std::uint16_t>& mine = verdict == Verdict::kThrough ? votes_.through : votes_.behind;
    for (int x = cells.low[0]; x < cells.high[0]; ++x) {
      for (int y = cells.low[1]; y < cells.high[1]; ++y) {
        std::uint16_t* column = &mine[indexOf(x, y, 0)];
        for (int z = cells.low[2]; z < cells.high[2]; ++z) {
          column[z] |= bit_;
        }
      }
    }
  }

  /// Each of the cells on its own; `view`: of the first.
  void castEach(const View* view, const Cells& cells) {
    for (int x = cells.low[0]; x < cells.high[0]; ++x) {
      for (int y = cells.low[1]; y < cells.high[1]; ++y) {
        for (int z = cells.low[2]; z < cells.high[2]; ++z, ++view) {
          const Verdict verdict = isNone(*view) ? Verdict::kUnread : look_(*view, clear_, views_.width_);
          votes_.through[indexOf(x, y, z)] |= verdict == Verdict::kThrough ? bit_ : std::uint16_t{0};
          votes_.behind[indexOf(x, y, z)] |= verdict == Verdict::kBehind ? bit_ : std::uint16_t{0};
        }
      }
    }
  }

 private:
  [[nodiscard]] std::size_t indexOf(int x, int y, int z) const {
    return static_cast<std::size_t>((x * views_.size_[1] + y) * views_.size_[2] + z);
  }

  const CellViews& views_;
  const float* clear_;
  std::uint16_t bit_;
  CellVotes& votes_;
  Verdict (*look_)(const View&, const float*, std::size_t){&look};
  Verdict (*look_at_all_)(const Group&, const float*, std::size_t){&lookAtAll};
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

CellViews::CellViews(const GridSpec& grid, const Pinhole& optics, const Eigen::Isometry3f& T_world_camera)
    : size_(grid.size), width_(optics.width), height_(optics.height), rows_{optics.height, 0} {
  project(grid, optics, T_world_camera);
  cells_.reserve(grid.count());
  forEachPart({{0, 0, 0}, size_}, kBlock, [this](const Cells& block) { addBlock(block); });
  for (const View& view : cells_) {
    if (!isNone(view)) {
      rows_ = {std::min<std::size_t>(rows_.first, view.top), std::max<std::size_t>(rows_.end, view.bottom + 1U)};
    }
  }
  corners_ = {};
}

void CellViews::addBlock(const Cells& block) {
  const std::size_t first_of_block = cells_.size();
  forEachPart(block, kPart, [this](const Cells& part) {
    const std::size_t first = cells_.size();
    forEachPart(part, 1,
                [this](const Cells& cell) { cells_.push_back(viewOf(cell.low[0], cell.low[1], cell.low[2])); });
    parts_.push_back(groupOf(first));
  });
  blocks_.push_back(groupOf(first_of_block));
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

CellViews::View CellViews::viewOf(int x, int y, int z) const {
  Corner least{1e9F, 1e9F, 1e9F};
  Corner most{-1e9F, -1e9F, -1e9F};
  for (int corner = 0; corner < 8; ++corner) {
    const int at_x = x + (corner & 1);
    const int at_y = y + (corner >> 1 & 1);
    const int at_z = z + (corner >> 2);
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
  return {static_cast<std::uint16_t>(left), static_cast<std::uint16_t>(right), static_cast<std::uint16_t>(top),
          static_cast<std::uint16_t>(bottom), most.depth + kDepthSlack};
}

/// The cells from `first_cell` to the last one there is so far.
CellViews::Group CellViews::groupOf(std::size_t first_cell) const {
  Group group{cells_[first_cell], cells_[first_cell].deepest};
  View& all = group.view;
  for (std::size_t i = first_cell; i < cells_.size(); ++i) {
    const View& view = cells_[i];
    if (isNone(view)) {
      return {};
    }
    all = {std::min(all.left, view.left), std::max(all.right, view.right), std::min(all.top, view.top),
           std::max(all.bottom, view.bottom), std::max(all.deepest, view.deepest)};
    group.shallowest = std::min(group.shallowest, view.deepest);
  }
  return group;
}

void CellViews::vote(const std::vector<float>& clear, std::uint16_t bit, CellVotes& votes, bool force_scalar) const {
  Ballot ballot(*this, clear.data(), bit, votes, force_scalar);
  const auto count = [](const Cells& cells, int edge) {
    const auto along = [&](std::size_t axis) { return (cells.high[axis] - cells.low[axis] + edge - 1) / edge; };
    return along(0) * along(1) * along(2);
  };
  const Group* block_view = blocks_.data();
  const Group* part_view = parts_.data();
  const View* cell_view = cells_.data();
  forEachPart({{0, 0, 0}, size_}, kBlock, [&](const Cells& block) {
    const Verdict of_block = ballot.of(*block_view++);
    if (of_block != Verdict::kMixed) {
      ballot.cast(of_block, block);
      part_view += count(block, kPart);
      cell_view += count(block, 1);
      return;
    }
    forEachPart(block, kPart, [&](const Cells& part) {
      const Verdict of_part = ballot.of(*part_view++);
      if (of_part != Verdict::kMixed) {
        ballot.cast(of_part, part);
      } else {
        ballot.castEach(cell_view, part);
      }
      cell_view += count(part, 1);
    });
  });
}

}  // namespace yarm::perception
