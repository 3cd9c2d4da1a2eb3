// Eight points of a cloud at a time, where the processor has AVX2: what the passes over raw points share.
#pragma once

#include "crop_kernel.hpp"

#include "yarm/perception/types.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#define YARM_HAVE_AVX2_PATH 1
#include <immintrin.h>
#endif

#ifdef YARM_HAVE_AVX2_PATH

namespace yarm::perception {

/// Whether the processor has AVX2.
inline bool hasAvx2() {
  static const bool has = __builtin_cpu_supports("avx2") != 0;
  return has;
}

/// Whether eight points of a cloud can be loaded at a time: x, y, z are neighbours and 16 bytes readable from x on.
inline bool vectorPathFits(const CameraCloud& cloud) {
  return hasAvx2() && cloud.y_offset == cloud.x_offset + 4 && cloud.z_offset == cloud.x_offset + 8 &&
         cloud.x_offset + 16 <= cloud.point_step;
}

/// Eight points as three vectors.
struct Lanes {
  __m256 x, y, z;
};

__attribute__((target("avx2"))) inline __m256 loadPair(const std::uint8_t* low, const std::uint8_t* high) {
  const __m128 a = _mm_loadu_ps(reinterpret_cast<const float*>(low));
  const __m128 b = _mm_loadu_ps(reinterpret_cast<const float*>(high));
  return _mm256_insertf128_ps(_mm256_castps128_ps256(a), b, 1);
}

/// Eight points from `p` on, `step` bytes apart.
__attribute__((target("avx2"))) inline Lanes loadEight(const std::uint8_t* p, std::size_t step) {
  const __m256 r0 = loadPair(p, p + 4 * step);
  const __m256 r1 = loadPair(p + step, p + 5 * step);
  const __m256 r2 = loadPair(p + 2 * step, p + 6 * step);
  const __m256 r3 = loadPair(p + 3 * step, p + 7 * step);
  const __m256 lo01 = _mm256_unpacklo_ps(r0, r1);
  const __m256 lo23 = _mm256_unpacklo_ps(r2, r3);
  const __m256 hi01 = _mm256_unpackhi_ps(r0, r1);
  const __m256 hi23 = _mm256_unpackhi_ps(r2, r3);
  return {_mm256_shuffle_ps(lo01, lo23, 0x44), _mm256_shuffle_ps(lo01, lo23, 0xEE),
          _mm256_shuffle_ps(hi01, hi23, 0x44)};
}

/// A coordinate of eight points in the world; `row`: of world <- camera.
__attribute__((target("avx2"))) inline __m256 rowTimes(const float* row, const Lanes& v) {
  const __m256 zt = _mm256_add_ps(_mm256_mul_ps(v.z, _mm256_set1_ps(row[2])), _mm256_set1_ps(row[3]));
  const __m256 yz = _mm256_add_ps(_mm256_mul_ps(v.y, _mm256_set1_ps(row[1])), zt);
  return _mm256_add_ps(_mm256_mul_ps(v.x, _mm256_set1_ps(row[0])), yz);
}

__attribute__((target("avx2"))) inline __m256 within(__m256 v, float lo, float hi) {
  return _mm256_and_ps(_mm256_cmp_ps(v, _mm256_set1_ps(lo), _CMP_GE_OQ),
                       _mm256_cmp_ps(v, _mm256_set1_ps(hi), _CMP_LE_OQ));
}

/// Mask of the points above the floor's noise.
__attribute__((target("avx2"))) inline __m256 aboveFloor(const CropSetup& s, __m256 depth, __m256 height) {
  const __m256 d = _mm256_sub_ps(depth, _mm256_set1_ps(s.floor_offset));
  const __m256 margin =
      _mm256_add_ps(_mm256_set1_ps(s.floor_base), _mm256_mul_ps(_mm256_set1_ps(s.floor_slope), _mm256_mul_ps(d, d)));
  return _mm256_cmp_ps(_mm256_mul_ps(height, depth), margin, _CMP_GE_OQ);
}

/// Masks of the points that are seen and of those that are absurd; neither where a coordinate is NaN and none absurd.
struct Sorted {
  __m256 seen, absurd;
};

__attribute__((target("avx2"))) inline Sorted sortOut(const Lanes& v, float limit) {
  const __m256 magnitude = _mm256_castsi256_ps(_mm256_set1_epi32(0x7FFFFFFF));
  const __m256 bound = _mm256_set1_ps(limit);
  const __m256 x = _mm256_and_ps(v.x, magnitude);
  const __m256 y = _mm256_and_ps(v.y, magnitude);
  const __m256 z = _mm256_and_ps(v.z, magnitude);
  const __m256 in_xy = _mm256_and_ps(_mm256_cmp_ps(x, bound, _CMP_LE_OQ), _mm256_cmp_ps(y, bound, _CMP_LE_OQ));
  const __m256 out_xy = _mm256_or_ps(_mm256_cmp_ps(x, bound, _CMP_GT_OQ), _mm256_cmp_ps(y, bound, _CMP_GT_OQ));
  return {_mm256_and_ps(in_xy, _mm256_cmp_ps(z, bound, _CMP_LE_OQ)),
          _mm256_or_ps(out_xy, _mm256_cmp_ps(z, bound, _CMP_GT_OQ))};
}

}  // namespace yarm::perception

#endif
