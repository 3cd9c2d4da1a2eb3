// Synthetic camera sets with the truth: primitives ray cast from the cell's cameras, every pixel knowing whose it is.
#pragma once

#include "yarm/perception/association.hpp"
#include "yarm/perception/types.hpp"

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace yarm::test {

namespace pc = yarm::perception;

/// Owner of a pixel that sees the floor, or nothing.
constexpr int kFloor = -1;
constexpr int kNothing = -2;

/// A body of the synthetic cell. Its solids' frames need poses in the scene.
struct Body {
  std::string name;
  pc::ObjectKind kind{pc::ObjectKind::kObstacle};
  bool is_static{true};
  bool registered{true};   ///< false: nobody tells perception about it
  bool shape_known{true};  ///< false: the registry has no shapes for it
  std::string seed_frame;
  std::vector<std::string> link_frames;
  std::vector<pc::Solid> solids;
};

/// A scene at one time.
struct Scene {
  std::vector<Body> bodies;
  pc::LinkPoses poses;  ///< world <- every frame of every body

  [[nodiscard]] std::vector<pc::Seed> seeds(pc::StampNs stamp_ns) const;
  [[nodiscard]] pc::Knowledge knowledge() const;
  [[nodiscard]] int indexOf(const std::string& name) const;
  void remove(const std::string& name);
};

/// A pinhole camera with square pixels.
struct CameraModel {
  int width{320};
  int height{320};
  double fov_rad{2.35619449};  ///< horizontal
  float near_m{0.5F};
  float far_m{10.F};
};

/// One rendered camera: points as a driver would publish them, and the truth of each.
struct Render {
  std::vector<float> data;          ///< 4 floats a pixel: x, y, z, rgb; optical frame, metres; NaN = nothing in range
  std::vector<std::int16_t> truth;  ///< body seen by each pixel, kFloor or kNothing
  std::vector<float> exact_depth;   ///< without noise, metres; +inf = nothing
  Eigen::Isometry3f T_world_camera{Eigen::Isometry3f::Identity()};
};

/// What is wrong with the cameras: nothing, unless said.
struct CameraErrors {
  std::size_t camera{0};                                 ///< the one that is not where it is told to be
  Eigen::Isometry3f off{Eigen::Isometry3f::Identity()};  ///< its true optical frame <- the one that is told
  float depth_scale{1.F};                                ///< all depths are so much too large
};

/// Renders scenes; seeded, so that the same calls give the same noise.
class SceneFactory {
 public:
  /// `noise`: multiple of the Kinect's noise (0 = none). `cameras`: 1 to 8 around the cell, the first four are its own.
  explicit SceneFactory(std::uint64_t seed, double noise = 1.0, int cameras = 4, CameraModel model = {});

  /// From now on the cameras have these errors.
  void spoil(const CameraErrors& errors) { errors_ = errors; }
  /// What the cameras see.
  const std::vector<Render>& render(const Scene& scene);
  /// The same as clouds to merge, all with one stamp; valid until the next render.
  [[nodiscard]] std::vector<pc::CameraCloud> clouds(pc::StampNs stamp_ns) const;
  /// Truth of every point the clouds gave to a merged set (points matched by the order the merge keeps).
  [[nodiscard]] std::vector<int> truthOf(const pc::MergedSet& set) const;

 private:
  void drawFloor(Render& out) const;
  void drawSolid(const pc::Solid& solid, const Eigen::Isometry3d& T_world_solid, int body, Render& out) const;
  void addNoise(Render& out);
  [[nodiscard]] float normalNumber();
  /// World <- optical frame of a camera, as it is told.
  [[nodiscard]] Eigen::Isometry3f told(std::size_t camera) const;

  CameraModel model_;
  CameraErrors errors_;
  float noise_;
  std::mt19937_64 random_;
  std::vector<float> pool_;
  std::vector<Eigen::Vector3f> directions_;
  std::vector<Render> renders_;
  mutable std::vector<float> cosine_;  // of the incidence at each pixel of the camera at hand
};

/// World <- optical frame of a camera at a place that looks at a target.
[[nodiscard]] Eigen::Isometry3f lookAt(const Eigen::Vector3f& place, const Eigen::Vector3f& target);

/// World <- frame standing upright at x, y, z with a heading.
[[nodiscard]] Eigen::Isometry3d pose(double x, double y, double z, double yaw_rad = 0.0);

/// Ready-made bodies of the cell. Their poses are added to the scene.
void addTable(Scene& scene);
void addStand(Scene& scene);
void addAnkurbot(Scene& scene, const std::string& name, double x, double y, double heading_rad);
void moveAnkurbot(Scene& scene, const std::string& name, double x, double y, double heading_rad);
void addDebris(Scene& scene, const std::string& name, double x, double y, double yaw_rad, double rest_z = 0.73);
void addTarget(Scene& scene, const std::string& name, double x, double y, double z);
void addBox(Scene& scene, const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& centre,
            bool registered);
void addHc10(Scene& scene, const std::string& name);
/// Joint angles of the HC10, rad.
void moveHc10(Scene& scene, const std::string& name, const std::array<double, 6>& joints);
/// Joint angles of the folded storage pose, and over the part.
[[nodiscard]] std::array<double, 6> hc10Storage();
[[nodiscard]] std::array<double, 6> hc10OverPart();

/// The cell as it starts: table, stand, HC10 in storage, `robots` ankurbots in the corners, `debris` on the part.
[[nodiscard]] Scene standardCell(int robots, int debris);

/// Least distance between two bodies, sampled to about 2 cm, metres; negative when they overlap.
[[nodiscard]] double clearance(const Scene& scene, const Body& a, const Body& b);

}  // namespace yarm::test
