#include "yarm/ros/database.hpp"

#include "yarm/ros/cell_markers.hpp"
#include "yarm/ros/conversions.hpp"
#include "yarm/ros/in_process.hpp"
#include "yarm/ros/names.hpp"
#include "yarm/ros/prediction.hpp"
#include "yarm/ros/side_object.hpp"

#include <algorithm>
#include <array>

namespace yarm {

namespace {

using perception::GridSpec;
using visualization_msgs::Marker;

constexpr std::size_t kMostSeenWaiting = 32;  // for their maps

std::vector<std::string> namesOf(const perception::AssociatedSet& set) {
  std::vector<std::string> names;
  for (const perception::AssociatedObject& object : set.objects) {
    names.push_back(object.name);
  }
  return names;
}

std_msgs::ColorRGBA colour(std::size_t number) {
  static constexpr std::array<std::array<float, 3>, 8> palette{{{0.12F, 0.47F, 0.71F},
                                                                {1.00F, 0.50F, 0.05F},
                                                                {0.17F, 0.63F, 0.17F},
                                                                {0.58F, 0.40F, 0.74F},
                                                                {0.55F, 0.34F, 0.29F},
                                                                {0.89F, 0.47F, 0.76F},
                                                                {0.74F, 0.74F, 0.13F},
                                                                {0.09F, 0.75F, 0.81F}}};
  const auto& rgb = palette[number % palette.size()];
  std_msgs::ColorRGBA made;
  made.r = rgb[0];
  made.g = rgb[1];
  made.b = rgb[2];
  made.a = 0.8F;
  return made;
}

}  // namespace

Database::Database(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle)
    : params_(loadParams<DatabaseParams>(private_handle)),
      handle_(handle),
      health_(handle, "database: input"),
      last_set_ns_(steadyNow()) {
  handle_.setCallbackQueue(&Executor::instance().queue());
  metadata_out_ = handle_.advertise<yarm::MapMetaData>(names::PLANNING_METADATA, 10);
  collisions_out_ = handle_.advertise<Marker>(names::COLLISIONS, 10);
  occupancy_out_ = handle_.advertise<visualization_msgs::MarkerArray>(names::OCCUPANCY, 10);
  predict_ = handle_.advertiseService(names::PREDICT_NEW_STATE, &Database::onPredict, this);
  seen_in_ = handle_.subscribe(names::SEEN_CELLS, 32, &Database::onSeen, this, ros::TransportHints().tcpNoDelay());
  associated_in_ = handle_.subscribe(names::ASSOCIATED_CLUSTERS, 32, &Database::onAssociated, this,
                                     ros::TransportHints().tcpNoDelay());
  addInProcessReader(associated_in_.getTopic());
  Executor::instance().add(*this);
}

Database::~Database() {
  removeInProcessReader(associated_in_.getTopic());
  Executor::instance().remove(*this);
}

void Database::poll() {
  if (!health_.due()) {
    return;
  }
  const double silent_s = static_cast<double>(steadyNow() - last_set_ns_) * 1e-9;
  if (silent_s > 1.0) {
    health_.warn(associated_in_.getTopic() + ": silent for " + std::to_string(silent_s) + " s");
  }
  health_.value("sets", published_);
  health_.value("objects", present_ ? static_cast<double>(present_->set.objects.size()) : 0.0);
  health_.send(std::to_string(published_) + " sets");
  published_ = 0;
}

void Database::onAssociated(const yarm::AssociatedClusterVectorConstPtr& message) {
  last_set_ns_ = steadyNow();
  boost::shared_ptr<AssociatedFrame> frame = sideOf<AssociatedFrame>(message);
  if (!frame) {
    frame = frames_pool_.acquire();
    const Read<bool> read = readAssociated(*message, frame->set, frame->grid);
    if (!read.ok()) {
      warn_(names::ASSOCIATED_CLUSTERS, associated_in_.getTopic() + ": set dropped: " + read.reason);
      return;
    }
  }
  present_ = frame;
  const GridSpec& grid = frame->grid;
  if (!builder_ || grid.size != builder_grid_.size || grid.min != builder_grid_.min || grid.max != builder_grid_.max) {
    builder_ = std::make_unique<perception::OccupancyBuilder>(grid);
    hiders_ = std::make_unique<perception::HiderFinder>(grid);
    builder_grid_ = grid;
  }
  const perception::OccupancyGrid& occupancy = builder_->build(frame->set);
  publishMetadata(occupancy);
  publishMarkers(occupancy);
  ++published_;
}

void Database::publishMetadata(const perception::OccupancyGrid& grid) {
  const perception::AssociatedSet& set = present_->set;
  const auto message = boost::make_shared<yarm::MapMetaData>();
  message->header.stamp = toTime(set.stamp_ns);
  message->header.frame_id = names::WORLD_FRAME;
  message->gx = grid.spec.size[0];
  message->gy = grid.spec.size[1];
  message->gz = grid.spec.size[2];
  message->xmin = grid.spec.min[0];
  message->xmax = grid.spec.max[0];
  message->ymin = grid.spec.min[1];
  message->ymax = grid.spec.max[1];
  message->zmin = grid.spec.min[2];
  message->zmax = grid.spec.max[2];
  message->frames = namesOf(set);
  message->UIDs = uids_.update(message->frames);
  for (std::size_t i = 0; i < set.objects.size(); ++i) {
    const perception::AssociatedObject& object = set.objects[i];
    message->objects.push_back(toString(object.object));
    geometry_msgs::TransformStamped pose;
    pose.header.stamp = toTime(object.stamp_ns);
    pose.header.frame_id = names::WORLD_FRAME;
    pose.child_frame_id = object.name;
    fillTransform(object.T_world_seed, pose.transform);
    message->seed_poses.push_back(pose);
    yarm::GridIndexVector cells;
    cells.indices = cellsOf(grid.spec, grid.object_cells[i]);
    message->grid_indices.push_back(std::move(cells));
    if (object.piece) {
      message->pieces.push_back(pieceMessage(object.name, *object.piece));
    }
    if (object.carried) {
      message->carried.push_back(carriedMessage(object.name, *object.carried));
    }
  }
  message->grid.assign(grid.cells.begin(), grid.cells.end());
  message->collisions = cellsOf(grid.spec, grid.collisions);
  addVisibility(grid, *message);
  metadata_out_.publish(message);
}

void Database::onSeen(const yarm::SeenCellsConstPtr& message) {
  if (!seen_inbox_.empty() && message->header.stamp < seen_inbox_.back()->header.stamp) {
    seen_inbox_.clear();  // the clock went back
  }
  seen_inbox_.push_back(message);
  if (seen_inbox_.size() > kMostSeenWaiting) {
    seen_inbox_.pop_front();
  }
}

void Database::addVisibility(const perception::OccupancyGrid& grid, yarm::MapMetaData& message) {
  while (!seen_inbox_.empty() && seen_inbox_.front()->header.stamp < message.header.stamp) {
    seen_inbox_.pop_front();
  }
  if (seen_inbox_.empty() || seen_inbox_.front()->header.stamp != message.header.stamp) {
    return;
  }
  const yarm::SeenCells& seen = *seen_inbox_.front();
  const Read<bool> read = readSeenCells(seen, grid.spec.count(), seen_);
  if (!read.ok()) {
    warn_(names::SEEN_CELLS, seen_in_.getTopic() + ": left out: " + read.reason);
    return;
  }
  message.visibility = seen.states;
  message.hidden_by = hiders_->find(grid, seen_);
  message.age_s = seen.age_s;
}

void Database::publishMarkers(const perception::OccupancyGrid& grid) {
  if (collisions_out_.getNumSubscribers() > 0) {
    Marker marker = cubes(grid.spec, present_->set.stamp_ns, names::COLLISIONS, grid.collisions);
    marker.color.r = 1.0F;
    marker.color.a = 1.0F;
    collisions_out_.publish(boost::make_shared<Marker>(std::move(marker)));
  }
  const auto period_ns = static_cast<std::int64_t>(1e9 / params_.marker_rate);
  if (occupancy_out_.getNumSubscribers() > 0 && steadyNow() - last_view_ns_ >= period_ns) {
    last_view_ns_ = steadyNow();
    publishOccupancy(grid);
  }
}

void Database::publishOccupancy(const perception::OccupancyGrid& grid) {
  const auto view = boost::make_shared<visualization_msgs::MarkerArray>();
  Marker clear;
  clear.header.frame_id = names::WORLD_FRAME;
  clear.action = Marker::DELETEALL;  // objects that left
  view->markers.push_back(clear);
  for (std::size_t object = 0; object < grid.object_cells.size(); ++object) {
    if (!grid.object_cells[object].empty()) {
      const std::string& name = present_->set.objects[object].name;
      view->markers.push_back(cubes(grid.spec, present_->set.stamp_ns, name, grid.object_cells[object]));
      view->markers.back().color = colour(object);
    }
  }
  occupancy_out_.publish(view);
}

bool Database::onPredict(yarm::PredictNewState::Request& request, yarm::PredictNewState::Response& response) {
  response.collision = true;
  if (!present_) {
    response.message = "refused: no camera set has been seen yet";
    return true;
  }
  answerPrediction(request, present_->set, present_->grid, params_.point_radius, response);
  return true;
}

}  // namespace yarm
