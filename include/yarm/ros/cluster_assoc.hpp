// Node cluster_assoc: clusters of the merged cloud, and whose points they are.
#pragma once

#include "yarm/perception/association.hpp"
#include "yarm/perception/camera_watch.hpp"
#include "yarm/ros/conversions.hpp"
#include "yarm/ros/executor.hpp"
#include "yarm/ros/node_params.hpp"
#include "yarm/ros/pool.hpp"
#include "yarm/ros/report.hpp"
#include "yarm/ros/tf_source.hpp"
#include "yarm/ros/tracks.hpp"
#include "yarm/sync/clock.hpp"
#include "yarm/sync/hand_words.hpp"
#include "yarm/sync/seed_buffer.hpp"

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Bool.h>
#include <std_msgs/Int8.h>

#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace yarm {

/// What travels from cluster_assoc to database within a process.
struct AssociatedFrame {
  perception::AssociatedSet set;
  perception::GridSpec grid;
};

/// In: merged_points, seed_transforms, object_registry, static_association_switch, <robot>/gripper/grasping (in
/// lock-step also <robot>/gripper/state), /tf. Out: cloud_clusters, associated_clusters, tracked_objects, tracks,
/// /diagnostics.
class ClusterAssoc : public PolledNode {
 public:
  /// The handles give the namespaces; callbacks run on the executor. Throws ParamError, std::invalid_argument.
  ClusterAssoc(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle);
  ~ClusterAssoc() override;

  void poll() override;
  bool waiting() const override { return !inbox_.empty(); }

 private:
  struct Arrival {
    boost::shared_ptr<perception::MergedSet> set;
    std::int64_t arrived_ns = 0;
  };

  void onPoints(const sensor_msgs::PointCloud2ConstPtr& message);
  void onSeeds(const ros::MessageEvent<const yarm::TransformStampedVector>& event);
  /// Says what of a message of seeds is left out, and whose it was.
  void refuseSeeds(const std::string& sender, const std::string& reason);
  void onRegistry(const yarm::ObjectRegistryConstPtr& message);
  void onSwitch(const std_msgs::Int8ConstPtr& message);
  /// Listens to the hand of each mobile robot of the registry, and to no others.
  void listenToHands(const yarm::ObjectRegistry& registry);
  /// Whether every hand has said how it is at a stamp; only in lock-step does one say so with stamps.
  bool handsKnown(perception::StampNs stamp_ns) const;
  /// Mobile robots whose hand holds something at a stamp.
  std::set<std::string> graspingAt(perception::StampNs stamp_ns);
  /// Starts afresh when the stamp shows that the simulator was started again.
  void noticeRestart(perception::StampNs stamp_ns);
  /// Whether everything a set needs is there, or has been waited for long enough.
  bool ready(const Arrival& arrival, std::int64_t now_ns);
  /// World <- link frames at the stamp; the newest pose where that is not known. False when one was missing.
  bool gatherLinks(perception::StampNs stamp_ns);
  void process(perception::MergedSet& set);
  void publishClusters(const perception::MergedSet& set);
  void publishAssociated(const perception::AssociatedSet& set);
  void diagnose();
  void diagnoseCameras();

  ClusterAssocParams params_;
  ros::NodeHandle handle_;
  MergeCloudsParams merge_node_;
  perception::MergeParams merge_;
  std::unique_ptr<perception::MergeBackend> backend_;
  std::unique_ptr<perception::Associator> associator_;
  std::shared_ptr<TfSource> tf_;
  std::int64_t wait_ns_ = 0;
  std::deque<Arrival> inbox_;
  SeedBuffer seeds_;
  perception::Knowledge knowledge_;
  std::vector<std::string> frames_;  ///< tf frames of all known links
  perception::LinkPoses links_;
  struct Hand {
    HandWords words;
    ros::Subscriber plain_in;    // <robot>/gripper/grasping
    ros::Subscriber stamped_in;  // <robot>/gripper/state, in lock-step
  };
  std::map<std::string, std::shared_ptr<Hand>> hands_;  ///< by mobile robot
  bool calibrating_ = true;
  bool registered_ = false;
  bool seeds_stalled_ = false;     ///< the last wait for seeds was in vain: no waiting until one comes
  bool links_stalled_ = false;     ///< the same for link poses
  std::int64_t last_seed_ns_ = 0;  ///< wall time
  ClockWatch sets_clock_;
  Pool<perception::MergedSet> sets_;
  Pool<AssociatedFrame> frames_pool_;
  ros::Subscriber points_in_;
  ros::Subscriber seeds_in_;
  ros::Subscriber registry_in_;
  ros::Subscriber switch_in_;
  ros::Publisher clusters_out_;
  ros::Publisher associated_out_;
  TrackPublisher tracks_;
  ThrottledWarning warn_;
  HealthReport health_;
  HealthReport camera_poses_;
  perception::CameraWatch watch_;
  std::int64_t sets_seen_ = 0;
  int processed_ = 0;
  int with_newest_seeds_ = 0;
  int refused_seeds_ = 0;
  std::string last_refusal_;
  double worst_lag_s_ = 0.0;
};

}  // namespace yarm
