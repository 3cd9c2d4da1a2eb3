#include "yarm/perception/picture_watch.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace yarm::perception {

namespace {

constexpr std::size_t kPrintEvery = 16;  // points of which one is looked at for changes
constexpr int kLookEvery = 5;            // clouds of which one is looked at for spots
constexpr std::size_t kStride = 2;       // pixels along each side of which one is looked at for readings
constexpr float kSmoothing = 0.2F;       // weight of a new look
constexpr float kUsual = 0.9F;           // a part of the image with this share of readings used to see
constexpr float kDead = 0.1F;            // and one with less sees nothing

float valueAt(const std::uint8_t* data) {
  float value = 0.F;
  std::memcpy(&value, data, sizeof(value));
  return value;
}

std::size_t rowStep(const CameraCloud& cloud) {
  return cloud.row_step != 0 ? cloud.row_step : cloud.width * cloud.point_step;
}

/// A fingerprint of a cloud (FNV-1a over the depths of one point of sixteen).
std::uint64_t printOf(const CameraCloud& cloud) {
  std::uint64_t print = 14695981039346656037ULL;
  const std::size_t row = rowStep(cloud);
  for (std::size_t i = 0; i < cloud.width * cloud.height; i += kPrintEvery) {
    std::uint32_t bits = 0;
    const std::uint8_t* point = cloud.data + (i / cloud.width) * row + (i % cloud.width) * cloud.point_step;
    std::memcpy(&bits, point + cloud.z_offset, sizeof(bits));
    print = (print ^ bits) * 1099511628211ULL;
  }
  return print;
}

double seconds(StampNs span_ns) {
  return 1e-9 * static_cast<double>(span_ns);
}

}  // namespace

Picture PictureWatch::judge(std::size_t camera, const CameraCloud& cloud) {
  Camera& c = cameras_[camera];
  if (params_.frozen_after > 0.0) {
    const std::uint64_t print = printOf(cloud);
    if (print != c.print || c.clouds == 0 || cloud.stamp_ns < c.same_ns) {
      c.print = print;
      c.same_ns = cloud.stamp_ns;
    }
    c.last.same_s = seconds(cloud.stamp_ns - c.same_ns);
    c.last.frozen = c.last.same_s >= params_.frozen_after;
  }
  if (params_.spot_after > 0.0 && c.clouds % kLookEvery == 0 && !c.last.frozen) {
    lookForSpots(c, cloud);
    tellSpots(c, cloud);
  }
  ++c.clouds;
  return c.last;
}

void PictureWatch::lookForSpots(Camera& camera, const CameraCloud& cloud) const {
  camera.parts.resize(kEdge * kEdge);
  std::vector<int> looked(kEdge * kEdge, 0);
  std::vector<int> read(kEdge * kEdge, 0);
  const std::size_t row = rowStep(cloud);
  const auto nearest = static_cast<float>(params_.nearest);
  for (std::size_t v = 0; v < cloud.height; v += kStride) {
    for (std::size_t u = 0; u < cloud.width; u += kStride) {
      const std::size_t part = (v * kEdge / cloud.height) * kEdge + u * kEdge / cloud.width;
      const float z = valueAt(cloud.data + v * row + u * cloud.point_step + cloud.z_offset);
      ++looked[part];
      read[part] += z >= nearest && std::isfinite(z) ? 1 : 0;
    }
  }
  for (std::size_t i = 0; i < camera.parts.size(); ++i) {
    Part& part = camera.parts[i];
    const float share = looked[i] > 0 ? static_cast<float>(read[i]) / static_cast<float>(looked[i]) : 0.F;
    part.smooth = camera.clouds == 0 ? share : part.smooth + kSmoothing * (share - part.smooth);
    part.usual = std::max(part.usual, part.smooth);
    const bool dead = part.usual >= kUsual && share <= kDead;
    if (dead && !part.dead) {
      part.dead_ns = cloud.stamp_ns;
    }
    part.dead = dead;
  }
}

void PictureWatch::tellSpots(Camera& camera, const CameraCloud& cloud) const {
  std::size_t covered = 0;
  std::size_t sum_u = 0;
  std::size_t sum_v = 0;
  for (std::size_t i = 0; i < camera.parts.size(); ++i) {
    const Part& part = camera.parts[i];
    if (part.dead && seconds(cloud.stamp_ns - part.dead_ns) >= params_.spot_after) {
      ++covered;
      sum_u += i % kEdge;
      sum_v += i / kEdge;
    }
  }
  camera.last.covered = static_cast<double>(covered) / static_cast<double>(camera.parts.size());
  if (covered > 0) {
    const auto middle = [&](std::size_t sum, std::size_t size) {
      return static_cast<int>((2 * sum + covered) * size / (2 * covered * kEdge));
    };
    camera.last.u = middle(sum_u, cloud.width);
    camera.last.v = middle(sum_v, cloud.height);
  }
}

void PictureWatch::reset() {
  std::fill(cameras_.begin(), cameras_.end(), Camera());
}

}  // namespace yarm::perception
