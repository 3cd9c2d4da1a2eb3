// Cells of the grid as markers for RViz.
#pragma once

#include "yarm/perception/types.hpp"

#include <visualization_msgs/Marker.h>

#include <cstdint>
#include <string>
#include <vector>

namespace yarm {

/// A list of cubes on the given cells (row-major indices), world, without colour; an empty list takes the marker of
/// this namespace away.
visualization_msgs::Marker cubes(const perception::GridSpec& grid, perception::StampNs stamp_ns,
                                 const std::string& space, const std::vector<std::int32_t>& cells);

}  // namespace yarm
