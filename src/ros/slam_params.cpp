// Prints every parameter of slam_gmapping and amcl, one a line: node, name, default, unit, allowed, meaning.
#include "yarm/ros/amcl_params.hpp"
#include "yarm/ros/slam_gmapping_params.hpp"

#include <iostream>

int main() {
  yarm::printParams<yarm::SlamGmappingParams>(std::cout);
  yarm::printParams<yarm::AmclParams>(std::cout);
  return 0;
}
