#include "yarm/ros/amcl.hpp"
#include "yarm/ros/standalone.hpp"

int main(int argc, char** argv) {
  return yarm::runStandalone<yarm::Amcl>(argc, argv, "amcl");
}
