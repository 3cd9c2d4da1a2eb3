// What a node says about itself: throttled warnings and one status on /diagnostics.
#pragma once

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <ros/ros.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace yarm {

/// Repeats a warning about the same thing at most once in a period of wall time.
class ThrottledWarning {
 public:
  explicit ThrottledWarning(double period_s = 5.0) : period_s_(period_s) {}

  /// key: what the warning is about; text: what to say.
  void operator()(const std::string& key, const std::string& text);

 private:
  double period_s_;
  std::map<std::string, std::int64_t> said_ns_;
};

/// Collects faults and values between two messages on /diagnostics.
class HealthReport {
 public:
  /// name: of the status; part: of the system it belongs to.
  HealthReport(const ros::NodeHandle& handle, const std::string& name, const std::string& part = "perception");

  /// Whether a second of wall time has passed since the last message.
  bool due() const;

  /// A fault that the node goes on with.
  void warn(const std::string& fault) { faults_.push_back(fault); }
  /// A fault that the node cannot go on with.
  void error(const std::string& fault);
  /// A figure to show, in every message or not.
  void value(const std::string& key, const std::string& value);
  void value(const std::string& key, double value);

  /// Sends what was collected, with "ok_text" when there are no faults, and starts afresh.
  void send(const std::string& ok_text);

 private:
  ros::Publisher publisher_;
  std::string name_;
  std::string part_;
  std::vector<std::string> faults_;
  bool failing_ = false;
  std::vector<diagnostic_msgs::KeyValue> values_;
  std::int64_t sent_ns_ = 0;
};

}  // namespace yarm
