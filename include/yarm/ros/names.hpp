// Names of topics, services and frames: the one C++ source (Python: yarm.ros.common.names; a test compares them).
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
inline constexpr char HIDDEN_CELLS[] = "hidden_cells";
inline constexpr char SEEN_CELLS[] = "seen_cells";
inline constexpr char COVERAGE[] = "coverage";
inline constexpr char TRACKED_OBJECTS[] = "tracked_objects";
inline constexpr char TRACKS[] = "tracks";
inline constexpr char PREDICT_NEW_STATE[] = "predict_new_state";
inline constexpr char SCAN[] = "scan";
inline constexpr char MAP[] = "map";
inline constexpr char MAP_METADATA[] = "map_metadata";
inline constexpr char DYNAMIC_MAP[] = "dynamic_map";
inline constexpr char STATIC_MAP[] = "static_map";
inline constexpr char SET_MAP[] = "set_map";
inline constexpr char AMCL_POSE[] = "amcl_pose";
inline constexpr char INITIAL_POSE[] = "initialpose";
inline constexpr char PARTICLE_CLOUD[] = "particlecloud";
inline constexpr char GLOBAL_LOCALIZATION[] = "global_localization";
inline constexpr char REQUEST_NOMOTION_UPDATE[] = "request_nomotion_update";
inline constexpr char DIAGNOSTICS[] = "/diagnostics";

/// Depth cloud of overhead camera 1, 2, ...
inline std::string cameraPoints(int camera) {
  return "mapping_camera_" + std::to_string(camera) + "_mapping_kinect/depth/points";
}

/// Optical frame (x right, y down, z forward) of overhead camera 1, 2, ...
inline std::string cameraOpticalFrame(int camera) {
  return "mapping_camera_" + std::to_string(camera) + "_depth_optical_frame";
}

/// Whether something hangs on the hand of a mobile robot.
inline std::string grasping(const std::string& robot) {
  return robot + "/gripper/grasping";
}

/// The same with its time, in lock-step.
inline std::string gripperState(const std::string& robot) {
  return robot + "/gripper/state";
}

}  // namespace yarm::names
