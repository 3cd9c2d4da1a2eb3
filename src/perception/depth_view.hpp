// A camera's cloud as an image: its optics, and how far each pixel says that its ray is clear.
#pragma once

#include "crop_kernel.hpp"

#include "yarm/perception/merge.hpp"
#include "yarm/perception/visibility.hpp"

#include <optional>
#include <vector>

namespace yarm::perception {

/// Optics of a pinhole camera: column = fx * x / z + cx and row = fy * y / z + cy at the centres of the pixels.
struct Pinhole {
  double fx{0.0};
  double cx{0.0};
  double fy{0.0};
  double cy{0.0};
  std::size_t width{0};
  std::size_t height{0};
};

/// Rows of an image from `first` to before `end`; none where `end` <= `first`.
struct Rows {
  std::size_t first{0};
  std::size_t end{0};
};

/// Most that a point may lie from the centre of its own pixel, pixels.
constexpr double kMostOffPixel = 0.25;

/// Optics that a cloud's finite points show (least squares over every seventh pixel); nothing when these are too few or
/// too close to tell, or when the points are not where a pinhole camera's pixels look.
[[nodiscard]] std::optional<Pinhole> fitPinhole(const CameraCloud& cloud);

/// Whether a cloud is an image of these optics; looks at some hundred pixels.
[[nodiscard]] bool fits(const Pinhole& optics, const CameraCloud& cloud);

/// Floats behind the last pixel of clear depths, which mean nothing: windows that begin at the last pixels reach there.
constexpr std::size_t kClearPadding = 8;

/// For each pixel of `rows`, row by row, the depth up to which its ray is clear, metres: a reading less its noise; +inf
/// where the floor was seen; 0 without a reading, or the range when VisibilityParams::unread_is_clear. Other rows have
/// their places in `clear` and mean nothing. `force_scalar` keeps the portable path, for the tests.
void clearDepths(const CameraCloud& cloud, const CropSetup& setup, const MergeParams& merge,
                 const VisibilityParams& params, float grid_bottom, const Rows& rows, std::vector<float>& clear,
                 bool force_scalar = false);

/// The same of a cell in which nothing is, seen by a camera with these optics and pose.
void clearDepthsOfEmptyCell(const Pinhole& optics, const Eigen::Isometry3f& T_world_camera,
                            const VisibilityParams& params, std::vector<float>& clear);

}  // namespace yarm::perception
