#include "yarm/ros/slam_gmapping.hpp"
#include "yarm/ros/standalone.hpp"

int main(int argc, char** argv) {
  return yarm::runStandalone<yarm::SlamGmapping>(argc, argv, "slam_gmapping");
}
