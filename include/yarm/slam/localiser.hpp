// Where a robot is in a known map: found from nothing or from a rough pose, then followed; doubt is told, not hidden.
#pragma once

#include "yarm/slam/distance_field.hpp"
#include "yarm/slam/field_fit.hpp"
#include "yarm/slam/localiser_params.hpp"
#include "yarm/slam/mapper.hpp"
#include "yarm/slam/place_search.hpp"
#include "yarm/slam/types.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace yarm::slam {

/// A Gaussian of a pose; covariance over (x, y, yaw) along the map's axes.
struct PoseBelief {
  Pose2 pose;
  Eigen::Matrix3d covariance{Eigen::Matrix3d::Identity()};
};

/// What the localiser is about.
enum class LocaliserState {
  kSearching,  ///< no pose is believed; the whole map is searched once enough has been seen
  kChecking,   ///< a rough pose is believed, and looked for around it
  kTracking,   ///< the place is known and followed
};

/// Name of a state, for messages.
[[nodiscard]] const char* toString(LocaliserState state);

/// Answer to one scan.
struct LocaliserResult {
  bool dropped{false};  ///< the scan was refused; the reason says why
  LocaliserState state{LocaliserState::kSearching};
  bool localised{false};  ///< tracking, sure enough, and the scans agree with the map
  std::string reason;     ///< why not localised, and what would help
  bool has_pose{false};   ///< false while nothing is believed: what follows means nothing
  bool updated{false};    ///< the scan was fitted, or a search has ended
  Pose2 T_map_base;       ///< at the scan's time
  Pose2 T_map_odom;
  Eigen::Matrix3d covariance{Eigen::Matrix3d::Identity()};  ///< of T_map_base, over (x, y, yaw) along the map's axes
  double agreement{0};                                      ///< share of the last fitted scan's points on surfaces
};

/// Follows one robot in one map. Scans must come in the order of their stamps, from one thread. Deterministic.
class Localiser {
 public:
  /// `T_map_grid`: the map's frame <- the grid's own (for grids whose origin is turned). Begins with no pose.
  /// Throws std::invalid_argument naming every fault of the parameters, or of the map.
  Localiser(const LocaliserParams& params, const GridMap& map, const Pose2& T_map_grid = {});

  /// Forgets the pose: the whole map is searched as soon as the robot has turned round once or driven a way.
  void forget();
  /// Takes over a rough pose; it is looked for around it, and from then on followed. A belief that is not finite, or
  /// whose covariance is no covariance, is refused with the reason.
  std::string believe(const PoseBelief& belief);
  /// Forgets the pose and the scans' stamps; for time that went back.
  void restart();
  /// Has the next scan fitted even when the robot stands.
  void fitNext() { fit_next_ = true; }
  /// Takes one scan. A fault of the scan is answered by `dropped` with the reason, and changes nothing.
  LocaliserResult addScan(const Scan& scan);

  /// Draws poses from what is believed: the Gaussian, the places of the last search by their scores, or, before any,
  /// the map's free cells.
  [[nodiscard]] std::vector<Pose2> sample(int count, std::mt19937_64& random) const;
  [[nodiscard]] LocaliserState state() const { return state_; }
  /// Why it is not localised; empty when it is.
  [[nodiscard]] const std::string& doubt() const { return doubt_; }
  /// The last search of places, empty before the first.
  [[nodiscard]] const PlaceSearch& lastSearch() const { return search_; }
  /// Searches of the whole map since the pose was forgotten or lost.
  [[nodiscard]] int wideSearches() const { return wide_searches_; }

 private:
  void begin(LocaliserState state);
  [[nodiscard]] std::string faultOfScan(const Scan& scan) const;
  void moveOn(const Scan& scan);
  void track(const Scan& scan);
  void seek(const Scan& scan);
  [[nodiscard]] bool widelyDue() const;
  [[nodiscard]] bool narrowlyDue() const;
  void searchIn(const std::optional<SearchWindow>& window, const Pose2& T_submap_base, const Scan& scan);
  void settle(const FitResult& place, const Scan& scan);
  void judge();
  void lose(const std::string& why);
  [[nodiscard]] std::string spreadFault() const;
  [[nodiscard]] LocaliserResult resultFor(const Scan& scan) const;
  [[nodiscard]] Eigen::Matrix3d toldCovariance() const;

  LocaliserParams params_;
  Pose2 T_map_grid_;
  DistanceField field_;
  std::unique_ptr<Mapper> submap_;  ///< what has been seen since the search began; none while tracking
  LocaliserState state_{LocaliserState::kSearching};
  PoseBelief belief_;  ///< of the robot at the last scan, grid frame; unused while searching
  PlaceSearch search_;
  int wide_searches_{0};
  std::string doubt_;  ///< why not localised
  bool fit_next_{false};
  bool updated_{false};
  double agreement_{0};
  int disagreeing_{0};  ///< fits in a row with too few points on surfaces
  // Motion since the last fit, and since the last searches.
  double way_m_{0}, turn_rad_{0};
  double seen_way_m_{0}, seen_turn_rad_{0};          ///< since the submap was begun
  double searched_way_m_{0}, searched_turn_rad_{0};  ///< of these at the last search
  bool begun_{false};
  Pose2 T_odom_base_;
  std::int64_t stamp_ns_{0};
};

}  // namespace yarm::slam
