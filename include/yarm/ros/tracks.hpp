// Part of node cluster_assoc: what moves and nobody registered, for whoever wants to know, and for RViz.
#pragma once

#include "yarm/perception/tracks.hpp"

#include <ros/ros.h>
#include <yarm/TrackedObjects.h>

#include <vector>

namespace yarm {

/// The followed things of a set as a message.
void fillTracks(perception::StampNs stamp_ns, const std::vector<perception::TrackedObject>& tracks,
                yarm::TrackedObjects& message);

/// Out: tracked_objects, tracks.
class TrackPublisher {
 public:
  explicit TrackPublisher(ros::NodeHandle& handle);

  /// Says what is followed after a set, each set.
  void publish(perception::StampNs stamp_ns, const std::vector<perception::TrackedObject>& tracks);

 private:
  ros::Publisher tracks_out_;
  ros::Publisher markers_out_;
};

}  // namespace yarm
