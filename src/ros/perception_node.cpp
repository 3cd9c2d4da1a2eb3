// All perception nodes as nodelets of one process: clouds are handed over by pointer. Each keeps its own name, private
// parameters and remappings. They are linked in, and nobody can load or unload any through the process.
#include <ros/ros.h>

#include "yarm/ros/cluster_assoc.hpp"
#include "yarm/ros/database.hpp"
#include "yarm/ros/merge_clouds.hpp"
#include "yarm/ros/nodelet_of.hpp"

#include <nodelet/loader.h>

#include <boost/function.hpp>
#include <boost/make_shared.hpp>

#include <array>
#include <exception>
#include <string>

namespace {

boost::shared_ptr<nodelet::Nodelet> made(const std::string& name) {
  if (name == "database") {
    return boost::make_shared<yarm::NodeletOf<yarm::Database>>();
  }
  if (name == "cluster_assoc") {
    return boost::make_shared<yarm::NodeletOf<yarm::ClusterAssoc>>();
  }
  return boost::make_shared<yarm::NodeletOf<yarm::MergeClouds>>();
}

}  // namespace

int main(int argc, char** argv) {
  yarm::keepBuffers();
  ros::init(argc, argv, "perception");
  nodelet::Loader loader{boost::function<boost::shared_ptr<nodelet::Nodelet>(const std::string&)>(made)};
  const std::array<const char*, 3> nodes{"database", "cluster_assoc", "merge_clouds"};
  for (const char* node : nodes) {
    try {
      if (!loader.load(ros::names::resolve(node), node, ros::names::getRemappings(), {})) {
        ROS_FATAL("%s could not be loaded; see above", node);
        return 1;
      }
    } catch (const std::exception& error) {
      ROS_FATAL("%s: %s", node, error.what());
      return 1;
    }
  }
  ros::spin();
  return 0;
}
