#include "yarm/slam/c_api.hpp"

#include "yarm/slam/localiser.hpp"
#include "yarm/slam/mapper.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>

namespace slam = yarm::slam;

struct YarmMapper {
  slam::Mapper mapper;
  std::string reason;
  std::shared_ptr<const slam::GridMap> map;
};

struct YarmLocaliser {
  slam::Localiser localiser;
  std::string reason;
};

namespace {

slam::Pose2 poseOf(const YarmPose& pose) {
  return {pose.x, pose.y, slam::wrapAngle(pose.yaw)};
}

YarmPose given(const slam::Pose2& pose) {
  return {pose.x, pose.y, pose.yaw};
}

slam::Scan scanOf(const YarmScan& given) {
  slam::Scan scan;
  scan.stamp_ns = given.stamp_ns;
  scan.angle_min = given.angle_min;
  scan.angle_increment = given.angle_increment;
  scan.range_min = given.range_min;
  scan.range_max = given.range_max;
  scan.ranges.assign(given.ranges, given.ranges + given.beams);
  scan.T_base_sensor = poseOf(given.T_base_sensor);
  scan.T_odom_base = poseOf(given.T_odom_base);
  return scan;
}

slam::GridMap gridOf(const YarmGrid& given) {
  slam::GridMap grid{given.width, given.height, given.resolution, given.origin_x, given.origin_y, {}};
  grid.cells.assign(given.cells, given.cells + static_cast<std::ptrdiff_t>(given.width) * given.height);
  return grid;
}

}  // namespace

YarmMapper* yarmMapperMake(const YarmPose* T_map_base) {
  return new YarmMapper{slam::Mapper(slam::turtlebotParams(), poseOf(*T_map_base)), {}, {}};
}

void yarmMapperFree(YarmMapper* mapper) {
  delete mapper;
}

void yarmMapperAdd(YarmMapper* mapper, const YarmScan* scan, YarmMapped* answer) {
  const slam::ScanResult result = mapper->mapper.addScan(scanOf(*scan));
  mapper->reason = result.reason;
  *answer = {static_cast<std::int32_t>(result.status), mapper->reason.c_str(), given(result.T_map_base),
             given(result.T_map_odom)};
}

void yarmMapperDraw(YarmMapper* mapper, YarmGrid* grid) {
  mapper->mapper.requestMap();
  mapper->map = mapper->mapper.map();
  const slam::GridMap& map = *mapper->map;
  *grid = {map.width, map.height, map.resolution, map.origin_x, map.origin_y, map.cells.data()};
}

void yarmMapperCounts(const YarmMapper* mapper, std::int32_t* keyframes, std::int32_t* matched,
                      std::int32_t* unmatched) {
  const slam::Statistics& did = mapper->mapper.statistics();
  *keyframes = did.keyframes;
  *matched = did.matched;
  *unmatched = did.unmatched;
}

YarmLocaliser* yarmLocaliserMake(const YarmGrid* map, const YarmPose* T_map_grid, char* why, std::int32_t size) {
  try {
    return new YarmLocaliser{slam::Localiser(slam::turtlebotLocaliser(), gridOf(*map), poseOf(*T_map_grid)), {}};
  } catch (const std::exception& error) {
    std::snprintf(why, static_cast<std::size_t>(size), "%s", error.what());
    return nullptr;
  }
}

void yarmLocaliserFree(YarmLocaliser* localiser) {
  delete localiser;
}

void yarmLocaliserForget(YarmLocaliser* localiser) {
  localiser->localiser.forget();
}

const char* yarmLocaliserBelieve(YarmLocaliser* localiser, const YarmPose* T_map_base, const double* covariance) {
  slam::PoseBelief belief;
  belief.pose = poseOf(*T_map_base);
  belief.covariance = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(covariance);
  localiser->reason = localiser->localiser.believe(belief);
  return localiser->reason.c_str();
}

void yarmLocaliserFitNext(YarmLocaliser* localiser) {
  localiser->localiser.fitNext();
}

void yarmLocaliserAdd(YarmLocaliser* localiser, const YarmScan* scan, YarmLocalised* answer) {
  const slam::LocaliserResult result = localiser->localiser.addScan(scanOf(*scan));
  localiser->reason = result.reason;
  *answer = {result.dropped,
             static_cast<std::int32_t>(result.state),
             result.localised,
             result.has_pose,
             localiser->reason.c_str(),
             given(result.T_map_base),
             given(result.T_map_odom),
             {},
             result.agreement};
  std::copy_n(result.covariance.data(), 9, answer->covariance);
}
