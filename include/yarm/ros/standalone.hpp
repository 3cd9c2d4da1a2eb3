// One perception node as a process of its own.
#pragma once

#include "yarm/ros/executor.hpp"

#include <ros/ros.h>

#include <exception>
#include <memory>

namespace yarm {

/// Runs a node until ROS is shut down; 1 when its parameters were refused.
template <class Node>
int runStandalone(int argc, char** argv, const char* name) {
  keepBuffers();
  ros::init(argc, argv, name);
  ros::NodeHandle handle;
  std::unique_ptr<Node> node;
  try {
    const auto paused = Executor::instance().pause();
    node = std::make_unique<Node>(handle, ros::NodeHandle("~"));
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  ros::waitForShutdown();
  const auto paused = Executor::instance().pause();
  node.reset();
  return 0;
}

}  // namespace yarm
