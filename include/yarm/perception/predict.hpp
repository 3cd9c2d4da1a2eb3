// Would these objects collide if they were there?
#pragma once

#include "yarm/perception/types.hpp"

#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace yarm::perception {

/// Answer of predictNewState.
struct Prediction {
  bool ok{false};                   ///< false when the question was refused
  bool collision{false};            ///< true when two objects would touch
  std::vector<std::int32_t> cells;  ///< row-major cells that more than one object would occupy, ascending
  std::vector<std::pair<std::string, std::string>> pairs;  ///< objects that would touch, each pair once, names in order
  std::string message;                                     ///< what was checked, or what was refused and why
};

/// Moves the stored clouds of the named objects rigidly so that their seeds take the new poses (world), bins again, and
/// asks GJK (FCL) on the conflicting cells only whether the two objects' points, grown to `point_radius` metres, touch
/// there. Only pairs with at least one moved object count, and pairs that are attached or of which neither is a robot
/// do not. A name that does not exist or is given twice, or a pose with NaN, is refused with a message.
[[nodiscard]] Prediction predictNewState(const AssociatedSet& present, const GridSpec& grid,
                                         const std::vector<std::pair<std::string, Eigen::Isometry3d>>& moves,
                                         double point_radius = 0.025);

}  // namespace yarm::perception
