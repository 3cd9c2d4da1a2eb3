#include "cell_views.hpp"

#include "lanes_avx2.hpp"

#include <algorithm>
#include <cmath>

namespace yarm::perception {

namespace {

constexpr int kBlock = 4;              // cells along an edge of a block
constexpr float kNearest = 0.05F;      // what comes nearer to the camera's plane than this is not in its image, metres
constexpr float kPixelSlack = 0.01F;   // of rounding, pixels
constexpr float kDepthSlack = 0.001F;  // of rounding, metres

using View = CellViews::View;

/// Cells from `low` to before `high`.
struct Block {
  std::array<int, 3> low, high;
};

template <class Use>
void forEachBlock(const std::array<int, 3>& size, Use&& use) {
  for (int x = 0; x < size[0]; x += kBlock) {
    for (int y = 0; y < size[1]; y += kBlock) {
      for (int z = 0; z < size[2]; z += kBlock) {
        use(Block{{x, y, z},
                  {std::min(x + kBlock, size[0]), std::min(y + kBlock, size[1]), std::min(z + kBlock, size[2])}});
      }
    }
  }
}

template <class Use>
void forEachCell(const Block& block, Use&& use) {
  for (int x = block.low[0]; x < block.high[0]; ++x) {
    for (int y = block.low[1]; y < block.high[1]; ++y) {
      for (int z = block.low[2]; z < block.high[2]; ++z) {
        use(x, y, z);
      }
    }
  }
}

enum class Verdict { kThrough, kBehind, kUnread };

Verdict look(const View& view, const float* clear, std::size_t width) {
  bool blocked = view.right < view.left;
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

/// The same, eight pixels at a time; kClearPadding floats behind the last pixel must be readable.
__attribute__((target("avx2"))) Verdict lookAvx2(const View& view, const float* clear, std::size_t width) {
  const __m256 deepest = _mm256_set1_ps(view.deepest);
  __m256 blocked = _mm256_setzero_ps();
  for (int first = view.left; first <= view.right; first += 8) {
    const __m256i column = _mm256_add_epi32(_mm256_set1_epi32(first), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    const __m256 outside = _mm256_castsi256_ps(_mm256_cmpgt_epi32(column, _mm256_set1_epi32(view.right)));
    const float* pixels = clear + view.top * width + static_cast<std::size_t>(first);
    for (int row = view.top; row <= view.bottom; ++row, pixels += width) {
      const __m256 depth = _mm256_loadu_ps(pixels);
      const __m256 ends = _mm256_andnot_ps(outside, _mm256_cmp_ps(depth, deepest, _CMP_LT_OQ));
      blocked = _mm256_or_ps(blocked, ends);
      if (_mm256_movemask_ps(_mm256_and_ps(ends, _mm256_cmp_ps(depth, _mm256_setzero_ps(), _CMP_GT_OQ))) != 0) {
        return Verdict::kBehind;
      }
    }
  }
  return view.right < view.left || _mm256_movemask_ps(blocked) != 0 ? Verdict::kUnread : Verdict::kThrough;
}

#endif

}  // namespace

CellViews::CellViews(const GridSpec& grid, const Pinhole& optics, const Eigen::Isometry3f& T_world_camera)
    : size_(grid.size), width_(optics.width), height_(optics.height) {
  project(grid, optics, T_world_camera);
  cells_.reserve(grid.count());
  forEachBlock(size_, [this](const Block& block) {
    blocks_.push_back(viewOf(block.low, block.high));
    forEachCell(block, [this](int x, int y, int z) { cells_.push_back(viewOf({x, y, z}, {x + 1, y + 1, z + 1})); });
  });
  corners_ = {};
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

CellViews::View CellViews::viewOf(const std::array<int, 3>& low, const std::array<int, 3>& high) const {
  Corner least{1e9F, 1e9F, 1e9F};
  Corner most{-1e9F, -1e9F, -1e9F};
  for (int corner = 0; corner < 8; ++corner) {
    const int x = (corner & 1) != 0 ? high[0] : low[0];
    const int y = (corner & 2) != 0 ? high[1] : low[1];
    const int z = (corner & 4) != 0 ? high[2] : low[2];
    const Corner& c = corners_[static_cast<std::size_t>((x * (size_[1] + 1) + y) * (size_[2] + 1) + z)];
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

void CellViews::vote(const std::vector<float>& clear, std::uint16_t bit, CellVotes& votes, bool force_scalar) const {
  Verdict (*judge)(const View&, const float*, std::size_t) = &look;
#ifdef YARM_HAVE_AVX2_PATH
  judge = hasAvx2() && !force_scalar ? &lookAvx2 : judge;
#else
  static_cast<void>(force_scalar);
#endif
  const View* block_view = blocks_.data();
  const View* cell_view = cells_.data();
  forEachBlock(size_, [&](const Block& block) {
    const bool through = judge(*block_view++, clear.data(), width_) == Verdict::kThrough;
    forEachCell(block, [&](int x, int y, int z) {
      const Verdict verdict = through ? Verdict::kThrough : judge(*cell_view, clear.data(), width_);
      const auto cell = static_cast<std::size_t>((x * size_[1] + y) * size_[2] + z);
      ++cell_view;
      if (verdict == Verdict::kThrough) {
        votes.through[cell] |= bit;
      } else if (verdict == Verdict::kBehind) {
        votes.behind[cell] |= bit;
      }
    });
  });
}

}  // namespace yarm::perception
