#include "yarm/perception/types.hpp"

#include <utility>

namespace yarm::perception {

namespace {
constexpr std::array<std::pair<ObjectKind, const char*>, 5> kKindNames{{{ObjectKind::kMobile, "Mobile"},
                                                                        {ObjectKind::kManipulator, "Manipulator"},
                                                                        {ObjectKind::kDebris, "Debris"},
                                                                        {ObjectKind::kTarget, "Target"},
                                                                        {ObjectKind::kObstacle, "Obstacle"}}};
}  // namespace

std::size_t GridSpec::count() const {
  return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
}

double GridSpec::resolution(int axis) const {
  const auto a = static_cast<std::size_t>(axis);
  return (max[a] - min[a]) / size[a];
}

int GridSpec::indexOf(double x, double y, double z) const {
  return CellFinder(*this).indexOf(x, y, z);
}

int GridSpec::indexOf(const Cell& cell) const {
  return (cell.x * size[1] + cell.y) * size[2] + cell.z;
}

Cell GridSpec::cellOf(int index) const {
  return {index / (size[1] * size[2]), index / size[2] % size[1], index % size[2]};
}

Eigen::Vector3d GridSpec::centre(const Cell& cell) const {
  return {min[0] + (cell.x + 0.5) * resolution(0), min[1] + (cell.y + 0.5) * resolution(1),
          min[2] + (cell.z + 0.5) * resolution(2)};
}

const char* toString(ObjectKind kind) {
  for (const auto& [value, name] : kKindNames) {
    if (value == kind) {
      return name;
    }
  }
  return "";
}

std::optional<ObjectKind> fromString(const std::string& text) {
  for (const auto& [value, name] : kKindNames) {
    if (text == name) {
      return value;
    }
  }
  return std::nullopt;
}

std::string unknownName(std::int64_t number) {
  return "unknown_" + std::to_string(number);
}

std::string strayName(std::int64_t number) {
  return "debris_auto_" + std::to_string(number);
}

}  // namespace yarm::perception
