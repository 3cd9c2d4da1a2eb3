// Prints every parameter of the perception nodes, one a line: node, name, default, unit, allowed, meaning.
#include "yarm/ros/node_params.hpp"

#include <iostream>

int main() {
  yarm::printParams<yarm::MergeCloudsParams>(std::cout);
  yarm::printParams<yarm::ClusterAssocParams>(std::cout);
  yarm::printParams<yarm::DatabaseParams>(std::cout);
  return 0;
}
