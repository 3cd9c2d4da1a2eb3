#include "yarm/ros/in_process.hpp"

#include <map>
#include <mutex>

namespace yarm {

namespace {
std::mutex& guard() {
  static std::mutex mutex;
  return mutex;
}
std::map<std::string, int>& readers() {
  static std::map<std::string, int> counts;
  return counts;
}
}  // namespace

void addInProcessReader(const std::string& topic) {
  const std::lock_guard<std::mutex> lock(guard());
  ++readers()[topic];
}

void removeInProcessReader(const std::string& topic) {
  const std::lock_guard<std::mutex> lock(guard());
  --readers()[topic];
}

bool hasRemoteSubscribers(const ros::Publisher& publisher) {
  const std::lock_guard<std::mutex> lock(guard());
  const auto known = readers().find(publisher.getTopic());
  const unsigned own = known != readers().end() && known->second > 0 ? 1U : 0U;
  return publisher.getNumSubscribers() > own;
}

}  // namespace yarm
