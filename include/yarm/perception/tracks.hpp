// What moves and nobody registered, followed over time: one identity, place and motion each.
#pragma once

#include "yarm/perception/types.hpp"

namespace yarm::perception {

/// A thing that nobody registered, followed over time: its state after a set. Its box has its edges along the axes of
/// the world.
struct TrackedObject {
  int number{0};                            ///< its identity; in the map it is "unknown_<number>"
  Eigen::Vector3d position{0.0, 0.0, 0.0};  ///< middle of its box, metres, world
  Eigen::Vector3d velocity{0.0, 0.0, 0.0};  ///< m/s, world
  Eigen::Matrix<double, 6, 6> covariance{Eigen::Matrix<double, 6, 6>::Zero()};  ///< of position, then velocity
  Eigen::Vector3d extent{0.0, 0.0, 0.0};                                        ///< edges of its box, metres
  StampNs first_seen_ns{0};  ///< capture time of the first set in which it showed
  StampNs last_seen_ns{0};   ///< and of the last one
  bool hidden{false};        ///< it does not show, and its place is not seen to be free
};

}  // namespace yarm::perception
