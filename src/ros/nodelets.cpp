// The perception nodes as nodelets, for anybody's manager.
#include <ros/ros.h>

#include "yarm/ros/cluster_assoc.hpp"
#include "yarm/ros/database.hpp"
#include "yarm/ros/merge_clouds.hpp"
#include "yarm/ros/nodelet_of.hpp"

#include <pluginlib/class_list_macros.hpp>

namespace yarm {

using MergeCloudsNodelet = NodeletOf<MergeClouds>;
using ClusterAssocNodelet = NodeletOf<ClusterAssoc>;
using DatabaseNodelet = NodeletOf<Database>;

}  // namespace yarm

PLUGINLIB_EXPORT_CLASS(yarm::MergeCloudsNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(yarm::ClusterAssocNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(yarm::DatabaseNodelet, nodelet::Nodelet)
