#include "crop_kernel.hpp"

#include "lanes_avx2.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace yarm::perception {

namespace {

/// False for NaN.
bool isAbsurd(const float* p, float limit) {
  return std::fabs(p[0]) > limit || std::fabs(p[1]) > limit || std::fabs(p[2]) > limit;
}

/// False for NaN.
bool isSeen(const float* p, float limit) {
  return std::fabs(p[0]) <= limit && std::fabs(p[1]) <= limit && std::fabs(p[2]) <= limit;
}

void add(CropCount& sum, const CropCount& more) {
  sum.finite += more.finite;
  sum.absurd += more.absurd;
}

bool insideBox(const CropSetup& s, const float* w) {
  return w[2] >= s.lo[2] && w[2] <= s.hi[2] && w[0] >= s.lo[0] && w[0] <= s.hi[0] && w[1] >= s.lo[1] && w[1] <= s.hi[1];
}

/// Portable path, any layout.
CropCount cropRowScalar(const CropSetup& s, const CameraCloud& cloud, const std::uint8_t* row, std::size_t count,
                        std::vector<Survivor>& out) {
  CropCount found;
  for (std::size_t i = 0; i < count; ++i, row += cloud.point_step) {
    float p[3];
    std::memcpy(&p[0], row + cloud.x_offset, sizeof(float));
    std::memcpy(&p[1], row + cloud.y_offset, sizeof(float));
    std::memcpy(&p[2], row + cloud.z_offset, sizeof(float));
    found.finite += isSeen(p, s.absurd) ? 1U : 0U;
    if (isAbsurd(p, s.absurd)) {
      ++found.absurd;
      continue;
    }
    float w[3];
    toWorld(s, p, w);
    if (insideBox(s, w) && aboveFloorNoise(s, p[2], w[2])) {
      out.push_back({w[0], w[1], w[2], p[2]});
    }
  }
  return found;
}

#ifdef YARM_HAVE_AVX2_PATH

/// Eight counters go up where the mask is set.
__attribute__((target("avx2"))) inline __m256i countUp(__m256i counters, __m256 mask) {
  return _mm256_sub_epi32(counters, _mm256_castps_si256(mask));
}

__attribute__((target("avx2"))) inline std::size_t total(__m256i counters) {
  alignas(32) std::uint32_t lanes[8];
  _mm256_store_si256(reinterpret_cast<__m256i*>(lanes), counters);
  std::size_t sum = 0;
  for (const std::uint32_t lane : lanes) {
    sum += lane;
  }
  return sum;
}

/// Eight points at a time; x, y, z must be neighbours and 16 bytes readable from x on. Height first: it rules out most.
__attribute__((target("avx2"))) CropCount cropRowAvx2(const CropSetup& s, const CameraCloud& cloud,
                                                      const std::uint8_t* row, std::size_t count,
                                                      std::vector<Survivor>& out) {
  const std::size_t step = cloud.point_step;
  const std::uint8_t* p = row + cloud.x_offset;
  __m256i finite = _mm256_setzero_si256();
  __m256i absurd = _mm256_setzero_si256();
  std::size_t i = 0;
  for (; i + 8 <= count; i += 8, p += 8 * step) {
    const Lanes v = loadEight(p, step);
    const Sorted sorted = sortOut(v, s.absurd);
    finite = countUp(finite, sorted.seen);
    absurd = countUp(absurd, sorted.absurd);
    const __m256 z = rowTimes(s.m[2], v);
    const __m256 high = _mm256_and_ps(within(z, s.lo[2], s.hi[2]), aboveFloor(s, v.z, z));
    const __m256 tall = _mm256_and_ps(sorted.seen, high);
    if (_mm256_movemask_ps(tall) == 0) {
      continue;
    }
    const __m256 x = rowTimes(s.m[0], v);
    const __m256 y = rowTimes(s.m[1], v);
    const __m256 in = _mm256_and_ps(tall, _mm256_and_ps(within(x, s.lo[0], s.hi[0]), within(y, s.lo[1], s.hi[1])));
    unsigned mask = static_cast<unsigned>(_mm256_movemask_ps(in));
    if (mask == 0) {
      continue;
    }
    alignas(32) float xs[8], ys[8], zs[8], ds[8];
    _mm256_store_ps(xs, x);
    _mm256_store_ps(ys, y);
    _mm256_store_ps(zs, z);
    _mm256_store_ps(ds, v.z);
    for (; mask != 0; mask &= mask - 1) {
      const int lane = __builtin_ctz(mask);
      out.push_back({xs[lane], ys[lane], zs[lane], ds[lane]});
    }
  }
  CropCount found{total(finite), total(absurd)};
  add(found, cropRowScalar(s, cloud, row + i * step, count - i, out));
  return found;
}

#endif

}  // namespace

CropSetup makeCropSetup(const MergeParams& params, const Eigen::Isometry3f& T_world_camera) {
  CropSetup s{};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) {
      s.m[r][c] = T_world_camera.matrix()(r, c);
    }
    s.lo[r] = static_cast<float>(params.box_min[static_cast<std::size_t>(r)]);
    s.hi[r] = static_cast<float>(params.box_max[static_cast<std::size_t>(r)]);
  }
  // Noise along a ray that falls by the camera's height over `depth` lifts a floor point by sigma * height / depth.
  const float camera_height = std::max(0.F, T_world_camera.translation().z());
  const float gain = static_cast<float>(params.floor_sigmas) * camera_height;
  s.floor_base = gain > 0.F ? gain * params.noise.base : -std::numeric_limits<float>::infinity();
  s.floor_slope = gain * params.noise.slope;
  s.floor_offset = params.noise.offset;
  s.absurd = static_cast<float>(params.absurd_limit);
  return s;
}

CropCount cropCloud(const CropSetup& setup, const CameraCloud& cloud, std::vector<Survivor>& out, bool force_scalar) {
  const std::size_t packed = cloud.width * cloud.point_step;
  const std::size_t row_step = cloud.row_step == 0 ? packed : cloud.row_step;
  const bool one_run = row_step == packed;
  const std::size_t rows = one_run ? (cloud.width == 0 ? 0 : 1) : cloud.height;
  const std::size_t count = one_run ? cloud.width * cloud.height : cloud.width;
  CropCount found;
  for (std::size_t r = 0; r < rows; ++r) {
    const std::uint8_t* row = cloud.data + r * row_step;
#ifdef YARM_HAVE_AVX2_PATH
    if (!force_scalar && vectorPathFits(cloud)) {
      add(found, cropRowAvx2(setup, cloud, row, count, out));
      continue;
    }
#else
    static_cast<void>(force_scalar);
#endif
    add(found, cropRowScalar(setup, cloud, row, count, out));
  }
  return found;
}

}  // namespace yarm::perception
