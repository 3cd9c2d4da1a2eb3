#include "yarm/ros/cluster_assoc.hpp"
#include "yarm/ros/standalone.hpp"

int main(int argc, char** argv) {
  return yarm::runStandalone<yarm::ClusterAssoc>(argc, argv, "cluster_assoc");
}
