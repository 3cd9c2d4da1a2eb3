#include "depth_windows.hpp"

#include "lanes_avx2.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>

namespace yarm::perception {

namespace {

#ifdef YARM_HAVE_AVX2_PATH
#define YARM_ALWAYS_INLINE __attribute__((always_inline)) inline  // also into functions for other processors
#else
#define YARM_ALWAYS_INLINE inline
#endif

constexpr DepthKey kUnread = 0x7F800001;   // farther than any reading: the bits of +inf, and the lowest
constexpr DepthKey kNothing = 0x7FFFFFFE;  // of no pixel

/// Of a clear depth, metres; its last bit is lost (2e-7 of it).
YARM_ALWAYS_INLINE DepthKey keyOf(float depth) {
  DepthKey bits = 0;
  std::memcpy(&bits, &depth, sizeof bits);
  return depth > 0.F ? bits & ~1 : kUnread;
}

/// Of two windows together.
YARM_ALWAYS_INLINE DepthKey nearer(DepthKey a, DepthKey b) {
  return std::min(a, b) | ((a | b) & 1);
}

/// Windows of one row of the image.
struct RowOf {
  DepthKey* nearest;
  float* farthest;
};

RowOf rowOf(DepthWindows::Level& level, std::size_t at) {
  return {level.nearest.data() + at, level.farthest.data() + at};
}

/// Windows of 1 row and 2 columns.
YARM_ALWAYS_INLINE void joinPixels(const float* clear, std::size_t count, const RowOf& out) {
  DepthKey* __restrict nearest = out.nearest;
  float* __restrict farthest = out.farthest;
  for (std::size_t i = 0; i < count; ++i) {
    nearest[i] = nearer(keyOf(clear[i]), keyOf(clear[i + 1]));
    farthest[i] = std::max(clear[i], clear[i + 1]);
  }
}

/// Windows of 2 x 2 pixels from the pairs of two rows.
YARM_ALWAYS_INLINE void joinPairs(const RowOf& a, const RowOf& b, std::size_t count, const RowOf& out) {
  DepthKey* __restrict nearest = out.nearest;
  float* __restrict farthest = out.farthest;
  for (std::size_t i = 0; i < count; ++i) {
    nearest[i] = nearer(a.nearest[i], b.nearest[i]);
    farthest[i] = std::max(a.farthest[i], b.farthest[i]);
  }
}

/// Windows of twice the edge from those of two rows, `edge` apart.
YARM_ALWAYS_INLINE void joinSquares(const RowOf& a, const RowOf& b, std::size_t edge, std::size_t count,
                                    const RowOf& out) {
  DepthKey* __restrict nearest = out.nearest;
  float* __restrict farthest = out.farthest;
  for (std::size_t i = 0; i < count; ++i) {
    nearest[i] = nearer(nearer(a.nearest[i], b.nearest[i]), nearer(a.nearest[i + edge], b.nearest[i + edge]));
    farthest[i] =
        std::max(std::max(a.farthest[i], b.farthest[i]), std::max(a.farthest[i + edge], b.farthest[i + edge]));
  }
}

/// Where the windows of an image go, from its first row on; `pairs`: of two rows to work with.
struct Windows {
  std::array<RowOf, 2> pairs;
  std::array<RowOf, kWindowSizes> squares;
};

YARM_ALWAYS_INLINE void joinRows(const float* clear, std::size_t width, const Rows& rows, const Windows& out) {
  const auto at = [width](const RowOf& all, std::size_t row) {
    return RowOf{all.nearest + row * width, all.farthest + row * width};
  };
  for (std::size_t row = rows.first; row < rows.end; ++row) {
    const RowOf& now = out.pairs[row % 2];
    joinPixels(clear + row * width, width, now);
    if (row >= rows.first + 1) {
      joinPairs(out.pairs[(row + 1) % 2], now, width, at(out.squares[0], row - 1));
    }
    std::size_t edge = 2;
    for (std::size_t level = 1; level < kWindowSizes && row + 1 >= rows.first + 2 * edge; ++level, edge *= 2) {
      const std::size_t top = row + 1 - 2 * edge;
      joinSquares(at(out.squares[level - 1], top), at(out.squares[level - 1], top + edge), edge, width,
                  at(out.squares[level], top));
    }
  }
}

/// Whether it is also asked for the farthest depths.
template <class Boxes>
constexpr bool kGroups = std::is_same_v<Boxes, EightGroups>;

template <class Boxes>
EightFound look(const DepthWindows::Level& windows, std::size_t width, const Boxes& boxes) {
  EightFound found{0, 0, 0, 0};
  for (std::size_t k = 0; k < 8; ++k) {
    DepthKey nearest = kNothing;
    float farthest = 0.F;
    int row = boxes.top[k];
    for (int i = 0; i < boxes.windows_down; ++i, row = std::min<int>(row + boxes.edge, boxes.last_row[k])) {
      int column = boxes.left[k];
      for (int j = 0; j < boxes.windows_across; ++j) {
        const std::size_t at = static_cast<std::size_t>(row) * width + static_cast<std::size_t>(column);
        nearest = nearer(nearest, windows.nearest[at]);
        if constexpr (kGroups<Boxes>) {
          farthest = std::max(farthest, windows.farthest[at]);
        }
        column = std::min<int>(column + boxes.edge, boxes.last_column[k]);
      }
    }
    found.before |= static_cast<unsigned>((nearest & ~1) < boxes.deepest[k]) << k;
    found.missing |= static_cast<unsigned>(nearest & 1) << k;
    if constexpr (kGroups<Boxes>) {
      found.beyond |= static_cast<unsigned>(farthest >= boxes.shallowest[k]) << k;
      found.read |= static_cast<unsigned>(farthest > 0.F) << k;
    }
  }
  return found;
}

#ifdef YARM_HAVE_AVX2_PATH

__attribute__((target("avx2"))) void joinRowsAvx2(const float* clear, std::size_t width, const Rows& rows,
                                                  const Windows& out) {
  joinRows(clear, width, rows, out);
}

__attribute__((target("avx2"))) inline __m256i eightOf(const std::array<std::uint16_t, 8>& values) {
  return _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(values.data())));
}

__attribute__((target("avx2"))) inline unsigned signsOf(__m256 values) {
  return static_cast<unsigned>(_mm256_movemask_ps(values));
}

template <class Boxes>
__attribute__((target("avx2"))) EightFound lookAvx2(const DepthWindows::Level& windows, std::size_t width,
                                                    const Boxes& boxes) {
  const __m256i one = _mm256_set1_epi32(1);
  const __m256i edge = _mm256_set1_epi32(boxes.edge);
  const __m256i left = eightOf(boxes.left);
  const __m256i last_column = eightOf(boxes.last_column);
  const __m256i last_row = eightOf(boxes.last_row);
  __m256i row = eightOf(boxes.top);
  __m256i nearest = _mm256_set1_epi32(kNothing);
  __m256 farthest = _mm256_setzero_ps();
  for (int i = 0; i < boxes.windows_down; ++i) {
    const __m256i first = _mm256_mullo_epi32(row, _mm256_set1_epi32(static_cast<int>(width)));
    __m256i column = left;
    for (int j = 0; j < boxes.windows_across; ++j) {
      const __m256i at = _mm256_add_epi32(first, column);
      const __m256i key = _mm256_i32gather_epi32(windows.nearest.data(), at, sizeof(DepthKey));
      const __m256i misses = _mm256_and_si256(_mm256_or_si256(nearest, key), one);
      nearest = _mm256_or_si256(_mm256_min_epi32(nearest, key), misses);
      if constexpr (kGroups<Boxes>) {
        farthest = _mm256_max_ps(farthest, _mm256_i32gather_ps(windows.farthest.data(), at, sizeof(float)));
      }
      column = _mm256_min_epi32(_mm256_add_epi32(column, edge), last_column);
    }
    row = _mm256_min_epi32(_mm256_add_epi32(row, edge), last_row);
  }
  const __m256i deepest = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(boxes.deepest.data()));
  EightFound found{signsOf(_mm256_castsi256_ps(_mm256_cmpgt_epi32(deepest, _mm256_andnot_si256(one, nearest)))),
                   signsOf(_mm256_castsi256_ps(_mm256_slli_epi32(nearest, 31))), 0, 0};
  if constexpr (kGroups<Boxes>) {
    found.beyond = signsOf(_mm256_cmp_ps(farthest, _mm256_loadu_ps(boxes.shallowest.data()), _CMP_GE_OQ));
    found.read = signsOf(_mm256_cmp_ps(farthest, _mm256_setzero_ps(), _CMP_GT_OQ));
  }
  return found;
}

#endif

}  // namespace

EightBoxes::EightBoxes(const std::array<DepthBox, 8>& boxes) {
  int least = std::numeric_limits<int>::max();
  int most_across = 0;
  int most_down = 0;
  for (const DepthBox& box : boxes) {
    if (!box.isNone()) {
      least = std::min({least, box.right - box.left + 1, box.bottom - box.top + 1});
      most_across = std::max(most_across, box.right - box.left + 1);
      most_down = std::max(most_down, box.bottom - box.top + 1);
    }
  }
  while (2 * edge <= least && level + 1U < kWindowSizes) {
    edge = static_cast<std::uint8_t>(2 * edge);
    ++level;
  }
  windows_across = static_cast<std::uint16_t>((most_across + edge - 1) / edge);
  windows_down = static_cast<std::uint16_t>((most_down + edge - 1) / edge);
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    const DepthBox& box = boxes[k];
    if (!box.isNone()) {
      taken = static_cast<std::uint8_t>(taken | 1U << k);
      left[k] = box.left;
      top[k] = box.top;
      last_column[k] = static_cast<std::uint16_t>(box.right + 1 - edge);
      last_row[k] = static_cast<std::uint16_t>(box.bottom + 1 - edge);
      deepest[k] = keyOf(box.deepest);
    }
  }
}

EightGroups::EightGroups(const std::array<DepthBox, 8>& boxes) : EightBoxes(boxes) {
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    shallowest[k] = boxes[k].shallowest;
  }
}

void DepthWindows::take(const std::vector<float>& clear, std::size_t width, const Rows& rows, bool force_scalar) {
  width_ = width;
  const auto resize = [](Level& level, std::size_t size) {
    level.nearest.resize(size);
    level.farthest.resize(size);
  };
  resize(pairs_, 2 * width);
  Windows windows{{rowOf(pairs_, 0), rowOf(pairs_, width)}, {}};
  for (std::size_t i = 0; i < kWindowSizes; ++i) {
    resize(squares_[i], clear.size());
    windows.squares[i] = rowOf(squares_[i], 0);
  }
  auto join = &joinRows;
  look_ = &look<EightBoxes>;
  look_at_groups_ = &look<EightGroups>;
#ifdef YARM_HAVE_AVX2_PATH
  if (hasAvx2() && !force_scalar) {
    join = &joinRowsAvx2;
    look_ = &lookAvx2<EightBoxes>;
    look_at_groups_ = &lookAvx2<EightGroups>;
  }
#else
  static_cast<void>(force_scalar);
#endif
  join(clear.data(), width, rows, windows);
}

}  // namespace yarm::perception
