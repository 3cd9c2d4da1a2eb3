#include <memory>
#include <utility>

#include "solver.hpp"
#include "yarm/joint/joint.hpp"

struct YarmJoint {
  yarm::joint::Solver solver;
};

YarmJoint* yarmJointMake(std::int32_t gx, std::int32_t gy, const YarmJointShapes* shapes, std::int32_t n_robots,
                         const YarmJointRobot* robots, std::int32_t n_near, const YarmJointNear* near,
                         std::int64_t memory_bytes) {
  return new YarmJoint{{yarm::joint::Fleet(gx, gy, *shapes, n_robots, robots, n_near, near), memory_bytes}};
}

void yarmJointFree(YarmJoint* joint) {
  delete joint;
}

std::int32_t yarmJointRun(YarmJoint* joint, std::int64_t work) {
  switch (joint->solver.run(work)) {
    case yarm::joint::Outcome::kFound:
      return YARM_JOINT_FOUND;
    case yarm::joint::Outcome::kExhausted:
      return YARM_JOINT_IMPOSSIBLE;
    case yarm::joint::Outcome::kFull:
      return YARM_JOINT_FULL;
    default:
      return YARM_JOINT_OPEN;
  }
}

std::int32_t yarmJointByExchange(const YarmJoint* joint) {
  return joint->solver.byExchange() ? 1 : 0;
}

void yarmJointImprove(YarmJoint* joint, std::int64_t work) {
  joint->solver.improve(work);
}

std::int32_t yarmJointLength(const YarmJoint* joint) {
  return static_cast<std::int32_t>(joint->solver.plan().size());
}

void yarmJointPlan(const YarmJoint* joint, std::int32_t* moves) {
  for (const yarm::joint::UnitMove& move : joint->solver.plan()) {
    const yarm::joint::Stand& stand = joint->solver.fleet().graph(move.robot).stand(move.to);
    *moves++ = move.robot;
    *moves++ = stand.x;
    *moves++ = stand.y;
    *moves++ = stand.heading;
  }
}

std::int64_t yarmJointCost(const YarmJoint* joint) {
  return joint->solver.cost();
}

std::int64_t yarmJointVisited(const YarmJoint* joint) {
  return joint->solver.visited();
}

std::int64_t yarmJointWork(const YarmJoint* joint) {
  return joint->solver.work();
}
