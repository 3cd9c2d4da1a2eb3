// The one pass over the raw points: transform, crop, floor margin. Inner part of the fused back end.
#pragma once

#include "yarm/perception/merge.hpp"

#include <vector>

namespace yarm::perception {

/// Everything the pass needs to know about one camera, single precision.
struct CropSetup {
  float m[3][4];  ///< rows of world <- camera
  float lo[3];    ///< box, inclusive
  float hi[3];
  float floor_base;  ///< a point passes when z_world * depth >= floor_base + floor_slope * (depth - floor_offset)^2
  float floor_slope;
  float floor_offset;
  float absurd;  ///< coordinates beyond this are absurd, metres
};

/// Sets up the pass for a camera.
[[nodiscard]] CropSetup makeCropSetup(const MergeParams& params, const Eigen::Isometry3f& T_world_camera);

/// True when a point is above the noise of the floor: depth along the optical axis and height above the floor, metres.
[[nodiscard]] inline bool aboveFloorNoise(const CropSetup& s, float depth, float height) {
  const float d = depth - s.floor_offset;
  return height * depth >= s.floor_base + s.floor_slope * (d * d);
}

/// World coordinates of a point, summed in the order PCL's transform uses, so that both back ends agree to the last
/// bit.
inline void toWorld(const CropSetup& s, const float* p, float* world) {
  for (int r = 0; r < 3; ++r) {
    world[r] = p[0] * s.m[r][0] + (p[1] * s.m[r][1] + (p[2] * s.m[r][2] + s.m[r][3]));
  }
}

/// Sensor-frame depth and world position of a point that passed.
struct Survivor {
  float x, y, z, depth;
};

/// What a cloud was made of.
struct CropCount {
  std::size_t finite{0};  ///< points with three coordinates that are finite and not absurd
  std::size_t absurd{0};  ///< points with a coordinate that is infinite or absurd
};

/// Appends the points of a cloud that pass and counts what it holds. Absurd points never pass. `force_scalar` keeps the
/// portable path, for the tests.
CropCount cropCloud(const CropSetup& setup, const CameraCloud& cloud, std::vector<Survivor>& out,
                    bool force_scalar = false);

}  // namespace yarm::perception
