// Node merge_clouds: the cameras' clouds of one moment become one set of points and voxels in the world frame.
#pragma once

#include "yarm/perception/view.hpp"
#include "yarm/ros/conversions.hpp"
#include "yarm/ros/executor.hpp"
#include "yarm/ros/node_params.hpp"
#include "yarm/ros/pool.hpp"
#include "yarm/ros/report.hpp"
#include "yarm/ros/tf_source.hpp"
#include "yarm/ros/visibility.hpp"
#include "yarm/sync/clock.hpp"
#include "yarm/sync/set_assembler.hpp"

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace yarm {

/// In: the cameras' clouds, /tf, /tf_static. Out: merged_points, voxelized_cloud, seen_cells,
/// hidden_cells, coverage, /diagnostics.
class MergeClouds : public PolledNode {
 public:
  /// The handles give the namespaces; callbacks run on the executor. Throws ParamError, std::invalid_argument.
  MergeClouds(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle);
  ~MergeClouds() override;

  void poll() override;
  bool waiting() const override;

 private:
  struct Arrival {
    sensor_msgs::PointCloud2ConstPtr message;
    perception::CameraCloud view;
    std::int64_t arrived_ns = 0;
  };
  struct Camera {
    std::string topic;
    std::string frame;  ///< expected; empty for any
    ros::Subscriber subscriber;
    std::deque<Arrival> inbox;  ///< clouds that wait for their transform, or for the clock to confirm a restart
    std::int64_t newest_ns = 0;
    bool heard = false;
    bool lost = false;  ///< no transform for the last cloud: the next ones do not wait for theirs
    int dropped = 0;    ///< since the last diagnostics
    int late = 0;
    int absurd = 0;           ///< clouds with absurd points, since the last diagnostics
    std::string wrong_frame;  ///< the frame that was last complained of
    perception::View view;    ///< of the last cloud
    bool delivered = false;   ///< the last set has a cloud of it
    bool judged = false;      ///< a cloud's view was judged since the last diagnostics
    std::string last_fault;
    perception::Picture picture;  ///< what the last cloud told of the camera
  };

  void subscribe(std::size_t index);
  void onCloud(std::size_t index, const sensor_msgs::PointCloud2ConstPtr& message);
  /// Moves the first waiting cloud of a camera on; false when it must wait.
  bool settle(std::size_t index, std::int64_t now_ns);
  void refuseFrame(std::size_t index, const sensor_msgs::PointCloud2& message);
  /// Leaves a cloud out with a throttled warning.
  void drop(std::size_t index, const sensor_msgs::PointCloud2& message, const std::string& reason);
  /// Notes that a camera delivered nothing that can be used.
  void leaveOut(std::size_t index, const sensor_msgs::PointCloud2& message, const std::string& reason);
  void release(std::int64_t now_ns);
  void process(CameraSet<Arrival>& set);
  /// Notes in the set which cameras had no view; whether enough of them had one.
  bool judge(const CameraSet<Arrival>& set, perception::MergedSet& merged);
  std::string blindness() const;
  void publish(const boost::shared_ptr<perception::MergedSet>& set);
  void reset();
  void diagnose(std::int64_t now_ns);
  void diagnoseCamera(std::size_t index, std::int64_t now_ns);

  MergeCloudsParams params_;
  ros::NodeHandle handle_;
  std::unique_ptr<perception::MergeBackend> backend_;
  std::shared_ptr<TfSource> tf_;
  SetAssembler<Arrival> assembler_;
  perception::ViewWatch view_;
  perception::PictureWatch pictures_;
  std::vector<Camera> cameras_;
  std::int64_t wait_ns_ = 0;
  Pool<sensor_msgs::PointCloud2> clouds_;
  Pool<perception::MergedSet> sets_;
  ros::Publisher merged_;
  ros::Publisher voxels_;
  ClockWatch clock_;
  ThrottledWarning warn_;
  HealthReport health_;
  CellVisibility visibility_;
  std::optional<std::int64_t> published_ns_;
  int published_ = 0;
  int too_little_ = 0;  ///< sets with too little view since the last diagnostics
};

}  // namespace yarm
