// The exact assignment of rows to columns at least cost.
#pragma once

#include <vector>

namespace yarm::perception {

constexpr int kUnassigned = -1;

/// Column of each row, or kUnassigned, such that the sum of the costs is least, where a row without a column costs
/// `unassigned`. `costs[row][column]` >= 0; one that is not below `unassigned` is never used. Each column is given to
/// one row at most. Hungarian algorithm with potentials (Kuhn 1955; Jonker and Volgenant 1987), O(rows^2 (rows +
/// columns)).
[[nodiscard]] std::vector<int> assignAtLeastCost(const std::vector<std::vector<double>>& costs, double unassigned);

}  // namespace yarm::perception
