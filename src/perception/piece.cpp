#include "yarm/perception/piece.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace yarm::perception {

namespace {

constexpr float kOutermost = 0.05F;  // share of the points left out at each end of an extent
constexpr float kUpper = 0.85F;      // share of the points below the height of the top
constexpr float kOneSpot = 1e-10F;   // m^2: variance along the main direction of points that have none

struct Extent {
  float low{0};
  float high{0};
};

/// The value below which a share of the values lies; orders them in part.
float quantile(std::vector<float>& values, float share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<float>(values.size() - 1) + 0.5F);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Extent extentAlong(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector2f& direction) {
  std::vector<float> along;
  along.reserve(points.size());
  for (const Eigen::Vector3f& p : points) {
    along.push_back(direction.dot(p.head<2>()));
  }
  return {quantile(along, kOutermost), quantile(along, 1.0F - kOutermost)};
}

float heightOf(const std::vector<Eigen::Vector3f>& points) {
  std::vector<float> heights;
  heights.reserve(points.size());
  for (const Eigen::Vector3f& p : points) {
    heights.push_back(p.z());
  }
  return quantile(heights, kUpper);
}

/// Variances and directions of the points seen from above, the lesser first.
Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f> spreadOf(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector2f mean = Eigen::Vector2f::Zero();
  for (const Eigen::Vector3f& p : points) {
    mean += p.head<2>() / static_cast<float>(points.size());
  }
  Eigen::Matrix2f covariance = Eigen::Matrix2f::Zero();
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector2f off = p.head<2>() - mean;
    covariance += off * off.transpose() / static_cast<float>(points.size());
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f>(covariance);
}

}  // namespace

std::optional<PieceView> pieceOf(const std::vector<Eigen::Vector3f>& points) {
  if (points.size() < kLeastPiecePoints) {
    return std::nullopt;
  }
  const auto spread = spreadOf(points);
  if (!(spread.eigenvalues()[1] > kOneSpot)) {
    return std::nullopt;
  }
  Eigen::Vector2f axis = spread.eigenvectors().col(1);
  axis *= axis.x() < 0.0F || (axis.x() == 0.0F && axis.y() < 0.0F) ? -1.0F : 1.0F;
  const Eigen::Vector2f across(-axis.y(), axis.x());
  const Extent length = extentAlong(points, axis);
  const Extent width = extentAlong(points, across);
  const Eigen::Vector2f middle = 0.5F * ((length.low + length.high) * axis + (width.low + width.high) * across);
  PieceView view;
  view.points = points.size();
  view.top = {middle.x(), middle.y(), heightOf(points)};
  view.axis_rad = std::atan2(axis.y(), axis.x());
  view.length = length.high - length.low;
  view.width = width.high - width.low;
  return view;
}

}  // namespace yarm::perception
