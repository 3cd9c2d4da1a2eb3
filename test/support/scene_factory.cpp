#include "scene_factory.hpp"

#include "yarm/perception/solids.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace yarm::test {

namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr std::size_t kPool = 1U << 20U;

/// Ray against a solid in its own frame: the nearest entry with its outward normal.
struct Hit {
  float t{kFar};
  Eigen::Vector3f normal{Eigen::Vector3f::UnitZ()};
};

Hit hitBox(const Eigen::Vector3f& half, const Eigen::Vector3f& o, const Eigen::Vector3f& d) {
  float enter = 0.F;
  float leave = kFar;
  int axis = -1;
  for (int a = 0; a < 3; ++a) {
    if (std::abs(d[a]) < 1e-9F) {
      if (std::abs(o[a]) > half[a]) {
        return {};
      }
      continue;
    }
    const float t0 = ((d[a] > 0 ? -half[a] : half[a]) - o[a]) / d[a];
    const float t1 = ((d[a] > 0 ? half[a] : -half[a]) - o[a]) / d[a];
    if (t0 > enter) {
      enter = t0;
      axis = a;
    }
    leave = std::min(leave, t1);
  }
  if (axis < 0 || enter > leave) {
    return {};
  }
  Hit hit{enter, Eigen::Vector3f::Zero()};
  hit.normal[axis] = d[axis] > 0 ? -1.F : 1.F;
  return hit;
}

Hit hitSphere(float radius, const Eigen::Vector3f& centre, const Eigen::Vector3f& o, const Eigen::Vector3f& d) {
  const Eigen::Vector3f m = o - centre;
  const float a = d.squaredNorm();
  const float b = m.dot(d);
  const float disc = b * b - a * (m.squaredNorm() - radius * radius);
  if (disc < 0.F) {
    return {};
  }
  const float t = (-b - std::sqrt(disc)) / a;
  return t > 0.F ? Hit{t, (m + t * d) / radius} : Hit{};
}

Hit hitTube(float radius, float half, const Eigen::Vector3f& o, const Eigen::Vector3f& d) {
  const float a = d.x() * d.x() + d.y() * d.y();
  const float b = o.x() * d.x() + o.y() * d.y();
  const float disc = b * b - a * (o.x() * o.x() + o.y() * o.y() - radius * radius);
  if (a < 1e-12F || disc < 0.F) {
    return {};
  }
  const float t = (-b - std::sqrt(disc)) / a;
  const Eigen::Vector3f p = o + t * d;
  return t > 0.F && std::abs(p.z()) <= half ? Hit{t, {p.x() / radius, p.y() / radius, 0.F}} : Hit{};
}

Hit hitCap(float radius, float z, const Eigen::Vector3f& o, const Eigen::Vector3f& d) {
  if (std::abs(d.z()) < 1e-9F) {
    return {};
  }
  const float t = (z - o.z()) / d.z();
  const Eigen::Vector3f p = o + t * d;
  const bool inside = t > 0.F && p.x() * p.x() + p.y() * p.y() <= radius * radius;
  return inside ? Hit{t, {0.F, 0.F, z < 0 ? -1.F : 1.F}} : Hit{};
}

Hit nearer(const Hit& a, const Hit& b) {
  return b.t < a.t ? b : a;
}

Hit hitSolid(const pc::Solid& solid, const Eigen::Vector3f& o, const Eigen::Vector3f& d) {
  const Eigen::Vector3f size = solid.size.cast<float>();
  const float half = 0.5F * size.z();
  switch (solid.shape) {
    case pc::Solid::Shape::kSphere:
      return hitSphere(size.x(), Eigen::Vector3f::Zero(), o, d);
    case pc::Solid::Shape::kCylinder:
      return nearer(hitTube(size.x(), half, o, d), nearer(hitCap(size.x(), half, o, d), hitCap(size.x(), -half, o, d)));
    case pc::Solid::Shape::kCapsule:
      return nearer(hitTube(size.x(), half, o, d),
                    nearer(hitSphere(size.x(), {0, 0, half}, o, d), hitSphere(size.x(), {0, 0, -half}, o, d)));
    case pc::Solid::Shape::kBox:
      break;
  }
  return hitBox(0.5F * size, o, d);
}

/// Kinect noise at a depth, more at grazing angles (seen at more than 60 degrees from the normal).
float sigmaOf(float depth, float cosine) {
  const float theta = std::min(std::acos(std::min(1.F, std::abs(cosine))), 1.48353F);
  const float rest = 1.5707963F - theta;
  const float grazing =
      theta > 1.0471976F ? 1e-4F / std::sqrt(std::max(depth, 0.1F)) * theta * theta / (rest * rest) : 0.F;
  return 0.0012F + 0.0019F * (depth - 0.4F) * (depth - 0.4F) + grazing;
}

}  // namespace

std::vector<pc::Seed> Scene::seeds(pc::StampNs stamp_ns) const {
  std::vector<pc::Seed> result;
  for (const Body& body : bodies) {
    if (body.registered) {
      result.push_back({body.name, body.kind, body.is_static, poses.at(body.seed_frame), stamp_ns});
    }
  }
  return result;
}

pc::Knowledge Scene::knowledge() const {
  pc::Knowledge result;
  for (const Body& body : bodies) {
    if (body.registered) {
      result[body.name] = {body.seed_frame, body.link_frames,
                           body.shape_known ? body.solids : std::vector<pc::Solid>{}};
    }
  }
  return result;
}

int Scene::indexOf(const std::string& name) const {
  const auto found = std::find_if(bodies.begin(), bodies.end(), [&](const Body& b) { return b.name == name; });
  return found == bodies.end() ? kNothing : static_cast<int>(found - bodies.begin());
}

void Scene::remove(const std::string& name) {
  bodies.erase(std::remove_if(bodies.begin(), bodies.end(), [&](const Body& b) { return b.name == name; }),
               bodies.end());
}

Eigen::Isometry3f lookAt(const Eigen::Vector3f& place, const Eigen::Vector3f& target) {
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  const Eigen::Vector3f forward = (target - place).normalized();
  const Eigen::Vector3f right = forward.cross(Eigen::Vector3f::UnitZ()).normalized();
  T.linear().col(0) = right;
  T.linear().col(1) = forward.cross(right);
  T.linear().col(2) = forward;
  T.translation() = place;
  return T;
}

Eigen::Isometry3d pose(double x, double y, double z, double yaw_rad) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(x, y, z);
  T.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return T;
}

SceneFactory::SceneFactory(std::uint64_t seed, double noise, int cameras, CameraModel model)
    : model_(model), noise_(static_cast<float>(noise)), random_(seed) {
  std::normal_distribution<float> normal;
  pool_.resize(kPool);
  std::generate(pool_.begin(), pool_.end(), [&] { return normal(random_); });
  const float focal = 0.5F * static_cast<float>(model.width) / static_cast<float>(std::tan(0.5 * model.fov_rad));
  for (int v = 0; v < model.height; ++v) {
    for (int u = 0; u < model.width; ++u) {
      directions_.emplace_back((static_cast<float>(u) + 0.5F - 0.5F * static_cast<float>(model.width)) / focal,
                               (static_cast<float>(v) + 0.5F - 0.5F * static_cast<float>(model.height)) / focal, 1.F);
    }
  }
  const std::vector<Eigen::Vector3f> places{{3, 0, 2},       {0, 3, 2},        {0, -3, 2},       {-3, 0, 2},
                                            {2.2F, 2.2F, 2}, {-2.2F, 2.2F, 2}, {2.2F, -2.2F, 2}, {-2.2F, -2.2F, 2}};
  renders_.resize(static_cast<std::size_t>(cameras));
  for (std::size_t c = 0; c < renders_.size(); ++c) {
    renders_[c].T_world_camera = lookAt(places[c], {0.F, 0.F, 0.3F});
  }
}

const std::vector<Render>& SceneFactory::render(const Scene& scene) {
  for (Render& out : renders_) {
    drawFloor(out);
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      for (const pc::Solid& solid : scene.bodies[b].solids) {
        drawSolid(solid, scene.poses.at(solid.frame) * solid.T_frame_solid, static_cast<int>(b), out);
      }
    }
    addNoise(out);
  }
  return renders_;
}

void SceneFactory::drawFloor(Render& out) const {
  const std::size_t n = directions_.size();
  out.exact_depth.assign(n, kFar);
  out.truth.assign(n, static_cast<std::int16_t>(kNothing));
  cosine_.assign(n, 1.F);
  const Eigen::Vector3f row = out.T_world_camera.linear().row(2);
  const float height = out.T_world_camera.translation().z();
  for (std::size_t i = 0; i < n; ++i) {
    const float down = row.dot(directions_[i]);
    if (down < 0.F && -height / down < model_.far_m + 1.F) {
      out.exact_depth[i] = -height / down;
      out.truth[i] = static_cast<std::int16_t>(kFloor);
      cosine_[i] = down / directions_[i].norm();
    }
  }
}

void SceneFactory::drawSolid(const pc::Solid& solid, const Eigen::Isometry3d& T_world_solid, int body,
                             Render& out) const {
  const Eigen::Isometry3f T_camera_solid = out.T_world_camera.inverse() * T_world_solid.cast<float>();
  const Eigen::Isometry3f T_solid_camera = T_camera_solid.inverse();
  const Eigen::Vector3f centre = T_camera_solid.translation();
  const float radius = pc::halfExtents(solid.shape, solid.size.cast<float>()).norm();
  if (centre.z() + radius < 0.05F) {
    return;
  }
  const float focal = 0.5F * static_cast<float>(model_.width) / static_cast<float>(std::tan(0.5 * model_.fov_rad));
  int low[2] = {0, 0};
  int high[2] = {model_.width - 1, model_.height - 1};
  if (centre.z() - radius > 0.2F) {
    for (int a = 0; a < 2; ++a) {
      const float middle = 0.5F * static_cast<float>(a == 0 ? model_.width : model_.height);
      const float least =
          std::min((centre[a] - radius) / (centre.z() - radius), (centre[a] - radius) / (centre.z() + radius));
      const float most =
          std::max((centre[a] + radius) / (centre.z() - radius), (centre[a] + radius) / (centre.z() + radius));
      low[a] = std::max(low[a], static_cast<int>(least * focal + middle) - 1);
      high[a] = std::min(high[a], static_cast<int>(most * focal + middle) + 1);
    }
  }
  const Eigen::Vector3f origin = T_solid_camera.translation();
  for (int v = low[1]; v <= high[1]; ++v) {
    for (int u = low[0]; u <= high[0]; ++u) {
      const auto i = static_cast<std::size_t>(v * model_.width + u);
      const Eigen::Vector3f direction = T_solid_camera.linear() * directions_[i];
      const Hit hit = hitSolid(solid, origin, direction);
      if (hit.t < out.exact_depth[i]) {
        out.exact_depth[i] = hit.t;
        out.truth[i] = static_cast<std::int16_t>(body);
        cosine_[i] = hit.normal.dot(direction) / direction.norm();
      }
    }
  }
}

float SceneFactory::normalNumber() {
  return pool_[random_() % kPool];
}

void SceneFactory::addNoise(Render& out) {
  const std::size_t n = directions_.size();
  out.data.resize(4 * n);
  for (std::size_t i = 0; i < n; ++i) {
    float depth = out.exact_depth[i];
    if (noise_ > 0.F && depth < kFar) {
      depth += noise_ * sigmaOf(depth, cosine_[i]) * normalNumber();
    }
    depth *= errors_.depth_scale;
    if (!(depth >= model_.near_m && depth <= model_.far_m)) {
      depth = std::numeric_limits<float>::quiet_NaN();
    }
    out.data[4 * i] = directions_[i].x() * depth;
    out.data[4 * i + 1] = directions_[i].y() * depth;
    out.data[4 * i + 2] = depth;
    out.data[4 * i + 3] = 0.F;
  }
}

Eigen::Isometry3f SceneFactory::told(std::size_t camera) const {
  const Eigen::Isometry3f& T_world_camera = renders_[camera].T_world_camera;
  return camera == errors_.camera ? T_world_camera * errors_.off : T_world_camera;
}

std::vector<pc::CameraCloud> SceneFactory::clouds(pc::StampNs stamp_ns) const {
  std::vector<pc::CameraCloud> result;
  for (const Render& r : renders_) {
    pc::CameraCloud cloud;
    cloud.data = reinterpret_cast<const std::uint8_t*>(r.data.data());
    cloud.width = static_cast<std::size_t>(model_.width);
    cloud.height = static_cast<std::size_t>(model_.height);
    cloud.T_world_camera = told(result.size());
    cloud.stamp_ns = stamp_ns;
    result.push_back(cloud);
  }
  return result;
}

std::vector<int> SceneFactory::truthOf(const pc::MergedSet& set) const {
  std::vector<int> truth(set.points.size(), kNothing);
  std::vector<std::size_t> next(renders_.size(), 0);
  for (std::size_t i = 0; i < set.points.size(); ++i) {
    const pc::MergedPoint& p = set.points[i];
    const auto camera = static_cast<std::size_t>(p.camera);
    const Render& r = renders_[camera];
    const Eigen::Vector3f wanted = told(camera).inverse() * Eigen::Vector3f(p.x, p.y, p.z);
    for (std::size_t k = next[camera]; k < r.truth.size(); ++k) {
      const Eigen::Vector3f seen(r.data[4 * k], r.data[4 * k + 1], r.data[4 * k + 2]);
      if ((seen - wanted).squaredNorm() < 1e-9F) {
        truth[i] = r.truth[k];
        next[camera] = k + 1;
        break;
      }
    }
  }
  return truth;
}

double clearance(const Scene& scene, const Body& a, const Body& b) {
  float best = std::numeric_limits<float>::infinity();
  for (const pc::Solid& sa : a.solids) {
    const Eigen::Isometry3f T_world_a = (scene.poses.at(sa.frame) * sa.T_frame_solid).cast<float>();
    const auto samples = pc::sampleSurface(sa.shape, sa.size.cast<float>(), 0.02F);
    const float radius_a = pc::halfExtents(sa.shape, sa.size.cast<float>()).norm();
    for (const pc::Solid& sb : b.solids) {
      const Eigen::Isometry3f T_b = (scene.poses.at(sb.frame) * sb.T_frame_solid).cast<float>().inverse() * T_world_a;
      const float radius_b = pc::halfExtents(sb.shape, sb.size.cast<float>()).norm();
      if (T_b.translation().norm() - radius_a - radius_b > best) {
        continue;
      }
      for (const Eigen::Vector3f& p : samples) {
        best = std::min(best, pc::surfaceDistance(sb.shape, sb.size.cast<float>(), T_b * p).distance);
      }
    }
  }
  return best;
}

}  // namespace yarm::test
