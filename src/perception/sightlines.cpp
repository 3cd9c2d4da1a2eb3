#include "sightlines.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>

namespace yarm::perception {

namespace {

constexpr std::size_t kRays = 32;      // of a camera that are brought to meet, about
constexpr std::size_t kLeastRays = 6;  // fewer say nothing of its place
constexpr float kLeastSpread = 1e-3F;  // least pivot of their normal equations over the rays: else all but parallel
constexpr float kBeside = 0.015F;      // a point this near to a line of sight lies on it, rad: one pixel
constexpr float kBehind = 0.12F;       // a point further away than a place by more is behind it, metres
constexpr float kAt = 0.02F;           // and one that is nearer by less than this, and its noise, is at it, metres
constexpr float kAtSigmas = 2.0F;
constexpr std::int32_t kMostCameras = 32;  // a bit each

}  // namespace

void Sightlines::take(const std::vector<MergedPoint>& points, const std::vector<std::int32_t>& absent,
                      const std::vector<char>& explained) {
  points_ = &points;
  explained_ = &explained;
  for (Camera& camera : cameras_) {
    camera.begin = camera.end = 0;
    camera.absent = false;
  }
  for (std::size_t begin = 0; begin < points.size();) {
    const std::int32_t index = points[begin].camera;
    const auto later = std::partition_point(points.begin() + static_cast<std::ptrdiff_t>(begin), points.end(),
                                            [&](const MergedPoint& p) { return p.camera <= index; });
    const std::size_t end = static_cast<std::size_t>(later - points.begin());
    if (index < 0 || index >= kMostCameras) {
      begin = end;
      continue;
    }
    if (static_cast<std::size_t>(index) >= cameras_.size()) {
      cameras_.resize(static_cast<std::size_t>(index) + 1);
    }
    Camera& camera = cameras_[static_cast<std::size_t>(index)];
    camera.begin = begin;
    camera.end = begin = end;
    locate(camera);
  }
  for (const std::int32_t index : absent) {
    if (static_cast<std::size_t>(index) < cameras_.size()) {
      cameras_[static_cast<std::size_t>(index)].absent = true;
    }
  }
}

void Sightlines::locate(Camera& camera) const {
  const std::size_t count = camera.end - camera.begin;
  if (count < kLeastRays) {
    return;
  }
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  const std::size_t step = 1 + count / kRays;
  double rays = 0.0;
  for (std::size_t i = camera.begin; i < camera.end; i += step) {
    const MergedPoint& p = (*points_)[i];
    const Eigen::Vector3d u(p.ux, p.uy, p.uz);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - u * u.transpose();
    A += across;
    b += across * Eigen::Vector3d(p.x, p.y, p.z);
    rays += 1.0;
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(A);
  if (solver.vectorD().minCoeff() > kLeastSpread * rays) {
    camera.place = solver.solve(b).cast<float>();
    camera.known = true;
  }
}

int Sightlines::seenThrough(const std::vector<Eigen::Vector3f>& places, std::uint32_t cameras) const {
  const std::size_t count = std::min(places.size(), kMostPlaces);
  const auto all = static_cast<std::uint32_t>((std::uint64_t{1} << count) - 1U);
  std::uint32_t through = 0;
  for (std::size_t c = 0; c < cameras_.size() && through != all; ++c) {
    if ((cameras >> c & 1U) != 0 && cameras_[c].known && !cameras_[c].absent) {
      through |= all & ~stopped(cameras_[c], places);
    }
  }
  return __builtin_popcount(through);
}

std::uint32_t Sightlines::stopped(const Camera& camera, const std::vector<Eigen::Vector3f>& places) const {
  const std::size_t count = std::min(places.size(), kMostPlaces);
  std::array<Eigen::Vector3f, kMostPlaces> directions;
  std::array<float, kMostPlaces> ranges{};
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  for (std::size_t s = 0; s < count; ++s) {
    const Eigen::Vector3f to = places[s] - camera.place;
    ranges[s] = to.norm();
    directions[s] = to.normalized();
    middle += directions[s];
  }
  middle.normalize();
  float widest = 0.0F;
  for (std::size_t s = 0; s < count; ++s) {
    widest = std::max(widest, std::acos(std::clamp(directions[s].dot(middle), -1.0F, 1.0F)));
  }
  const float cone = std::cos(widest + kBeside);
  const float beside = std::cos(kBeside);
  std::uint32_t found = 0;
  for (std::size_t i = camera.begin; i < camera.end; ++i) {
    const MergedPoint& p = (*points_)[i];
    const Eigen::Vector3f u(p.ux, p.uy, p.uz);
    if (u.dot(middle) < cone) {
      continue;
    }
    const float range = (Eigen::Vector3f(p.x, p.y, p.z) - camera.place).norm();
    const float behind = (*explained_)[i] != 0 ? -kAt - kAtSigmas * p.sigma : kBehind;
    for (std::size_t s = 0; s < count; ++s) {
      if (range < ranges[s] + behind && u.dot(directions[s]) > beside) {
        found |= 1U << s;
      }
    }
  }
  return found;
}

}  // namespace yarm::perception
