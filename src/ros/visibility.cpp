#include "yarm/ros/visibility.hpp"

#include "yarm/ros/cell_markers.hpp"
#include "yarm/ros/conversions.hpp"
#include "yarm/ros/executor.hpp"
#include "yarm/ros/names.hpp"

#include <visualization_msgs/Marker.h>
#include <yarm/SeenCells.h>

#include <algorithm>

namespace yarm {

namespace {

using perception::CellState;
using visualization_msgs::Marker;

/// Indices of the cells for which something holds.
template <class Values, class Holds>
std::vector<std::int32_t> cellsWhere(const Values& values, Holds holds) {
  std::vector<std::int32_t> cells;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (holds(values[i])) {
      cells.push_back(static_cast<std::int32_t>(i));
    }
  }
  return cells;
}

Marker shade(Marker marker, float red, float green, float blue) {
  marker.color.r = red;
  marker.color.g = green;
  marker.color.b = blue;
  marker.color.a = 0.2F;
  return marker;
}

}  // namespace

CellVisibility::CellVisibility(ros::NodeHandle& handle, const MergeCloudsParams& params)
    : topics_(params.camera_topics),
      rate_(params.visibility_rate),
      age_rate_(params.age_rate),
      health_(handle, "merge_clouds: visibility") {
  seen_out_ = handle.advertise<yarm::SeenCells>(names::SEEN_CELLS, 10);
  hidden_out_ = handle.advertise<Marker>(names::HIDDEN_CELLS, 2);
  coverage_out_ = handle.advertise<Marker>(names::COVERAGE, 1, true);
  if (params.visibility) {
    grid_ = loadParams<ClusterAssocParams>(ros::NodeHandle(handle, params.grid_node)).assoc.grid;
    voter_ = std::make_unique<perception::VisibilityVoter>(grid_, params.mergeParams(), params.views, topics_.size());
  }
}

void CellVisibility::add(const std::vector<perception::CameraCloud>& clouds, const perception::MergedSet& set) {
  if (!voter_) {
    return;
  }
  voter_->vote(clouds, set, votes_);
  map_.update(votes_);
  if (voter_->views() != views_) {
    views_ = voter_->views();
    publishCoverage(set.stamp_ns);
  }
  publishSeen(set.stamp_ns);
  if (hidden_out_.getNumSubscribers() > 0 && steadyNow() - shown_ns_ >= static_cast<std::int64_t>(1e9 / rate_)) {
    shown_ns_ = steadyNow();
    publishHidden(set.stamp_ns);
  }
}

void CellVisibility::publishCoverage(perception::StampNs stamp_ns) {
  voter_->coverage(coverage_);
  const auto missing = cellsWhere(coverage_.through, [](std::uint16_t cameras) { return cameras == 0; });
  uncovered_ = missing.size();
  coverage_out_.publish(shade(cubes(grid_, stamp_ns, names::COVERAGE, missing), 1.F, 0.2F, 0.2F));
}

void CellVisibility::publishSeen(perception::StampNs stamp_ns) {
  seen_.cameras.clear();
  for (std::size_t camera = 0; camera < topics_.size(); ++camera) {
    seen_.cameras.push_back(voter_->place(camera));
  }
  map_.describe(votes_, coverage_, seen_);
  const auto message = boost::make_shared<yarm::SeenCells>();
  message->header.stamp = toTime(stamp_ns);
  message->header.frame_id = names::WORLD_FRAME;
  fillSeenCells(seen_, *message);
  if (!aged_ns_ || stamp_ns - *aged_ns_ >= static_cast<perception::StampNs>(0.999e9 / age_rate_)) {
    aged_ns_ = stamp_ns;
    map_.ages(message->age_s);
  }
  seen_out_.publish(message);
}

void CellVisibility::publishHidden(perception::StampNs stamp_ns) {
  const auto hidden = cellsWhere(
      map_.states(), [](CellState state) { return state == CellState::kHidden || state == CellState::kNeverSeen; });
  hidden_out_.publish(shade(cubes(grid_, stamp_ns, names::HIDDEN_CELLS, hidden), 0.3F, 0.3F, 0.3F));
}

void CellVisibility::diagnose() {
  if (!voter_ || !health_.due()) {
    return;
  }
  for (std::size_t camera = 0; camera < topics_.size(); ++camera) {
    if (!voter_->fault(camera).empty()) {
      health_.warn(topics_[camera] + ": " + voter_->fault(camera));
    }
  }
  const auto count = [this](CellState state) {
    return static_cast<double>(std::count(map_.states().begin(), map_.states().end(), state));
  };
  health_.value("cells free", count(CellState::kFree));
  health_.value("cells occupied", count(CellState::kOccupied));
  health_.value("cells hidden", count(CellState::kHidden));
  health_.value("cells never seen", count(CellState::kNeverSeen));
  health_.value("cells that no camera sees in the empty cell", static_cast<double>(uncovered_));
  health_.send("every camera tells what it sees through");
}

void CellVisibility::reset() {
  map_.reset();
  aged_ns_.reset();
}

}  // namespace yarm
