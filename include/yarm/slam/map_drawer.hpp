// Draws scans into an occupancy grid, and draws them again when their keyframes move.
#pragma once

#include "yarm/slam/params.hpp"
#include "yarm/slam/types.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace yarm::slam {

/// A scan kept for drawing. Not changed once made.
struct MapScan {
  int keyframe{0};  ///< index of the keyframe it moves with
  Pose2 T_keyframe_sensor;
  double angle_min{0};                   ///< radians
  double angle_increment{0};             ///< radians
  std::vector<std::uint16_t> ranges_mm;  ///< millimetres, 0: nothing seen
};

/// The scan in the form that is kept.
[[nodiscard]] MapScan toMapScan(const Scan& scan, const ScanParams& params, int keyframe,
                                const Pose2& T_keyframe_sensor);

/// Holds the marks of every scan drawn so far. Marks are whole numbers, so that a scan can be taken out again exactly
/// and the order of drawing does not matter. Not thread-safe.
class MapDrawer {
 public:
  MapDrawer(const MapParams& map, const ScanParams& scan) : map_(map), scan_(scan) {}

  /// Brings the drawing to these scans (earlier calls' scans first, in the same order) and keyframe poses; the map
  /// shows the unproved ones too, and they leave no mark. O(new and moved scans x their cells + cells of the map).
  [[nodiscard]] GridMap draw(const std::vector<std::shared_ptr<const MapScan>>& scans,
                             const std::vector<Pose2>& keyframes,
                             const std::vector<std::shared_ptr<const MapScan>>& unproved = {});

 private:
  struct Marks {
    std::int32_t hits{0};  ///< sums of weights in 1/256
    std::int32_t misses{0};
    std::uint32_t stamp{0};  ///< pass that touched the cell last; a cell counts once a scan
  };

  void include(double x, double y, double reach);
  void grow(int left, int below, int right, int above);
  void mark(const MapScan& scan, const Pose2& T_map_sensor, int sign);
  void markHits(const MapScan& scan, const Pose2& T_map_sensor, int sign);
  void clear(const Pose2& from, double bearing, double range, int weight);
  [[nodiscard]] GridMap toMap() const;
  [[nodiscard]] std::int8_t valueOf(int cell) const;
  [[nodiscard]] std::int32_t mostHitsAround(int cell) const;

  MapParams map_;
  ScanParams scan_;
  std::vector<Pose2> drawn_;  ///< where each scan was drawn
  std::vector<Marks> cells_;
  int first_x_{0};  ///< cell index of the grid's left column; the map frame's origin is the corner of cell 0
  int first_y_{0};
  int width_{0};
  int height_{0};
  std::uint32_t pass_{0};
};

}  // namespace yarm::slam
