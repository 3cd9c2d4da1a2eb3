#include "yarm/ros/database.hpp"
#include "yarm/ros/standalone.hpp"

int main(int argc, char** argv) {
  return yarm::runStandalone<yarm::Database>(argc, argv, "database");
}
