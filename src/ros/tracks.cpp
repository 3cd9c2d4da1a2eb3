#include "yarm/ros/tracks.hpp"

#include "yarm/ros/conversions.hpp"
#include "yarm/ros/names.hpp"

#include <visualization_msgs/MarkerArray.h>

#include <cstdio>

namespace yarm {

namespace {

using visualization_msgs::Marker;

constexpr double kAheadS = 1.0;   // an arrow leads to where a thing will be
constexpr double kShaftM = 0.05;  // its thickness
constexpr double kTextM = 0.15;   // height of the letters
constexpr float kShown = 0.35F;   // opacity of a box
constexpr float kHidden = 0.12F;  // and of one whose thing is hidden

template <class Message>
Message vector(const Eigen::Vector3d& v) {
  Message message;
  message.x = v.x();
  message.y = v.y();
  message.z = v.z();
  return message;
}

Marker marker(perception::StampNs stamp_ns, const perception::TrackedObject& track, const char* space, int type) {
  Marker made;
  made.header.stamp = toTime(stamp_ns);
  made.header.frame_id = names::WORLD_FRAME;
  made.ns = space;
  made.id = track.number;
  made.type = type;
  made.pose.orientation.w = 1.0;
  made.color.r = 1.0F;
  made.color.g = 0.6F;
  made.color.a = 1.0F;
  return made;
}

void addMarkers(perception::StampNs stamp_ns, const perception::TrackedObject& track,
                visualization_msgs::MarkerArray& markers) {
  Marker box = marker(stamp_ns, track, "boxes", Marker::CUBE);
  box.pose.position = vector<geometry_msgs::Point>(track.position);
  box.scale = vector<geometry_msgs::Vector3>(track.extent.cwiseMax(kShaftM));
  box.color.a = track.hidden ? kHidden : kShown;
  markers.markers.push_back(box);
  Marker arrow = marker(stamp_ns, track, "ways", Marker::ARROW);
  arrow.points = {vector<geometry_msgs::Point>(track.position),
                  vector<geometry_msgs::Point>(track.position + kAheadS * track.velocity)};
  arrow.scale.x = kShaftM;
  arrow.scale.y = 2.0 * kShaftM;
  markers.markers.push_back(arrow);
  Marker text = marker(stamp_ns, track, "names", Marker::TEXT_VIEW_FACING);
  text.pose.position =
      vector<geometry_msgs::Point>(track.position + Eigen::Vector3d(0.0, 0.0, 0.5 * track.extent.z() + kTextM));
  text.scale.z = kTextM;
  char words[64];
  std::snprintf(words, sizeof(words), "%d: %.1f m/s%s", track.number, track.velocity.head<2>().norm(),
                track.hidden ? ", hidden" : "");
  text.text = words;
  markers.markers.push_back(text);
}

}  // namespace

void fillTracks(perception::StampNs stamp_ns, const std::vector<perception::TrackedObject>& tracks,
                yarm::TrackedObjects& message) {
  message.header.stamp = toTime(stamp_ns);
  message.header.frame_id = names::WORLD_FRAME;
  for (const perception::TrackedObject& track : tracks) {
    yarm::TrackedObject out;
    out.id = track.number;
    out.position = vector<geometry_msgs::Point>(track.position);
    out.velocity = vector<geometry_msgs::Vector3>(track.velocity);
    for (int row = 0; row < 6; ++row) {
      for (int column = 0; column < 6; ++column) {
        out.covariance[static_cast<std::size_t>(6 * row + column)] = track.covariance(row, column);
      }
    }
    out.extent = vector<geometry_msgs::Vector3>(track.extent);
    out.age_s = static_cast<double>(stamp_ns - track.first_seen_ns) * 1e-9;
    out.last_seen = toTime(track.last_seen_ns);
    out.hidden = track.hidden ? 1 : 0;
    message.objects.push_back(out);
  }
}

TrackPublisher::TrackPublisher(ros::NodeHandle& handle)
    : tracks_out_(handle.advertise<yarm::TrackedObjects>(names::TRACKED_OBJECTS, 10)),
      markers_out_(handle.advertise<visualization_msgs::MarkerArray>(names::TRACKS, 2)) {}

void TrackPublisher::publish(perception::StampNs stamp_ns, const std::vector<perception::TrackedObject>& tracks) {
  const auto message = boost::make_shared<yarm::TrackedObjects>();
  fillTracks(stamp_ns, tracks, *message);
  tracks_out_.publish(message);
  if (markers_out_.getNumSubscribers() == 0) {
    return;
  }
  const auto markers = boost::make_shared<visualization_msgs::MarkerArray>();
  Marker clear;
  clear.header.frame_id = names::WORLD_FRAME;
  clear.action = Marker::DELETEALL;  // those that have ended
  markers->markers.push_back(clear);
  for (const perception::TrackedObject& track : tracks) {
    addMarkers(stamp_ns, track, *markers);
  }
  markers_out_.publish(markers);
}

}  // namespace yarm
