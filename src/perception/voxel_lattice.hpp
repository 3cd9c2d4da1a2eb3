// The voxel lattice both back ends share: voxel = floor(p / edge), as in PCL's VoxelGrid.
#pragma once

#include "yarm/perception/merge.hpp"

#include <cmath>

namespace yarm::perception {

/// Numbering of the voxels of the box, x fastest, then y, then z.
struct VoxelLattice {
  explicit VoxelLattice(const MergeParams& params) {
    for (int a = 0; a < 3; ++a) {
      const auto i = static_cast<std::size_t>(a);
      inverse[a] = 1.F / static_cast<float>(params.voxel_size[i]);
      low[a] = static_cast<int>(std::floor(static_cast<float>(params.box_min[i]) * inverse[a]));
      n[a] = static_cast<int>(std::floor(static_cast<float>(params.box_max[i]) * inverse[a])) - low[a] + 1;
    }
  }

  /// Number of a point's voxel; the point lies in the box.
  [[nodiscard]] std::int32_t keyOf(const MergedPoint& p) const {
    const int i = below(p.x * inverse[0]) - low[0];
    const int j = below(p.y * inverse[1]) - low[1];
    const int k = below(p.z * inverse[2]) - low[2];
    return (k * n[1] + j) * n[0] + i;
  }

  [[nodiscard]] double count() const { return static_cast<double>(n[0]) * n[1] * n[2]; }

  /// floor() of a value that fits an int, without a call.
  static int below(float value) {
    const int whole = static_cast<int>(value);
    return whole - (static_cast<float>(whole) > value ? 1 : 0);
  }

  float inverse[3];
  int low[3];
  int n[3];
};

}  // namespace yarm::perception
