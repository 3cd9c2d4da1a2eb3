#include "yarm/slam/localiser_params.hpp"

#include "limits.hpp"

#include <cmath>

namespace yarm::slam {

namespace {

void checkSearch(const SearchParams& search, LimitChecker& check) {
  check("search.step", search.step, 0.01, 1.0);
  check("search.angle_step", search.angle_step, 0.01, 1.0);
  check("search.sigma_first", search.sigma_first, 0.01, 1.0);
  check("search.sigma_last", search.sigma_last, 0.01, 1.0);
  check("search.points_first", search.points_first, 10, 250);
  check("search.points_last", search.points_last, 10, 100000);
  check("search.free_samples", search.free_samples, 1, 100000);
  check("search.candidates", search.candidates, 2, 100000);
  check("search.apart_m", search.apart_m, 0.01, 100.0);
  check("search.apart_rad", search.apart_rad, 0.01, M_PI);
  check("search.least_score", search.least_score, 0.0, 1.0);
  check("search.least_margin", search.least_margin, 0.0, 1.0);
  check("search.least_share", search.least_share, 0.0, 1.0);
  check("search.least_points", search.least_points, 3, 100000);
  check("search.first_turn", search.first_turn, 0.1, 100.0);
  check("search.first_way", search.first_way, 0.1, 100.0);
  check("search.next_turn", search.next_turn, 0.1, 100.0);
  check("search.next_way", search.next_way, 0.1, 100.0);
  check("search.window_sigmas", search.window_sigmas, 0.5, 10.0);
  check("search.window_turn", search.window_turn, 0.01, 100.0);
  check("search.window_way", search.window_way, 0.01, 100.0);
  check("search.point_spacing", search.point_spacing, 0.001, 1.0);
  check("search.free_spacing", search.free_spacing, 0.01, 1.0);
}

void checkTrack(const TrackParams& track, LimitChecker& check) {
  check("track.beams", track.beams, 12, 20000);
  check("track.update_m", track.update_m, 0.0, 10.0);
  check("track.update_rad", track.update_rad, 0.0, M_PI);
  check("track.sigma_m", track.sigma_m, 1e-4, 1.0);
  check("track.sigma_rad", track.sigma_rad, 1e-4, 1.0);
  check("track.sigma_m_rootm", track.sigma_m_rootm, 0.0, 1.0);
  check("track.sigma_rad_rootm", track.sigma_rad_rootm, 0.0, 1.0);
  check("track.sigma_rad_rootrad", track.sigma_rad_rootrad, 0.0, 1.0);
  check("track.floor_m", track.floor_m, 0.0, 1.0);
  check("track.floor_rad", track.floor_rad, 0.0, 1.0);
  check("track.spread_m", track.spread_m, 0.001, 10.0);
  check("track.spread_rad", track.spread_rad, 0.001, M_PI);
  check("track.least_share", track.least_share, 0.0, 1.0);
  check("track.lost_updates", track.lost_updates, 1, 10000);
  check("track.lost_m", track.lost_m, 0.01, 100.0);
  check("track.lost_rad", track.lost_rad, 0.01, M_PI);
}

}  // namespace

LocaliserParams turtlebotLocaliser() {
  LocaliserParams params;
  params.submap.scan = turtlebotScan();
  return params;
}

std::vector<std::string> faultsOf(const LocaliserParams& params) {
  LimitChecker check;
  check.faults = faultsOf(params.submap);
  check("field.occupied_at_least", params.field.occupied_at_least, params.field.free_at_most + 1, 100);
  check("field.free_at_most", params.field.free_at_most, 0, 99);
  check("field.reach", params.field.reach, 0.1, 10.0);
  check("fit.gate_last", params.fit.gate_last, 0.01, params.field.reach);
  check("fit.gate_first", params.fit.gate_first, params.fit.gate_last, params.field.reach);
  check("fit.iterations", params.fit.iterations, 1, 100);
  check("fit.cauchy", params.fit.cauchy, 0.1, 100.0);
  check("fit.sigma_map", params.fit.sigma_map, 1e-3, 1.0);
  check("fit.information_divisor", params.fit.information_divisor, 0.1, 1000.0);
  checkSearch(params.search, check);
  checkTrack(params.track, check);
  return check.faults;
}

}  // namespace yarm::slam
