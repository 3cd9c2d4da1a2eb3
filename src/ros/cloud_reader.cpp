// PointCloud2 in and out. Clouds come from outside, so nothing in such a message is believed.
#include "yarm/ros/conversions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace yarm {

namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

constexpr std::uint64_t kMostPoints = 64'000'000;
constexpr std::size_t kMostFields = 64;

std::string findField(const PointCloud2& message, const std::string& name, std::size_t& offset) {
  const PointField* found = nullptr;
  for (const PointField& field : message.fields) {
    if (field.name == name) {
      if (found != nullptr) {
        return "field " + name + " is there twice";
      }
      found = &field;
    }
  }
  if (found == nullptr) {
    return "field " + name + " is missing";
  }
  if (found->datatype != PointField::FLOAT32 || found->count != 1) {
    return "field " + name + " has datatype " + std::to_string(found->datatype) + " and count " +
           std::to_string(found->count) + ", must be one FLOAT32";
  }
  offset = found->offset;
  if (offset + sizeof(float) > message.point_step) {
    return "field " + name + " at offset " + std::to_string(offset) + " lies outside point_step " +
           std::to_string(message.point_step);
  }
  return "";
}

std::string checkSizes(const PointCloud2& message) {
  const std::uint64_t width = message.width;
  const std::uint64_t height = message.height;
  if (width * height > kMostPoints) {
    return std::to_string(width) + " x " + std::to_string(height) + " points, at most " + std::to_string(kMostPoints);
  }
  const std::uint64_t row = width * message.point_step;
  if (height > 1 && message.row_step < row) {
    return "row_step " + std::to_string(message.row_step) + " is less than width * point_step = " + std::to_string(row);
  }
  const std::uint64_t needed = height == 0 || width == 0 ? 0 : (height - 1) * message.row_step + row;
  if (message.data.size() < needed) {
    return "data holds " + std::to_string(message.data.size()) + " bytes, the layout needs " + std::to_string(needed);
  }
  return "";
}

}  // namespace

Read<perception::CameraCloud> viewOf(const PointCloud2& message) {
  Read<perception::CameraCloud> read;
  perception::CameraCloud& view = read.value;
  if (message.is_bigendian != 0) {
    read.reason = "the bytes are big-endian, must be little-endian";
    return read;
  }
  if (message.fields.size() > kMostFields || message.point_step == 0) {
    read.reason = std::to_string(message.fields.size()) + " fields and point_step " +
                  std::to_string(message.point_step) + ", must be at most 64 and more than 0";
    return read;
  }
  read.reason = findField(message, "x", view.x_offset);
  if (read.ok()) {
    read.reason = findField(message, "y", view.y_offset);
  }
  if (read.ok()) {
    read.reason = findField(message, "z", view.z_offset);
  }
  if (read.ok()) {
    read.reason = checkSizes(message);
  }
  view.data = message.data.data();
  const bool empty = message.width == 0 || message.height == 0;  // 0 points in 2^32 rows are no rows
  view.width = empty ? 0 : message.width;
  view.height = empty ? 0 : message.height;
  view.point_step = message.point_step;
  view.row_step = message.height > 1 ? message.row_step : message.width * static_cast<std::size_t>(message.point_step);
  view.stamp_ns = toNs(message.header.stamp);
  return read;
}

namespace {

struct WireField {
  const char* name;
  std::uint32_t offset;
  std::uint8_t type;
};

constexpr std::array<WireField, 8> kMergedFields{{{"x", 0, PointField::FLOAT32},
                                                  {"y", 4, PointField::FLOAT32},
                                                  {"z", 8, PointField::FLOAT32},
                                                  {"sigma", 12, PointField::FLOAT32},
                                                  {"ux", 16, PointField::FLOAT32},
                                                  {"uy", 20, PointField::FLOAT32},
                                                  {"uz", 24, PointField::FLOAT32},
                                                  {"camera", 28, PointField::INT32}}};

template <std::size_t N>
void layOut(PointCloud2& message, const std::array<WireField, N>& fields, std::size_t count, std::uint32_t step) {
  message.fields.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    message.fields[i].name = fields[i].name;
    message.fields[i].offset = fields[i].offset;
    message.fields[i].datatype = fields[i].type;
    message.fields[i].count = 1;
  }
  message.point_step = step;
  message.is_bigendian = 0;
  message.is_dense = 1;
  message.height = 1;
}

void setPoints(PointCloud2& message, const void* data, std::size_t points) {
  message.width = static_cast<std::uint32_t>(points);
  message.row_step = message.width * message.point_step;
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  message.data.assign(bytes, bytes + points * message.point_step);
}

}  // namespace

void fillMergedPoints(const perception::MergedSet& set, PointCloud2& message) {
  layOut(message, kMergedFields, kMergedFields.size(), sizeof(perception::MergedPoint));
  setPoints(message, set.points.data(), set.points.size());
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (const std::int32_t camera : set.absent) {
    const perception::MergedPoint mark{kNan, kNan, kNan, kNan, kNan, kNan, kNan, camera};
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&mark);
    message.data.insert(message.data.end(), bytes, bytes + sizeof(mark));
    ++message.width;
  }
  message.row_step = message.width * message.point_step;
  message.is_dense = set.absent.empty() ? 1 : 0;
}

namespace {

bool hasMergedLayout(const PointCloud2& message) {
  bool matches = message.point_step == sizeof(perception::MergedPoint) && message.height == 1 &&
                 message.fields.size() == kMergedFields.size();
  for (std::size_t i = 0; matches && i < kMergedFields.size(); ++i) {
    matches = message.fields[i].name == kMergedFields[i].name && message.fields[i].offset == kMergedFields[i].offset &&
              message.fields[i].datatype == kMergedFields[i].type;
  }
  return matches;
}

/// Takes the marks of absent cameras out of the points.
void takeAbsent(perception::MergedSet& set) {
  set.absent.clear();
  const auto is_mark = [](const perception::MergedPoint& p) { return std::isnan(p.x) && p.camera >= 0; };
  const auto marks = std::stable_partition(set.points.begin(), set.points.end(),
                                           [&](const perception::MergedPoint& p) { return !is_mark(p); });
  for (auto mark = marks; mark != set.points.end(); ++mark) {
    set.absent.push_back(mark->camera);
  }
  set.points.erase(marks, set.points.end());
}

bool isInside(const perception::MergeParams& box, const perception::MergedPoint& p) {
  const std::array<float, 3> at{p.x, p.y, p.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool inside =
        at[axis] >= static_cast<float>(box.box_min[axis]) && at[axis] <= static_cast<float>(box.box_max[axis]);
    if (!inside) {
      return false;
    }
  }
  return true;
}

}  // namespace

Read<bool> readMergedPoints(const PointCloud2& message, const perception::MergeParams& box,
                            perception::MergedSet& set) {
  const Read<perception::CameraCloud> view = viewOf(message);
  if (!view.ok() || !hasMergedLayout(message)) {
    return {false, view.ok() ? "the fields are not those of merged points" : view.reason};
  }
  set.stamp_ns = toNs(message.header.stamp);
  set.points.resize(message.width);
  if (message.width > 0) {
    std::memcpy(set.points.data(), message.data.data(), message.width * sizeof(perception::MergedPoint));
  }
  takeAbsent(set);
  set.cameras.clear();
  set.voxel_of_point.clear();
  set.centroids.clear();
  set.voxel_points.clear();
  set.cluster_of_voxel.clear();
  set.clusters.clear();
  for (const perception::MergedPoint& point : set.points) {
    if (!isInside(box, point)) {
      return {false, "a point lies outside the box of merge_clouds"};
    }
  }
  return {true, ""};
}

void fillVoxels(const perception::MergedSet& set, PointCloud2& message) {
  static_assert(sizeof(Eigen::Vector3f) == 12, "centroids are sent as they lie in memory");
  layOut(message, kMergedFields, 3, sizeof(Eigen::Vector3f));
  setPoints(message, set.centroids.data(), set.centroids.size());
}

void fillClusters(const perception::MergedSet& set, yarm::CloudVector& message) {
  message.clouds.resize(set.clusters.size());
  std::vector<Eigen::Vector3f> points;
  for (std::size_t i = 0; i < set.clusters.size(); ++i) {
    points.clear();
    for (const std::int32_t voxel : set.clusters[i]) {
      points.push_back(set.centroids[static_cast<std::size_t>(voxel)]);
    }
    PointCloud2& cloud = message.clouds[i];
    cloud.header = message.header;
    layOut(cloud, kMergedFields, 3, sizeof(Eigen::Vector3f));
    setPoints(cloud, points.data(), points.size());
  }
}

}  // namespace yarm
