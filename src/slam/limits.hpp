// Parameters that lie outside their limits, gathered.
#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace yarm::slam {

/// Notes the values that lie outside their limits, one sentence each.
class LimitChecker {
 public:
  void operator()(const char* name, double value, double low, double high) {
    if (!(value >= low && value <= high)) {
      std::ostringstream text;
      text << name << " = " << value << ": must be " << low << " to " << high;
      faults.push_back(text.str());
    }
  }
  std::vector<std::string> faults;
};

}  // namespace yarm::slam
