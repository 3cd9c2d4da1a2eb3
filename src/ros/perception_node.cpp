// All perception nodes as nodelets of one process: clouds are handed over by pointer. Each keeps its own name, private
// parameters and remappings.
#include <ros/ros.h>

#include "yarm/ros/executor.hpp"

#include <nodelet/loader.h>

#include <array>
#include <exception>
#include <utility>

int main(int argc, char** argv) {
  yarm::keepBuffers();
  ros::init(argc, argv, "perception");
  nodelet::Loader loader(true);
  const std::array<std::pair<const char*, const char*>, 3> nodes{
      {{"database", "yarm/Database"}, {"cluster_assoc", "yarm/ClusterAssoc"}, {"merge_clouds", "yarm/MergeClouds"}}};
  for (const auto& node : nodes) {
    try {
      if (!loader.load(ros::names::resolve(node.first), node.second, ros::names::getRemappings(), {})) {
        ROS_FATAL("%s could not be loaded; see above", node.first);
        return 1;
      }
    } catch (const std::exception& error) {
      ROS_FATAL("%s: %s", node.first, error.what());
      return 1;
    }
  }
  ros::spin();
  return 0;
}
