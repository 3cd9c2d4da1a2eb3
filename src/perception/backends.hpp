// The two back ends' factories and what they share.
#pragma once

#include "yarm/perception/merge.hpp"

#include "crop_kernel.hpp"

#include <memory>
#include <vector>

namespace yarm::perception {

[[nodiscard]] std::unique_ptr<MergeBackend> makeFusedBackend(const MergeParams& merge, const ClusterParams& cluster);
[[nodiscard]] std::unique_ptr<MergeBackend> makePclBackend(const MergeParams& merge, const ClusterParams& cluster);

/// Throws std::invalid_argument naming every parameter that is out of range, its value and what is accepted.
void checkParams(const MergeParams& merge, const ClusterParams& cluster);

/// What became of a cloud that holds so many points of each kind.
[[nodiscard]] CameraReport reportOf(const CameraCloud& cloud, const CropCount& count, const MergeParams& params);

/// Oldest capture time of a set; 0 for none.
[[nodiscard]] StampNs oldestStamp(const std::vector<CameraCloud>& clouds);

/// A surviving point with its noise and viewing direction.
[[nodiscard]] MergedPoint makeMergedPoint(const NoiseModel& noise, const Eigen::Vector3f& camera_origin, float depth,
                                          float x, float y, float z, int camera);

/// From a component label per voxel to clusters of the allowed sizes, largest first (ties: the one with the lowest
/// voxel).
void clustersFromLabels(const std::vector<std::int32_t>& labels, int label_count, const ClusterParams& params,
                        MergedSet& set);

}  // namespace yarm::perception
