// The occupancy grid: whose is each cell, and where might two things collide.
#pragma once

#include "yarm/perception/types.hpp"

#include <cstdint>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace yarm::perception {

/// Gives each name a number that is unique for the life of the process: a name that left and comes again gets a new
/// one.
class UidRegistry {
 public:
  /// Brings the numbers up to the names present now; returns them in the order of the names.
  std::vector<std::int32_t> update(const std::vector<std::string>& names);

 private:
  std::unordered_map<std::string, std::int32_t> uids_;
  std::int32_t next_{1};
};

/// The grid of one set.
struct OccupancyGrid {
  GridSpec spec;
  std::vector<std::int8_t> cells;                       ///< row-major x, y, z: 0 nobody, 1 one object, 2 more than one
  std::vector<std::vector<std::int32_t>> object_cells;  ///< row-major cell indices of each object, ascending, each once
  std::vector<std::int32_t> collisions;                 ///< row-major indices of the cells with value 2, ascending
};

/// Bins every object's seen and hidden points. Buffers are kept between calls: not thread safe.
class OccupancyBuilder {
 public:
  explicit OccupancyBuilder(const GridSpec& spec);

  /// The grid of a set; object_cells is parallel to set.objects. Two objects of which neither is a robot (Mobile or
  /// Manipulator), or of which one is attached to the other, do not collide: the cells they share belong to the looser
  /// one (Debris, then unknown things, then the attached one). Valid until the next call.
  const OccupancyGrid& build(const AssociatedSet& set);

 private:
  void mark(const std::vector<Eigen::Vector3f>& points);
  void collect(std::vector<std::int32_t>& cells);
  void gatherShared();
  void settle(const AssociatedSet& set);
  void give(std::size_t begin, std::size_t end, std::size_t keeper);

  OccupancyGrid grid_;
  CellFinder finder_;
  std::vector<std::uint64_t> bits_;                            // cells of the object at hand
  std::vector<std::pair<std::int32_t, std::int32_t>> shared_;  // (cell, object) of the cells claimed more than once
};

/// True when two objects may share cells in peace: neither is a robot, or one is attached to the other.
[[nodiscard]] bool mayShareCells(const AssociatedObject& a, const AssociatedObject& b);

}  // namespace yarm::perception
