// Which topics are read by a node of this same process: then a message need not be filled for that reader.
#pragma once

#include <ros/ros.h>

#include <string>

namespace yarm {

/// Says that this process reads a topic by its side object (see side_object.hpp). `topic` is a resolved name.
void addInProcessReader(const std::string& topic);
/// Takes that back.
void removeInProcessReader(const std::string& topic);

/// Whether anybody but this process's own reader listens; roscpp counts all readers of a process as one subscriber.
bool hasRemoteSubscribers(const ros::Publisher& publisher);

}  // namespace yarm
