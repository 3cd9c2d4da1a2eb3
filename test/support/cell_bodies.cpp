#include "scene_factory.hpp"

#include <cmath>

namespace yarm::test {

namespace {

using Shape = pc::Solid::Shape;

pc::Solid solid(Shape shape, const Eigen::Vector3d& size, const Eigen::Vector3d& at, const std::string& frame) {
  pc::Solid s;
  s.shape = shape;
  s.size = size;
  s.T_frame_solid.translation() = at;
  s.frame = frame;
  return s;
}

pc::Solid tube(double radius, double length, const Eigen::Vector3d& at, const std::string& frame) {
  return solid(Shape::kCylinder, {radius, 0.0, length}, at, frame);
}

Eigen::Isometry3d turned(const Eigen::Vector3d& at, double angle, const Eigen::Vector3d& axis) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = at;
  T.linear() = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  return T;
}

constexpr std::array<const char*, 8> kLinks{"base_link", "link_1_s", "link_2_l", "link_3_u",
                                            "link_4_r",  "link_5_b", "link_6_t", "tool0"};

}  // namespace

void addTable(Scene& scene) {
  Body body{"table", pc::ObjectKind::kObstacle, true, true, true, "table", {"table"}, {}};
  body.solids = {solid(Shape::kBox, {0.9, 1.2, 0.7}, {0.0, 0.0, -0.35}, "table"),
                 solid(Shape::kBox, {0.4, 0.6, 0.03}, {-0.25, 0.0, 0.015}, "table")};
  scene.bodies.push_back(body);
  scene.poses["table"] = pose(0.0, 0.0, 0.7);
}

void addStand(Scene& scene) {
  Body body{"stand", pc::ObjectKind::kObstacle, true, true, true, "stand", {"stand"}, {}};
  body.solids = {solid(Shape::kBox, {0.4, 0.4, 0.7}, {-0.15, 0.0, -0.35}, "stand")};
  scene.bodies.push_back(body);
  scene.poses["stand"] = pose(-0.95, 0.0, 0.7);
}

void addAnkurbot(Scene& scene, const std::string& name, double x, double y, double heading_rad) {
  const std::string base = name + "/base_link";
  Body body{name, pc::ObjectKind::kMobile, false, true, true, name + "/ee", {base, name + "/ee"}, {}};
  body.solids = {tube(0.35, 0.45, {0.0, 0.0, 0.325}, base),
                 solid(Shape::kBox, {0.1, 0.1, 0.42}, {0.0, 0.0, 0.76}, base),
                 solid(Shape::kBox, {1.26, 0.08, 0.08}, {0.63, 0.0, 0.89}, base),
                 solid(Shape::kSphere, {0.04, 0.0, 0.0}, {1.26, 0.0, 0.89}, base)};
  for (const double wx : {-0.15, 0.15}) {
    for (const double wy : {-0.15, 0.15}) {
      body.solids.push_back(solid(Shape::kSphere, {0.05, 0.0, 0.0}, {wx, wy, 0.05}, base));
    }
  }
  scene.bodies.push_back(body);
  moveAnkurbot(scene, name, x, y, heading_rad);
}

void moveAnkurbot(Scene& scene, const std::string& name, double x, double y, double heading_rad) {
  scene.poses[name + "/base_link"] = pose(x, y, 0.0, heading_rad);
  scene.poses[name + "/ee"] = pose(x, y, 0.0, heading_rad) * pose(1.3, 0.0, 0.89);
}

void addDebris(Scene& scene, const std::string& name, double x, double y, double yaw_rad, double rest_z) {
  Body body{name, pc::ObjectKind::kDebris, false, true, true, name, {name}, {}};
  body.solids = {solid(Shape::kBox, {0.15, 0.06, 0.014}, {0.0, 0.0, -0.013}, name),
                 solid(Shape::kBox, {0.03, 0.04, 0.014}, {-0.055, 0.0, 0.0}, name),
                 solid(Shape::kBox, {0.11, 0.04, 0.015}, {-0.015, 0.0, 0.0125}, name),
                 solid(Shape::kBox, {0.04, 0.04, 0.012}, {0.05, 0.0, 0.008}, name)};
  scene.bodies.push_back(body);
  scene.poses[name] = pose(x, y, rest_z + 0.02, yaw_rad);
}

void addTarget(Scene& scene, const std::string& name, double x, double y, double z) {
  scene.bodies.push_back({name, pc::ObjectKind::kTarget, true, true, true, name, {name}, {}});
  scene.poses[name] = pose(x, y, z);
}

void addBox(Scene& scene, const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& centre,
            bool registered) {
  Body body{name, pc::ObjectKind::kObstacle, true, registered, true, name, {name}, {}};
  body.solids = {solid(Shape::kBox, size, {0.0, 0.0, -0.5 * size.z()}, name)};
  scene.bodies.push_back(body);
  scene.poses[name] = pose(centre.x(), centre.y(), centre.z() + 0.5 * size.z());
}

void addHc10(Scene& scene, const std::string& name) {
  Body body{name, pc::ObjectKind::kManipulator, false, true, true, name + "/tool0", {}, {}};
  for (const char* link : kLinks) {
    body.link_frames.push_back(name + "/" + link);
  }
  const auto frame = [&](std::size_t i) { return body.link_frames[i]; };
  body.solids = {tube(0.115, 0.167, {0.0, 0.0, 0.0835}, frame(0)),
                 tube(0.105, 0.22, {0.0, 0.0, 0.0}, frame(1)),
                 solid(Shape::kCapsule, {0.08, 0.0, 0.69}, {0.0, -0.19, 0.345}, frame(2)),
                 solid(Shape::kSphere, {0.1, 0.0, 0.0}, {0.0, -0.01, 0.0}, frame(3)),
                 solid(Shape::kCapsule, {0.057, 0.0, 0.36}, {0.0, 0.0, 0.18}, frame(4)),
                 tube(0.08, 0.22, {0.0, 0.0, 0.02}, frame(5)),
                 tube(0.05, 0.037, {0.0, 0.0, -0.111}, frame(6)),
                 tube(0.06, 0.12, {0.0, 0.0, 0.06}, frame(7))};
  scene.bodies.push_back(body);
  moveHc10(scene, name, hc10Storage());
}

void moveHc10(Scene& scene, const std::string& name, const std::array<double, 6>& q) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const std::array<Eigen::Isometry3d, 7> joints{turned({0, 0, 0.275}, q[0], z),  turned({0, 0, 0}, q[1], y),
                                                turned({0, 0, 0.7}, q[2], -y),   turned({0, 0, -0.5}, q[3], z),
                                                turned({0, 0.162, 0}, q[4], -y), turned({0, 0, 0}, q[5], z),
                                                turned({0, 0, -0.13}, M_PI, x)};
  Eigen::Isometry3d T = pose(-1.1, 0.0, 0.7);
  scene.poses[name + "/" + kLinks[0]] = T;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    T = T * joints[i];
    scene.poses[name + "/" + kLinks[i + 1]] = T;
  }
}

std::array<double, 6> hc10Storage() {
  return {M_PI, -0.2, 0.6, 0.0, 1.0, 0.0};
}

std::array<double, 6> hc10OverPart() {
  return {0.0, 0.55, 1.0, 0.0, 0.45, 0.0};
}

Scene standardCell(int robots, int debris) {
  Scene scene;
  addTable(scene);
  addStand(scene);
  addHc10(scene, "hc10_barc");
  const std::array<std::array<double, 3>, 3> starts{{{1.9, 1.9, M_PI}, {1.9, -1.9, M_PI}, {-1.9, -1.9, 0.0}}};
  for (int r = 0; r < robots; ++r) {
    const auto& s = starts.at(static_cast<std::size_t>(r));
    addAnkurbot(scene, "ankurbot_" + std::to_string(r + 1), s[0], s[1], s[2]);
  }
  const std::array<std::array<double, 3>, 3> places{{{-0.15, 0.2, 0.3}, {-0.2, -0.2, -0.7}, {-0.3, 0.0, 1.4}}};
  for (int d = 0; d < debris; ++d) {
    const auto& p = places.at(static_cast<std::size_t>(d));
    addDebris(scene, "debris_" + std::to_string(d + 1), p[0], p[1], p[2]);
  }
  return scene;
}

}  // namespace yarm::test
