#include "yarm/clearance/clearance.hpp"

#include <fcl/fcl.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace {

using Pose = fcl::Transform3d;
using Shape = std::shared_ptr<fcl::CollisionGeometryd>;

enum ShapeKind : std::int32_t { kBox = 0, kCylinder = 1, kSphere = 2 };

Pose poseOf(const double* m) {
  Pose pose = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      pose.matrix()(row, column) = m[4 * row + column];
    }
  }
  return pose;
}

Shape shapeOf(std::int32_t kind, const double* size) {
  switch (kind) {
    case kBox:
      return std::make_shared<fcl::Boxd>(size[0], size[1], size[2]);
    case kCylinder:
      return std::make_shared<fcl::Cylinderd>(size[0], size[1]);
    case kSphere:
      return std::make_shared<fcl::Sphered>(size[0]);
    default:
      return nullptr;
  }
}

// A solid where it stands, with the box along the world's axes that holds it.
class Solid {
 public:
  Solid(Shape shape, const Pose& pose) : shape_(std::move(shape)) {
    shape_->computeLocalAABB();
    half_ = 0.5 * (shape_->aabb_local.max_ - shape_->aabb_local.min_);
    place(pose);
  }
  void place(const Pose& pose) {
    pose_ = pose;
    reach_ = pose.linear().cwiseAbs() * half_;
  }
  const Pose& pose() const { return pose_; }
  // No more than the distance: that of the two boxes along the world's axes.
  double bound(const Solid& other) const {
    const fcl::Vector3d apart = (pose_.translation() - other.pose_.translation()).cwiseAbs() - reach_ - other.reach_;
    return apart.cwiseMax(0.0).norm();
  }
  double distance(const Solid& other) const {
    const fcl::DistanceRequestd request;
    fcl::DistanceResultd result;
    fcl::distance(shape_.get(), pose_, other.shape_.get(), other.pose_, request, result);
    return std::max(result.min_distance, 0.0);
  }

 private:
  Shape shape_;
  fcl::Vector3d half_;
  Pose pose_;
  fcl::Vector3d reach_;
};

struct Joint {
  Pose parent_from_child;
  fcl::Vector3d axis;
};

struct CarriedSolid {
  std::size_t carrier;
  Pose link_from_solid;
};

}  // namespace

struct YarmArm {
  std::vector<Joint> joints;
  std::vector<CarriedSolid> carried;
  std::vector<Solid> solids;  // of the arm, beside `carried`
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  std::vector<Solid> obstacles;
  std::vector<Pose> links;  // of the fixed frame and of what each joint moves

  void place(const double* angles) {
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const Eigen::AngleAxisd turn(angles[i], joints[i].axis);
      links[i + 1] = links[i] * joints[i].parent_from_child * turn;
    }
    for (std::size_t i = 0; i < solids.size(); ++i) {
      solids[i].place(links[carried[i].carrier] * carried[i].link_from_solid);
    }
  }
  double clearance(double within) const {
    double least = within;
    const auto look = [&least](const Solid& a, const Solid& b) {
      if (a.bound(b) < least) {
        least = std::min(least, a.distance(b));
      }
    };
    for (std::size_t i = 0; i < solids.size(); ++i) {
      if (carried[i].carrier == 0) {
        continue;
      }
      for (const Solid& obstacle : obstacles) {
        look(solids[i], obstacle);
      }
    }
    for (const auto& [a, b] : pairs) {
      look(solids[a], solids[b]);
    }
    return least;
  }
};

namespace {

bool addSolids(const YarmSolids& given, std::vector<Solid>* solids) {
  for (std::int32_t i = 0; i < given.n; ++i) {
    Shape shape = shapeOf(given.shapes[i], given.sizes + 3 * i);
    if (!shape) {
      return false;
    }
    solids->emplace_back(std::move(shape), poseOf(given.poses + 16 * i));
  }
  return true;
}

}  // namespace

YarmArm* yarmArmMake(std::int32_t n_joints, const double* parent_from_child, const double* axes,
                     const YarmSolids* links, const std::int32_t* carriers, std::int32_t n_pairs,
                     const std::int32_t* pairs, const YarmSolids* obstacles) {
  auto arm = std::make_unique<YarmArm>();
  for (std::int32_t i = 0; i < n_joints; ++i) {
    arm->joints.push_back({poseOf(parent_from_child + 16 * i), {axes[3 * i], axes[3 * i + 1], axes[3 * i + 2]}});
  }
  arm->links.assign(arm->joints.size() + 1, Pose::Identity());
  if (!addSolids(*links, &arm->solids) || !addSolids(*obstacles, &arm->obstacles)) {
    return nullptr;
  }
  for (std::int32_t i = 0; i < links->n; ++i) {
    arm->carried.push_back({static_cast<std::size_t>(carriers[i]), arm->solids[i].pose()});
  }
  for (std::int32_t i = 0; i < n_pairs; ++i) {
    arm->pairs.emplace_back(pairs[2 * i], pairs[2 * i + 1]);
  }
  return arm.release();
}

void yarmArmFree(YarmArm* arm) {
  delete arm;
}

double yarmArmClearance(YarmArm* arm, const double* angles, double within) {
  arm->place(angles);
  return arm->clearance(within);
}
