#ifndef YARM_JOINT_JOINT_HPP
#define YARM_JOINT_JOINT_HPP

// A complete search over the joint configurations of a fleet, called from Python through a C interface
// (yarm.planning.fleet.joint_native). One robot moves at a time, by one column along an axis or by one turn in place,
// while all others stand. Columns are x, y of a grid gx x gy; images are row-major, gx x gy, one byte a column. Costs
// are whole numbers of cells. The same input gives the same answer; no clock and no chance decides anything. Not thread
// safe on the same search.

#include <cstdint>

extern "C" {

/// A search, what it has visited and the plan it has found.
struct YarmJoint;

/// What robots cover relative to their end effector's column, by number.
struct YarmJointShapes {
  std::int32_t n;               ///< shapes
  std::int32_t words;           ///< 64-bit words that hold the heights of a column as bits
  const std::int32_t* first;    ///< n + 1: first column of each shape
  const std::int32_t* columns;  ///< (first[n], 2) relative x, y
  const std::uint64_t* bits;    ///< (first[n], words) heights occupied in the column
};

/// One robot among what does not move.
struct YarmJointRobot {
  std::int32_t n_headings;
  std::int32_t n_turns;
  const std::uint8_t* blocked;       ///< (n_headings, gx, gy) 1 where it cannot stand
  const std::uint8_t* turn_blocked;  ///< (n_turns, gx, gy) 1 where it cannot make the turn
  const std::int32_t* turns;         ///< (n_turns, 3) heading before, heading after, cost
  const std::int32_t* shapes;        ///< (n_headings) shape at a heading
  const std::int32_t* turn_shapes;   ///< (n_turns) shape swept by a turn
  std::int32_t start[3];             ///< x, y, heading; taken as free
  std::int32_t goal[3];              ///< x, y, heading or -1 for any; x -1 for none
};

/// Where one robot cannot be while another stands at its start, when the two start within each other's margin.
struct YarmJointNear {
  std::int32_t robot;
  std::int32_t other;
  const std::uint8_t* blocked;       ///< (n_headings, gx, gy)
  const std::uint8_t* turn_blocked;  ///< (n_turns, gx, gy)
};

/// How a search stands.
enum YarmJointOutcome : std::int32_t {
  YARM_JOINT_OPEN = 0,        ///< the work was used up; another run goes on
  YARM_JOINT_FOUND = 1,       ///< there is a plan
  YARM_JOINT_IMPOSSIBLE = 2,  ///< no configuration that can be reached has everybody on his goal
  YARM_JOINT_FULL = 3         ///< the memory allowed is used up
};

/// A search that has not begun; copies what it is given. memory_bytes: what its configurations may take.
YarmJoint* yarmJointMake(std::int32_t gx, std::int32_t gy, const YarmJointShapes* shapes, std::int32_t n_robots,
                         const YarmJointRobot* robots, std::int32_t n_near, const YarmJointNear* near,
                         std::int64_t memory_bytes);

/// Frees a search and all it holds.
void yarmJointFree(YarmJoint* joint);

/// 1 when what is impossible is so by the exchanges of robots of one kind that can be made, 0 when every configuration
/// has been looked at.
std::int32_t yarmJointByExchange(const YarmJoint* joint);

/// Searches on; `work` counts look-ups of two robots, some 10 ns each. Returns a YarmJointOutcome.
std::int32_t yarmJointRun(YarmJoint* joint, std::int64_t work);

/// Makes the plan found cheaper.
void yarmJointImprove(YarmJoint* joint, std::int64_t work);

/// Number of unit moves of the plan found; 0 without one.
std::int32_t yarmJointLength(const YarmJoint* joint);

/// The plan found: (length, 4) robot, and x, y, heading after its move.
void yarmJointPlan(const YarmJoint* joint, std::int32_t* moves);

/// Cost of the plan found, cells.
std::int64_t yarmJointCost(const YarmJoint* joint);

/// Configurations visited in all.
std::int64_t yarmJointVisited(const YarmJoint* joint);

/// Work done in all.
std::int64_t yarmJointWork(const YarmJoint* joint);

}  // extern "C"

#endif  // YARM_JOINT_JOINT_HPP
