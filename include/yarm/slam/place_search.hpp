// Finding a robot's place in a known map from what it has seen around itself, with an answer to how sure that is.
//
// Every position and heading is tried on a likelihood raster (E. Olson, "Real-time correlative scan matching", ICRA
// 2009), the best are fitted and scored anew, and the best is held against the best of the other places: where the two
// are alike nothing is claimed.
#pragma once

#include "yarm/slam/distance_field.hpp"
#include "yarm/slam/field_fit.hpp"
#include "yarm/slam/localiser_params.hpp"
#include "yarm/slam/mapper.hpp"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace yarm::slam {

/// What the robot has seen around itself, in its own present frame.
struct Surroundings {
  std::vector<SeenPoint> points;       ///< on surfaces
  std::vector<Eigen::Vector2d> empty;  ///< places where nothing was
};

/// All that a map maker has seen, thinned; draws its map. `T_submap_base`: where the robot is in it.
[[nodiscard]] Surroundings surroundingsOf(Mapper& submap, const Pose2& T_submap_base, const SearchParams& params);

/// Where a place is looked for.
struct SearchWindow {
  Pose2 centre;        ///< of the robot, map frame
  double distance{0};  ///< half edge, metres
  double angle{0};     ///< half angle, radians
};

/// A place and what speaks for it.
struct Place {
  Pose2 pose;       ///< of the robot, map frame
  double score{0};  ///< mean likelihood of the points less the share of empty places that the map fills; at most 1
};

/// Answer of a search.
struct PlaceSearch {
  bool found{false};
  std::string reason;         ///< why not found
  FitResult best;             ///< of the best place, found or not
  double margin{0};           ///< its score less that of the second place
  std::vector<Place> places;  ///< different from each other, best first
};

/// Looks for the place in the whole map, or in a window. O(positions x headings x points).
[[nodiscard]] PlaceSearch searchPlace(const Surroundings& seen, const DistanceField& field,
                                      const std::optional<SearchWindow>& window, const LocaliserParams& params);

}  // namespace yarm::slam
