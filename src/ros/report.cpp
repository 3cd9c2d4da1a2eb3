#include "yarm/ros/report.hpp"

#include "yarm/ros/executor.hpp"
#include "yarm/ros/names.hpp"

#include <diagnostic_msgs/DiagnosticArray.h>

#include <cstdio>
#include <cstdlib>

namespace yarm {

void ThrottledWarning::operator()(const std::string& key, const std::string& text) {
  const std::int64_t now_ns = steadyNow();
  const auto known = said_ns_.find(key);
  if (known != said_ns_.end() && static_cast<double>(now_ns - known->second) < period_s_ * 1e9) {
    return;
  }
  said_ns_[key] = now_ns;
  ROS_WARN_STREAM(text);
}

HealthReport::HealthReport(const ros::NodeHandle& handle, const std::string& name, const std::string& part)
    : name_(name), part_(part), sent_ns_(steadyNow()) {
  ros::NodeHandle advertiser(handle);
  publisher_ = advertiser.advertise<diagnostic_msgs::DiagnosticArray>(names::DIAGNOSTICS, 10);
}

void HealthReport::error(const std::string& fault) {
  faults_.push_back(fault);
  failing_ = true;
}

bool HealthReport::due() const {
  return steadyNow() - sent_ns_ > 1'000'000'000;
}

void HealthReport::value(const std::string& key, const std::string& value) {
  diagnostic_msgs::KeyValue pair;
  pair.key = key;
  pair.value = value;
  values_.push_back(pair);
}

void HealthReport::value(const std::string& key, double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.3f", value);
  this->value(key, std::string(text));
}

void HealthReport::send(const std::string& ok_text) {
  const char* restarts = std::getenv("YARM_RESTARTS");  // of yarm.safety.supervise
  const char* last_end = std::getenv("YARM_LAST_END");
  if (restarts != nullptr && last_end != nullptr) {
    value("started again", std::string(restarts));
    value("the one before", std::string(last_end));
  }
  diagnostic_msgs::DiagnosticStatus status;
  using diagnostic_msgs::DiagnosticStatus;
  const auto worst = failing_ ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN;
  status.level = faults_.empty() ? DiagnosticStatus::OK : worst;
  status.name = name_;
  status.hardware_id = part_;
  status.message = faults_.empty() ? ok_text : "";
  for (const std::string& fault : faults_) {
    status.message += (status.message.empty() ? "" : "; ") + fault;
  }
  status.values = std::move(values_);
  diagnostic_msgs::DiagnosticArray array;
  array.header.stamp = ros::Time::now();
  array.status.push_back(std::move(status));
  publisher_.publish(array);
  faults_.clear();
  failing_ = false;
  values_.clear();
  sent_ns_ = steadyNow();
}

}  // namespace yarm
