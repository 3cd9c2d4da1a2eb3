// The perception nodes as nodelets: the same classes as the standalone nodes.
#include <ros/ros.h>

#include "yarm/ros/cluster_assoc.hpp"
#include "yarm/ros/database.hpp"
#include "yarm/ros/merge_clouds.hpp"

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include <memory>

namespace yarm {

template <class Node>
class NodeletOf : public nodelet::Nodelet {
 public:
  ~NodeletOf() override {
    const auto paused = Executor::instance().pause();
    node_.reset();
  }

 private:
  void onInit() override {
    keepBuffers();
    const auto paused = Executor::instance().pause();
    node_ = std::make_unique<Node>(getNodeHandle(), getPrivateNodeHandle());
  }

  std::unique_ptr<Node> node_;
};

using MergeCloudsNodelet = NodeletOf<MergeClouds>;
using ClusterAssocNodelet = NodeletOf<ClusterAssoc>;
using DatabaseNodelet = NodeletOf<Database>;

}  // namespace yarm

PLUGINLIB_EXPORT_CLASS(yarm::MergeCloudsNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(yarm::ClusterAssocNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(yarm::DatabaseNodelet, nodelet::Nodelet)
