// Where a hand would take a piece of debris: its top, its middle and its axis, from its points.
#pragma once

#include "yarm/perception/types.hpp"

#include <optional>
#include <vector>

namespace yarm::perception {

/// What a set's points say of a piece; empty with fewer than `kLeastPiecePoints`, or when they lie in one spot.
/// Middle and extents are those of the points' rectangle about their main direction, seen from above, without the
/// outermost points; the height is that of the upper ones. O(n log n).
[[nodiscard]] std::optional<PieceView> pieceOf(const std::vector<Eigen::Vector3f>& points);

}  // namespace yarm::perception
