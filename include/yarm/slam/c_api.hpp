#ifndef YARM_SLAM_C_API_HPP
#define YARM_SLAM_C_API_HPP

// The map maker and the localisation, called from Python through a C interface (yarm.navigation.slam_native). The
// numbers are the library's defaults, which are those of the nodes; everything is done within the call, so the same
// input gives the same output. Metres, radians, nanoseconds. Texts and cells that are pointed to are valid until the
// next call with the same object. An object is not thread-safe.

#include <cstdint>

extern "C" {

/// A rigid motion of the plane.
struct YarmPose {
  double x;    ///< metres
  double y;    ///< metres
  double yaw;  ///< radians
};

/// One planar scan with the odometry of its moment: yarm::slam::Scan.
struct YarmScan {
  std::int64_t stamp_ns;
  double angle_min, angle_increment;  ///< radians
  double range_min, range_max;        ///< metres; ranges outside of them are nothing seen
  std::int32_t beams;
  const float* ranges;  ///< metres, one for each beam
  YarmPose T_base_sensor, T_odom_base;
};

/// An occupancy grid: yarm::slam::GridMap.
struct YarmGrid {
  std::int32_t width, height;  ///< cells
  double resolution;           ///< metres
  double origin_x, origin_y;   ///< metres, of the outer corner of cell (0, 0)
  const std::int8_t* cells;    ///< row by row; -1 unknown, 0 free to 100 occupied
};

/// A map maker, known by its pointer alone.
struct YarmMapper;

/// Answer to one scan.
struct YarmMapped {
  std::int32_t status;  ///< yarm::slam::ScanStatus
  const char* reason;   ///< why it was dropped or not matched; empty otherwise
  YarmPose T_map_base, T_map_odom;
};

/// A map maker whose robot stands at T_map_base at its first scan.
YarmMapper* yarmMapperMake(const YarmPose* T_map_base);
/// Lets go of a map maker; null is allowed.
void yarmMapperFree(YarmMapper* mapper);
/// Takes one scan; what is wrong with it is told by the answer.
void yarmMapperAdd(YarmMapper* mapper, const YarmScan* scan, YarmMapped* answer);
/// Draws the map of the scans so far.
void yarmMapperDraw(YarmMapper* mapper, YarmGrid* grid);
/// Keyframes that are kept, matches that succeeded, matches that were due and failed.
void yarmMapperCounts(const YarmMapper* mapper, std::int32_t* keyframes, std::int32_t* matched,
                      std::int32_t* unmatched);

/// A localiser in one map, known by its pointer alone.
struct YarmLocaliser;

/// Answer to one scan.
struct YarmLocalised {
  std::int32_t dropped;    ///< the scan was refused, for the reason
  std::int32_t state;      ///< yarm::slam::LocaliserState
  std::int32_t localised;  ///< the place is followed, sure enough, and the scans agree with the map
  std::int32_t has_pose;   ///< 0: what follows the reason means nothing
  const char* reason;      ///< why it is not localised; empty when it is
  YarmPose T_map_base, T_map_odom;
  double covariance[9];  ///< of T_map_base over x, y, yaw along the map's axes
  double agreement;      ///< share of the last fitted scan's points on surfaces
};

/// A localiser with no pose, in a map whose grid stands at T_map_grid. Null when the map is faulty; `why`, of `size`
/// characters, then says how.
YarmLocaliser* yarmLocaliserMake(const YarmGrid* map, const YarmPose* T_map_grid, char* why, std::int32_t size);
/// Lets go of a localiser; null is allowed.
void yarmLocaliserFree(YarmLocaliser* localiser);
/// Forgets the pose: the whole map is searched once enough has been seen.
void yarmLocaliserForget(YarmLocaliser* localiser);
/// Takes over a rough pose with its covariance, 9 numbers over x, y, yaw; gives why it is refused, or an empty text.
const char* yarmLocaliserBelieve(YarmLocaliser* localiser, const YarmPose* T_map_base, const double* covariance);
/// Has the next scan fitted even when the robot stands.
void yarmLocaliserFitNext(YarmLocaliser* localiser);
/// Takes one scan; what is wrong with it is told by the answer.
void yarmLocaliserAdd(YarmLocaliser* localiser, const YarmScan* scan, YarmLocalised* answer);

}  // extern "C"

#endif  // YARM_SLAM_C_API_HPP
