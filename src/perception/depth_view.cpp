#include "depth_view.hpp"

#include "lanes_avx2.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace yarm::perception {

namespace {

constexpr float kClear = std::numeric_limits<float>::infinity();
constexpr float kLeastClear = 1e-3F;        // of a reading: 0 means that there was none
constexpr std::size_t kFitStride = 7;       // odd and prime: rows and columns are sampled evenly
constexpr std::size_t kCheckStride = 997;   // about 100 pixels of a 320 x 320 image
constexpr std::size_t kLeastSamples = 100;  // of a fit
constexpr double kLeastSpread = 1e-3;       // variance of the directions

const std::uint8_t* pointAt(const CameraCloud& cloud, std::size_t row, std::size_t column) {
  const std::size_t row_step = cloud.row_step == 0 ? cloud.width * cloud.point_step : cloud.row_step;
  return cloud.data + row * row_step + column * cloud.point_step;
}

Eigen::Vector3f readPoint(const CameraCloud& cloud, const std::uint8_t* point) {
  Eigen::Vector3f p;
  std::memcpy(&p.x(), point + cloud.x_offset, sizeof(float));
  std::memcpy(&p.y(), point + cloud.y_offset, sizeof(float));
  std::memcpy(&p.z(), point + cloud.z_offset, sizeof(float));
  return p;
}

/// Calls `use(row, column, x / z, y / z)` for the finite points of every stride-th pixel.
template <class Use>
void sample(const CameraCloud& cloud, std::size_t stride, Use&& use) {
  for (std::size_t i = 0; i < cloud.width * cloud.height; i += stride) {
    const std::size_t row = i / cloud.width;
    const std::size_t column = i % cloud.width;
    const Eigen::Vector3f p = readPoint(cloud, pointAt(cloud, row, column));
    if (p.allFinite() && p.z() > 0.F) {
      use(static_cast<double>(row), static_cast<double>(column), static_cast<double>(p.x()) / p.z(),
          static_cast<double>(p.y()) / p.z());
    }
  }
}

float clearWithoutReading(const VisibilityParams& params) {
  return params.unread_is_clear ? static_cast<float>(params.range) : 0.F;
}

/// What turns a reading into the depth up to which its ray is clear.
struct Clearing {
  const CropSetup& setup;
  NoiseModel noise;
  float sigmas;
  float grid_bottom;
  float unread;
};

float clearDepth(const Clearing& c, const Eigen::Vector3f& p) {
  if (!(p.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= c.setup.absurd)) {
    return c.unread;
  }
  float world[3];
  toWorld(c.setup, p.data(), world);
  if (world[2] <= c.grid_bottom || !aboveFloorNoise(c.setup, p.z(), world[2])) {
    return kClear;
  }
  return std::max(kLeastClear, p.z() - c.sigmas * c.noise.sigma(p.z()));
}

#ifdef YARM_HAVE_AVX2_PATH

/// The same for a row, eight pixels at a time; how many it did.
__attribute__((target("avx2"))) std::size_t clearRowAvx2(const Clearing& c, const CameraCloud& cloud,
                                                         const std::uint8_t* row, float* out) {
  const std::uint8_t* p = row + cloud.x_offset;
  std::size_t i = 0;
  for (; i + 8 <= cloud.width; i += 8, p += 8 * cloud.point_step) {
    const Lanes v = loadEight(p, cloud.point_step);
    const __m256 seen = sortOut(v, c.setup.absurd).seen;
    const __m256 z = rowTimes(c.setup.m[2], v);
    const __m256 over_grid = _mm256_cmp_ps(z, _mm256_set1_ps(c.grid_bottom), _CMP_GT_OQ);
    const __m256 thing = _mm256_and_ps(over_grid, aboveFloor(c.setup, v.z, z));
    const __m256 d = _mm256_sub_ps(v.z, _mm256_set1_ps(c.noise.offset));
    const __m256 sigma =
        _mm256_add_ps(_mm256_set1_ps(c.noise.base), _mm256_mul_ps(_mm256_set1_ps(c.noise.slope), _mm256_mul_ps(d, d)));
    const __m256 before =
        _mm256_max_ps(_mm256_set1_ps(kLeastClear), _mm256_sub_ps(v.z, _mm256_mul_ps(_mm256_set1_ps(c.sigmas), sigma)));
    const __m256 reading = _mm256_blendv_ps(_mm256_set1_ps(kClear), before, thing);
    _mm256_storeu_ps(out + i, _mm256_blendv_ps(_mm256_set1_ps(c.unread), reading, seen));
  }
  return i;
}

#endif

/// Least squares of y = slope * x + offset.
class Line {
 public:
  void add(double x, double y) {
    n_ += 1.0;
    x_ += x;
    y_ += y;
    xx_ += x * x;
    xy_ += x * y;
  }
  [[nodiscard]] double spread() const { return xx_ / n_ - (x_ / n_) * (x_ / n_); }
  [[nodiscard]] double slope() const { return (xy_ / n_ - (x_ / n_) * (y_ / n_)) / spread(); }
  [[nodiscard]] double offset() const { return y_ / n_ - slope() * (x_ / n_); }

 private:
  double n_{0.0}, x_{0.0}, y_{0.0}, xx_{0.0}, xy_{0.0};
};

bool fitsEvery(const Pinhole& optics, const CameraCloud& cloud, std::size_t stride) {
  double worst = 0.0;
  sample(cloud, stride, [&](double row, double column, double a, double b) {
    const double off =
        std::max(std::abs(optics.fx * a + optics.cx - column), std::abs(optics.fy * b + optics.cy - row));
    worst = std::max(worst, off);
  });
  return worst <= kMostOffPixel;
}

}  // namespace

std::optional<Pinhole> fitPinhole(const CameraCloud& cloud) {
  Line columns;
  Line rows;
  std::size_t samples = 0;
  sample(cloud, kFitStride, [&](double row, double column, double a, double b) {
    columns.add(a, column);
    rows.add(b, row);
    ++samples;
  });
  if (samples < kLeastSamples || columns.spread() < kLeastSpread || rows.spread() < kLeastSpread) {
    return std::nullopt;
  }
  const Pinhole optics{columns.slope(), columns.offset(), rows.slope(), rows.offset(), cloud.width, cloud.height};
  if (!(optics.fx > 0.0 && optics.fy > 0.0) || !fitsEvery(optics, cloud, kFitStride)) {
    return std::nullopt;
  }
  return optics;
}

bool fits(const Pinhole& optics, const CameraCloud& cloud) {
  return cloud.width == optics.width && cloud.height == optics.height && fitsEvery(optics, cloud, kCheckStride);
}

void clearDepths(const CameraCloud& cloud, const CropSetup& setup, const MergeParams& merge,
                 const VisibilityParams& params, float grid_bottom, const Rows& rows, std::vector<float>& clear,
                 bool force_scalar) {
  clear.resize(cloud.width * cloud.height + kClearPadding);
  const Clearing clearing{setup, merge.noise, static_cast<float>(params.noise_sigmas), grid_bottom,
                          clearWithoutReading(params)};
  for (std::size_t row = rows.first; row < std::min(rows.end, cloud.height); ++row) {
    float* out = clear.data() + row * cloud.width;
    std::size_t done = 0;
#ifdef YARM_HAVE_AVX2_PATH
    if (!force_scalar && vectorPathFits(cloud)) {
      done = clearRowAvx2(clearing, cloud, pointAt(cloud, row, 0), out);
    }
#else
    static_cast<void>(force_scalar);
#endif
    for (; done < cloud.width; ++done) {
      out[done] = clearDepth(clearing, readPoint(cloud, pointAt(cloud, row, done)));
    }
  }
}

void clearDepthsOfEmptyCell(const Pinhole& optics, const Eigen::Isometry3f& T_world_camera,
                            const VisibilityParams& params, std::vector<float>& clear) {
  clear.assign(optics.width * optics.height + kClearPadding, clearWithoutReading(params));
  const Eigen::Vector3f down = -T_world_camera.linear().row(2);
  const float height = T_world_camera.translation().z();
  for (std::size_t row = 0; row < optics.height; ++row) {
    for (std::size_t column = 0; column < optics.width; ++column) {
      const Eigen::Vector3f ray(static_cast<float>((static_cast<double>(column) - optics.cx) / optics.fx),
                                static_cast<float>((static_cast<double>(row) - optics.cy) / optics.fy), 1.F);
      const float falls = down.dot(ray);
      if (falls > 0.F && height <= falls * static_cast<float>(params.range)) {
        clear[row * optics.width + column] = kClear;
      }
    }
  }
}

}  // namespace yarm::perception
