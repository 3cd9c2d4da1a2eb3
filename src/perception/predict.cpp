#include "yarm/perception/predict.hpp"

#include "yarm/perception/occupancy.hpp"

#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/detail/gjk_solver_libccd.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

namespace yarm::perception {

namespace {

using Move = std::pair<std::string, Eigen::Isometry3d>;

/// Refuses a faulty question; returns the index of the move of each object, -1 = stays.
std::string checkMoves(const AssociatedSet& present, const std::vector<Move>& moves, std::vector<int>& move_of) {
  std::ostringstream faults;
  move_of.assign(present.objects.size(), -1);
  for (std::size_t m = 0; m < moves.size(); ++m) {
    const auto found = std::find_if(present.objects.begin(), present.objects.end(),
                                    [&](const AssociatedObject& o) { return o.name == moves[m].first; });
    const char* gap = faults.tellp() > 0 ? "; " : "";
    if (found == present.objects.end()) {
      faults << gap << "object '" << moves[m].first << "' is not in the map";
      continue;
    }
    int& slot = move_of[static_cast<std::size_t>(found - present.objects.begin())];
    if (slot >= 0) {
      faults << gap << "object '" << moves[m].first << "' is named twice";
    } else if (!moves[m].second.matrix().allFinite()) {
      faults << gap << "the pose of '" << moves[m].first << "' is not finite";
    }
    slot = static_cast<int>(m);
  }
  return faults.str();
}

AssociatedSet moved(const AssociatedSet& present, const std::vector<Move>& moves, const std::vector<int>& move_of) {
  AssociatedSet result = present;
  for (std::size_t o = 0; o < result.objects.size(); ++o) {
    if (move_of[o] < 0) {
      continue;
    }
    AssociatedObject& object = result.objects[o];
    const Eigen::Isometry3d& target = moves[static_cast<std::size_t>(move_of[o])].second;
    const Eigen::Isometry3f T = (target * object.T_world_seed.inverse()).cast<float>();
    for (auto* cloud : {&object.points, &object.hidden}) {
      std::transform(cloud->begin(), cloud->end(), cloud->begin(), [&](const Eigen::Vector3f& p) { return T * p; });
    }
    object.T_world_seed = target;
  }
  return result;
}

using PointsByCell = std::map<std::int32_t, std::vector<Eigen::Vector3f>>;

PointsByCell pointsInCells(const AssociatedObject& object, const GridSpec& grid, const std::set<std::int32_t>& cells) {
  PointsByCell result;
  for (const auto* cloud : {&object.points, &object.hidden}) {
    for (const Eigen::Vector3f& p : *cloud) {
      const int cell = grid.indexOf(p.x(), p.y(), p.z());
      if (cells.count(cell) != 0) {
        result[cell].push_back(p);
      }
    }
  }
  return result;
}

/// GJK between the points of two objects in one cell, each grown to a small ball.
bool touch(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b, double radius) {
  const fcl::Sphered ball(radius);
  const fcl::detail::GJKSolver_libccdd solver;
  for (const Eigen::Vector3f& p : a) {
    for (const Eigen::Vector3f& q : b) {
      fcl::Transform3d T_a = fcl::Transform3d::Identity();
      fcl::Transform3d T_b = fcl::Transform3d::Identity();
      T_a.translation() = p.cast<double>();
      T_b.translation() = q.cast<double>();
      if (solver.shapeIntersect(ball, T_a, ball, T_b, nullptr)) {
        return true;
      }
    }
  }
  return false;
}

bool pairTouches(const PointsByCell& a, const PointsByCell& b, double radius) {
  return std::any_of(a.begin(), a.end(), [&](const auto& entry) {
    const auto other = b.find(entry.first);
    return other != b.end() && touch(entry.second, other->second, radius);
  });
}

void narrowPhase(const AssociatedSet& future, const GridSpec& grid, const std::vector<int>& move_of, double radius,
                 Prediction& answer) {
  const std::set<std::int32_t> cells(answer.cells.begin(), answer.cells.end());
  std::vector<PointsByCell> clouds;
  for (const AssociatedObject& object : future.objects) {
    clouds.push_back(pointsInCells(object, grid, cells));
  }
  for (std::size_t a = 0; a < clouds.size(); ++a) {
    for (std::size_t b = a + 1; b < clouds.size(); ++b) {
      const bool counts = (move_of[a] >= 0 || move_of[b] >= 0) && !mayShareCells(future.objects[a], future.objects[b]);
      if (counts && pairTouches(clouds[a], clouds[b], radius)) {
        answer.pairs.emplace_back(std::minmax(future.objects[a].name, future.objects[b].name));
      }
    }
  }
  std::sort(answer.pairs.begin(), answer.pairs.end());
}

}  // namespace

Prediction predictNewState(const AssociatedSet& present, const GridSpec& grid, const std::vector<Move>& moves,
                           double point_radius) {
  Prediction answer;
  std::vector<int> move_of;
  answer.message = checkMoves(present, moves, move_of);
  if (!answer.message.empty()) {
    return answer;
  }
  answer.ok = true;
  const AssociatedSet future = moved(present, moves, move_of);
  OccupancyBuilder builder(grid);
  answer.cells = builder.build(future).collisions;
  narrowPhase(future, grid, move_of, point_radius, answer);
  answer.collision = !answer.pairs.empty();
  std::ostringstream text;
  text << "moved " << moves.size() << " of " << present.objects.size() << " objects: " << answer.cells.size()
       << " cells in conflict, " << answer.pairs.size() << " pairs touch";
  answer.message = text.str();
  return answer;
}

}  // namespace yarm::perception
