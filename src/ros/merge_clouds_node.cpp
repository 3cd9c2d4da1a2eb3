#include "yarm/ros/merge_clouds.hpp"
#include "yarm/ros/standalone.hpp"

int main(int argc, char** argv) {
  return yarm::runStandalone<yarm::MergeClouds>(argc, argv, "merge_clouds");
}
