// A surface learnt from calibration: points of a rigid body in its own frame, thinned to one a small cell.
#pragma once

#include <Eigen/Geometry>

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace yarm::perception {

/// Points gathered over several sets. A cell counts once it was hit in enough different sets, and often enough since:
/// noise hits any cell sometime.
class LearnedCloud {
 public:
  /// `spacing`: edge of a cell, metres; `least_hits`: sets in which a cell must have been hit.
  explicit LearnedCloud(float spacing, int least_hits = 1) : spacing_(spacing), least_hits_(least_hits) {}

  /// Adds a point (body frame) seen in the set with this number.
  void add(const Eigen::Vector3f& point, std::int64_t set);
  /// Distance to the nearest point that counts, if within one cell's neighbourhood; else +inf.
  [[nodiscard]] float distance(const Eigen::Vector3f& point) const;
  /// Points that count.
  [[nodiscard]] std::vector<Eigen::Vector3f> points() const;
  [[nodiscard]] bool empty() const { return counted_ == 0; }

 private:
  struct Entry {
    Eigen::Vector3f sum{Eigen::Vector3f::Zero()};
    int points{0};
    int hits{0};
    std::int64_t first_set{0};
    std::int64_t last_set{-1};
  };
  [[nodiscard]] bool counts(const Entry& entry) const;
  [[nodiscard]] std::int64_t keyOf(int x, int y, int z) const;
  [[nodiscard]] Eigen::Vector3i cellOf(const Eigen::Vector3f& point) const;

  float spacing_;
  int least_hits_;
  int counted_{0};
  std::int64_t newest_set_{0};
  Eigen::Array3f low_{Eigen::Array3f::Constant(1e9F)};
  Eigen::Array3f high_{Eigen::Array3f::Constant(-1e9F)};
  std::unordered_map<std::int64_t, Entry> cells_;
};

}  // namespace yarm::perception
