#ifndef YARM_CLEARANCE_CLEARANCE_HPP
#define YARM_CLEARANCE_CLEARANCE_HPP

// Least distance of a serial arm to obstacles and to itself, by FCL, called from Python through a C interface
// (yarm.manipulation.obstacles.clearance_native). Metres, radians; poses are 4 x 4, row-major. An arm is not
// thread-safe.

#include <cstdint>

extern "C" {

/// An arm among obstacles, known by its pointer alone.
struct YarmArm;

/// n solids: shape (0 box x, y, z; 1 cylinder with axis z: radius, length; 2 sphere: radius), 3 sizes, pose in the
/// frame they are given in.
struct YarmSolids {
  std::int32_t n;
  const std::int32_t* shapes;
  const double* sizes;
  const double* poses;
};

/// An arm of n_joints revolute joints among obstacles that stay where they are.
/// parent_from_child: for each joint the pose of its child link at angle 0, in the link before; axes: 3 numbers each,
/// of length 1, in the child's frame. links: in the frame of the link that carries them; carriers: its number, 0 the
/// fixed frame, i what joint i moves. Links that the fixed frame carries are not held against obstacles. pairs: n_pairs
/// times two solids of the arm that must not touch. Null when a shape is unknown.
YarmArm* yarmArmMake(std::int32_t n_joints, const double* parent_from_child, const double* axes,
                     const YarmSolids* links, const std::int32_t* carriers, std::int32_t n_pairs,
                     const std::int32_t* pairs, const YarmSolids* obstacles);
/// Lets go of an arm; null is allowed.
void yarmArmFree(YarmArm* arm);

/// The least distance at joint angles, 0 where something overlaps, and `within` when nothing is nearer.
double yarmArmClearance(YarmArm* arm, const double* angles, double within);

}  // extern "C"

#endif  // YARM_CLEARANCE_CLEARANCE_HPP
