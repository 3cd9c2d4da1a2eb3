// Data that travels between the stages of perception. Plain structs, no ROS, no PCL.
// Units: metres, radians; times are integer nanoseconds. "World" is the frame at the centre of the cell's floor, z up.
#pragma once

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace yarm::perception {

/// Nanoseconds of capture (simulated or real) time.
using StampNs = std::int64_t;

/// A cell of the occupancy grid.
struct Cell {
  int x{0};
  int y{0};
  int z{0};
  friend bool operator==(const Cell& a, const Cell& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
};

/// The mapped volume and its division into cells: cell = floor((p - min) / resolution); outside there is no cell.
struct GridSpec {
  std::array<int, 3> size{50, 50, 20};          ///< cells along x, y, z
  std::array<double, 3> min{-2.5, -2.5, 0.01};  ///< lower bounds, metres, world
  std::array<double, 3> max{2.5, 2.5, 1.3};     ///< upper bounds (exclusive), metres, world

  /// Number of cells.
  [[nodiscard]] std::size_t count() const;
  /// Edge of a cell along an axis (0, 1, 2), metres.
  [[nodiscard]] double resolution(int axis) const;
  /// Row-major index (x, then y, then z) of the cell of a point, or -1 outside (also for NaN).
  [[nodiscard]] int indexOf(double x, double y, double z) const;
  /// Row-major index of a cell that lies inside.
  [[nodiscard]] int indexOf(const Cell& cell) const;
  /// The cell of a row-major index in [0, count()).
  [[nodiscard]] Cell cellOf(int index) const;
  /// Centre of a cell, metres, world.
  [[nodiscard]] Eigen::Vector3d centre(const Cell& cell) const;
};

/// Finds the cells of many points: the same ones as GridSpec::indexOf, of which it keeps what does not change.
class CellFinder {
 public:
  explicit CellFinder(const GridSpec& spec)
      : size_(spec.size), min_(spec.min), edge_{spec.resolution(0), spec.resolution(1), spec.resolution(2)} {}

  /// Row-major index of the cell of a point, or -1 outside (also for NaN).
  [[nodiscard]] int indexOf(double x, double y, double z) const {
    const double at_x = (x - min_[0]) / edge_[0];
    const double at_y = (y - min_[1]) / edge_[1];
    const double at_z = (z - min_[2]) / edge_[2];
    const bool inside =
        at_x >= 0.0 && at_x < size_[0] && at_y >= 0.0 && at_y < size_[1] && at_z >= 0.0 && at_z < size_[2];
    return inside ? (static_cast<int>(at_x) * size_[1] + static_cast<int>(at_y)) * size_[2] + static_cast<int>(at_z)
                  : -1;
  }

 private:
  std::array<int, 3> size_;
  std::array<double, 3> min_;
  std::array<double, 3> edge_;
};

/// One camera's cloud, read in place from its message buffer. The buffer must outlive the call it is handed to.
/// Coordinates are little-endian float32 in the optical frame (x right, y down, z forward); NaN = nothing in range.
struct CameraCloud {
  const std::uint8_t* data{nullptr};  ///< first byte of the first point
  std::size_t width{0};               ///< points in a row
  std::size_t height{0};              ///< rows
  std::size_t point_step{16};         ///< bytes from one point to the next
  std::size_t row_step{0};            ///< bytes from one row to the next; 0 = width * point_step
  std::size_t x_offset{0};            ///< byte offset of x within a point
  std::size_t y_offset{4};            ///< byte offset of y
  std::size_t z_offset{8};            ///< byte offset of z
  Eigen::Isometry3f T_world_camera{Eigen::Isometry3f::Identity()};  ///< pose of the optical frame at the capture time
  StampNs stamp_ns{0};                                              ///< capture time
};

/// A point inside the box, 32 bytes: it is sent between processes as it lies in memory.
struct MergedPoint {
  float x{0}, y{0}, z{0};     ///< position, metres, world
  float sigma{0};             ///< standard deviation of the sensor's noise along the ray at this range, metres
  float ux{0}, uy{0}, uz{0};  ///< unit vector from the camera to the point, world
  std::int32_t camera{0};     ///< index of the camera in the set
};
static_assert(sizeof(MergedPoint) == 32, "MergedPoint is a wire format");

/// What became of one camera's cloud.
struct CameraReport {
  std::size_t points{0};  ///< points read
  std::size_t finite{0};  ///< points that saw something, anywhere: the camera's view
  std::size_t absurd{0};  ///< points with infinite or absurd coordinates, left out
  std::size_t kept{0};    ///< points inside the box and above the floor's noise
  bool dropped{false};    ///< too many were absurd: the whole cloud was left out
};

/// One camera set brought together: points, voxels and clusters. Voxels and clusters can be made again from the points.
struct MergedSet {
  StampNs stamp_ns{0};                ///< oldest capture time of the set
  std::vector<MergedPoint> points;    ///< by camera, then in the order of the cloud
  std::vector<CameraReport> cameras;  ///< one entry a camera
  std::vector<std::int32_t> absent;   ///< cameras without a view in this set: that they show nothing says nothing
  std::vector<std::int32_t> voxel_of_point;  ///< index into centroids
  std::vector<Eigen::Vector3f> centroids;  ///< centroid of the points of each voxel, by voxel x fastest, then y, then z
  std::vector<std::int32_t> voxel_points;  ///< number of points of each voxel
  std::vector<std::int32_t> cluster_of_voxel;  ///< index into clusters, -1 where the cluster was too small or large
  std::vector<std::vector<std::int32_t>> clusters;  ///< voxels of each cluster, ascending; largest cluster first
};

/// Kinds of objects, as in ObjectRegistry.
enum class ObjectKind { kMobile, kManipulator, kDebris, kTarget, kObstacle };

/// Name as in the messages ("Mobile", "Manipulator", "Debris", "Target", "Obstacle").
[[nodiscard]] const char* toString(ObjectKind kind);
/// Kind of a name; empty when the name is not known.
[[nodiscard]] std::optional<ObjectKind> fromString(const std::string& text);

/// Where one registered object is.
struct Seed {
  std::string name;                                               ///< unique name of the object
  ObjectKind object{ObjectKind::kObstacle};                       ///< what it is
  bool is_static{true};                                           ///< true when it never moves by itself
  Eigen::Isometry3d T_world_seed{Eigen::Isometry3d::Identity()};  ///< at the capture time of the set
  StampNs stamp_ns{0};                                            ///< true time of the transform
};

/// A solid with a known shape. Its origin is its centre; a cylinder's or capsule's axis is z.
struct Solid {
  enum class Shape { kBox, kSphere, kCylinder, kCapsule };
  Shape shape{Shape::kBox};
  Eigen::Vector3d size{0.0, 0.0, 0.0};  ///< box: edges x, y, z; else: radius in x, length along the axis in z (a
                                        ///< capsule's without its caps), metres
  Eigen::Isometry3d T_frame_solid{Eigen::Isometry3d::Identity()};  ///< pose in the tf frame it is fixed to
  std::string frame;                                               ///< that tf frame
};

/// What is known of an object beforehand.
struct KnownObject {
  std::string seed_frame;                ///< tf frame of the seed
  std::vector<std::string> link_frames;  ///< tf frames of the rigid links
  std::vector<Solid> solids;             ///< known shapes; may be empty
};

/// Known shapes by object name: the registry's content.
using Knowledge = std::unordered_map<std::string, KnownObject>;

/// World <- tf frame at the capture time. A frame may be missing: its last pose, carried with the seed, is used.
using LinkPoses = std::unordered_map<std::string, Eigen::Isometry3d>;

/// Name of the n-th thing that nobody registered: "unknown_<n>".
[[nodiscard]] std::string unknownName(std::int64_t number);

/// Name of the n-th piece of debris that nobody registered: "debris_auto_<n>".
[[nodiscard]] std::string strayName(std::int64_t number);

/// Fewest points from which anything is said of a piece of debris.
constexpr std::size_t kLeastPiecePoints = 10;

/// What the cameras see of a piece of debris in one set: where a hand would take it.
struct PieceView {
  std::size_t points{0};               ///< seen of it
  Eigen::Vector3d top{0.0, 0.0, 0.0};  ///< over its middle, at the height of its top, metres, world
  double axis_rad{0.0};                ///< direction of its longer side, (-pi/2, pi/2], world
  double length{0.0};                  ///< extent along that side, metres
  double width{0.0};                   ///< extent across it, metres
  std::uint32_t cameras{0};            ///< bit c: camera c of the set sees points of it
};

/// How a piece of debris hangs on a robot's hand.
struct CarriedPiece {
  std::string robot;                                             ///< that carries it
  Eigen::Isometry3d T_tip_piece{Eigen::Isometry3d::Identity()};  ///< its seed in the frame of the robot's seed
};

/// One object with the points that are its own.
struct AssociatedObject {
  std::string name;                          ///< unique name; "unknown_<n>" for things nobody registered
  ObjectKind object{ObjectKind::kObstacle};  ///< what it is
  bool is_static{true};                      ///< "static" or "dynamic"
  bool is_unknown{false};                    ///< nobody registered it
  Eigen::Isometry3d T_world_seed{Eigen::Isometry3d::Identity()};  ///< for an unknown: at the centroid of its points
  StampNs stamp_ns{0};                                            ///< time of T_world_seed
  std::vector<Eigen::Vector3f> points;   ///< seen points, metres, world; those a known surface explains lie on it
  std::vector<std::uint32_t> source;     ///< index of each of `points` in MergedSet::points (points may have come from
                                         ///< another set in the original variant: then empty)
  std::vector<Eigen::Vector3f> hidden;   ///< points that stand for what is there but not seen: insides of known solids,
                                         ///< hidden sides, carried clouds; metres, world
  std::vector<std::string> attached_to;  ///< objects this one rests on or is bolted to: sharing cells with them is no
                                         ///< collision, and the shared cells are this object's
  std::optional<PieceView> piece;        ///< of debris whose points were seen: where a hand would take it
  std::optional<CarriedPiece> carried;   ///< of debris on a robot's hand: its points are among the robot's, not here
};

/// The result of one association.
struct AssociatedSet {
  StampNs stamp_ns{0};                    ///< oldest capture time of the set
  std::vector<AssociatedObject> objects;  ///< registered ones in the order of the seeds, then the unknown ones
};

}  // namespace yarm::perception
