// Which objects are bolted together or rest on one another.
#pragma once

#include "yarm/perception/types.hpp"

#include <string>
#include <unordered_map>
#include <vector>

namespace yarm::perception {

/// Learns it in calibration, when mobile robots stand apart: what shares cells then belongs together.
class Attachments {
 public:
  /// Learns from the objects of a set, seen and hidden points filled in.
  void learn(const std::vector<AssociatedObject>& objects, const GridSpec& grid);
  /// Static objects that an object is attached to.
  [[nodiscard]] const std::vector<std::string>& of(const std::string& name) const;
  void reset() { attached_.clear(); }

 private:
  std::unordered_map<std::string, std::vector<std::string>> attached_;
};

}  // namespace yarm::perception
