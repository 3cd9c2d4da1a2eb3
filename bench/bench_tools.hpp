// What the benchmarks in C++ share: options as NAME=VALUE, processor time, percentiles.
#pragma once

#include <algorithm>
#include <ctime>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace yarm::bench {

/// Options by name, so that a number of a library can be tried without a build.
class Options {
 public:
  template <class Value>
  void number(const std::string& name, Value& value) {
    by_name_[name] = [&value](const std::string& text) {
      value = static_cast<std::decay_t<decltype(value)>>(std::stod(text));
    };
  }
  void text(const std::string& name, std::string& value) {
    by_name_[name] = [&value](const std::string& given) { value = given; };
  }

  /// Takes the command line. Throws std::invalid_argument naming what is known.
  void parse(int argc, char** argv) const {
    for (int i = 1; i < argc; ++i) {
      const std::string text = argv[i];
      const auto equals = text.find('=');
      const auto setter = by_name_.find(text.substr(0, equals));
      if (equals == std::string::npos || setter == by_name_.end()) {
        std::string known;
        for (const auto& entry : by_name_) {
          known += " " + entry.first;
        }
        throw std::invalid_argument("'" + text + "': options are NAME=VALUE with NAME one of:" + known);
      }
      setter->second(text.substr(equals + 1));
    }
  }

 private:
  std::map<std::string, std::function<void(const std::string&)>> by_name_;
};

/// Processor time of this process so far, seconds.
inline double cpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The value that this share of the values does not surpass; 0 of none.
inline double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0 : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

}  // namespace yarm::bench
