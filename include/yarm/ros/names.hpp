// Names of topics, services and frames: the one C++ source (Python: yarm.ros.names; a test compares them).
// All are relative, so that they can be remapped and pushed into a namespace, but for /clock, /tf and /tf_static.
#pragma once

#include <string>

namespace yarm::names {

inline constexpr char WORLD_FRAME[] = "world";

inline constexpr char OBJECT_REGISTRY[] = "object_registry";
inline constexpr char VOXELIZED_CLOUD[] = "voxelized_cloud";
inline constexpr char MERGED_POINTS[] = "merged_points";
inline constexpr char CLOUD_CLUSTERS[] = "cloud_clusters";
inline constexpr char SEED_TRANSFORMS[] = "seed_transforms";
inline constexpr char STATIC_ASSOCIATION_SWITCH[] = "static_association_switch";
inline constexpr char ASSOCIATED_CLUSTERS[] = "associated_clusters";
inline constexpr char PLANNING_METADATA[] = "planning_metadata";
inline constexpr char COLLISIONS[] = "collisions";
inline constexpr char OCCUPANCY[] = "occupancy";
inline constexpr char PREDICT_NEW_STATE[] = "predict_new_state";
inline constexpr char DIAGNOSTICS[] = "/diagnostics";

// Depth cloud of overhead camera 1, 2, ...
inline std::string cameraPoints(int camera) {
  return "mapping_camera_" + std::to_string(camera) + "_mapping_kinect/depth/points";
}

// Optical frame (x right, y down, z forward) of overhead camera 1, 2, ...
inline std::string cameraOpticalFrame(int camera) {
  return "mapping_camera_" + std::to_string(camera) + "_depth_optical_frame";
}

}  // namespace yarm::names
