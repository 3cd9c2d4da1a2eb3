// Every number of the localisation: default, unit and meaning once.
#pragma once

#include "yarm/slam/params.hpp"

#include <string>
#include <vector>

namespace yarm::slam {

/// How the map is read.
struct FieldParams {
  int occupied_at_least{65};  ///< cells from this value on are occupied
  int free_at_most{25};       ///< cells from 0 to this value are free
  double reach{1.0};          ///< m: surfaces farther than this are as good as none
};

/// Fitting points to the map's surfaces.
struct FitParams {
  double gate_first{0.40};           ///< m: farthest surface of a point in the first iteration
  double gate_last{0.15};            ///< m: in the last iterations; a point nearer than this agrees with the map
  int iterations{10};                ///< most Gauss-Newton steps
  double cauchy{2.0};                ///< sigmas: scale of the Cauchy weight
  double sigma_map{0.02};            ///< m: a surface lies this far from the centre of its cell
  double information_divisor{10.0};  ///< neighbouring points err together: information counts this much less
};

/// Finding the place in the whole map, or in a window of it.
struct SearchParams {
  double step{0.1};            ///< m: between the positions tried first
  double angle_step{0.0873};   ///< rad: between their headings
  double sigma_first{0.15};    ///< m: a point's likelihood falls off with this distance to a surface
  double sigma_last{0.06};     ///< m: the same for the score of the places that are left
  int points_first{120};       ///< points tried at every position
  int points_last{400};        ///< points of the final score
  int free_samples{300};       ///< places seen empty, which the map must not fill
  int candidates{300};         ///< best positions that are fitted
  double apart_m{0.3};         ///< m: places farther apart than this are different ones
  double apart_rad{0.26};      ///< rad: and so are headings
  double least_score{0.80};    ///< a place with less is doubtful
  double least_margin{0.10};   ///< so is one that leads the next by less
  double least_share{0.7};     ///< of the present scan's points must lie on surfaces there
  int least_points{60};        ///< fewer points than this find nothing
  double first_turn{6.1};      ///< rad: turned before the whole map is searched for the first time
  double first_way{2.0};       ///< m: or driven
  double next_turn{1.57};      ///< rad: turned between two searches of the whole map
  double next_way{0.5};        ///< m: or driven
  double window_sigmas{3.0};   ///< a given pose is looked for within this many of its standard deviations
  double window_turn{0.52};    ///< rad: turned between two searches around a given pose
  double window_way{0.3};      ///< m: or driven
  double point_spacing{0.04};  ///< m: the submap's points are thinned to this
  double free_spacing{0.15};   ///< m: and its empty places
};

/// Following the robot once its place is known.
struct TrackParams {
  int beams{120};                  ///< of a scan that are fitted
  double update_m{0.02};           ///< m: a scan is fitted after this way
  double update_rad{0.02};         ///< rad: or after this turn
  double sigma_m{0.004};           ///< m: odometry's deviation between two fits is the root of the squares of these:
  double sigma_rad{0.004};         ///< rad
  double sigma_m_rootm{0.05};      ///< m a root of a metre driven
  double sigma_rad_rootm{0.04};    ///< rad a root of a metre driven
  double sigma_rad_rootrad{0.05};  ///< rad a root of a radian turned
  double floor_m{0.01};            ///< m: no position is told as surer than this
  double floor_rad{0.005};         ///< rad: nor a heading
  double spread_m{0.10};           ///< m: a pose less sure than this is no place known
  double spread_rad{0.0873};       ///< rad: nor one with a heading less sure than this
  double least_share{0.4};         ///< of a scan's points must agree with the map
  int lost_updates{12};            ///< fits in a row with fewer end the tracking
  double lost_m{0.5};              ///< m: standard deviation of where the robot is looked for then
  double lost_rad{0.26};           ///< rad: and of its heading
};

/// All of them.
struct LocaliserParams {
  Params submap;  ///< the map maker that draws what has been seen so far; its `scan` part serves the tracking too
  FieldParams field;
  FitParams fit;
  SearchParams search;
  TrackParams track;
};

/// The numbers of the TurtleBot: as the defaults, with its scan.
[[nodiscard]] LocaliserParams turtlebotLocaliser();

/// What is wrong with parameters, one sentence each; empty when nothing is.
[[nodiscard]] std::vector<std::string> faultsOf(const LocaliserParams& params);

}  // namespace yarm::slam
