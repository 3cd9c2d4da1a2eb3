// A seeded world for the map maker: rooms with thin walls and boxes, a robot that tours them, a noisy depth scan and an
// odometry that drifts and slips. Everything is drawn from the seed; the truth comes with every scan.
#pragma once

#include "yarm/slam/types.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <deque>
#include <random>
#include <vector>

namespace yarm::test {

/// A flat surface, seen from above.
struct Segment {
  Eigen::Vector2d a;
  Eigen::Vector2d b;

  [[nodiscard]] double distanceTo(const Eigen::Vector2d& point) const;
};

/// A room of 6 x 6 m, lower left corner in the origin: 3 to 5 inner walls 0.10 m thick, 4 to 7 boxes.
class Arena {
 public:
  explicit Arena(std::uint64_t seed);
  /// A room with these surfaces and nothing else; not to be toured.
  explicit Arena(std::vector<Segment> surfaces) : surfaces_(std::move(surfaces)) {}
  /// The same room with `walls` inner walls and ten boxes of 0.50 x 0.32 m, none nearer to another's centre than 0.75
  /// m.
  static Arena withTenBoxes(std::uint64_t seed, int walls = 0);

  [[nodiscard]] const std::vector<Segment>& surfaces() const { return surfaces_; }
  /// Distance to the first surface along a bearing, metres; infinity when there is none. *hit: index of the surface.
  [[nodiscard]] double cast(const Eigen::Vector2d& from, double bearing, int* hit = nullptr) const;
  /// Distance from a point to the nearest surface, metres.
  [[nodiscard]] double clearance(const Eigen::Vector2d& point) const;
  /// Whether a disc of this radius may stand here, in the room and outside of everything.
  [[nodiscard]] bool isFree(const Eigen::Vector2d& point, double radius) const;

 private:
  struct Block {
    Eigen::Vector2d centre;
    Eigen::Vector2d half;
    double yaw;
  };
  void addRoom();
  void addWalls(int count, std::mt19937_64& random);
  void addBlock(const Block& block);

  std::vector<Segment> surfaces_;
  std::vector<Block> blocks_;
};

/// How the run is driven and how bad odometry and scan are.
struct RunOptions {
  double speed{0.2};      ///< m/s
  double turn_rate{0.4};  ///< rad/s
  double odometry{1.0};   ///< multiple of the odometry's errors
  double slip{1.0};       ///< multiple of the slips: 2 cm and 1.1 deg (one sigma), one in 30 s on average
  double noise{1.0};      ///< multiple of the depth noise; 0: exact ranges
  double rate_hz{10.0};   ///< scans a second
  int first_turns{1};     ///< full turns in place before the tour
  int beams{640};
  double angle_min{-0.49742};  ///< rad; with angle_max a field of 57 deg
  double angle_max{0.49742};
};

/// One moment of a run.
struct Moment {
  slam::Scan scan;
  slam::Pose2 T_arena_base;  ///< truth
  std::vector<float> exact;  ///< ranges without noise and limits, metres
  std::vector<int> surface;  ///< what each beam ends on, index into Arena::surfaces()
};

/// The robot's tour through an arena: waypoint after waypoint, often with a full turn. One call of next() a scan.
class Run {
 public:
  Run(const Arena& arena, std::uint64_t seed, const RunOptions& options = {});

  Moment next();
  [[nodiscard]] double driven() const { return driven_m_; }
  [[nodiscard]] double turned() const { return turned_rad_; }

 private:
  struct Odometer {
    double distance_scale, turn_scale, turn_per_m;
  };
  void planTour();
  void drive();
  void measureMotion(double way, double turn);
  void scanInto(Moment& moment);
  double gauss() { return normal_(random_); }

  const Arena& arena_;
  RunOptions options_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  Odometer odometer_{};
  slam::Pose2 truth_;
  slam::Pose2 odometry_;
  std::deque<Eigen::Vector2d> path_;
  double spin_left_{0};  ///< rad of a full turn still to do
  double driven_m_{0};
  double turned_rad_{0};
  std::int64_t tick_{0};
};

/// Where the depth sensor sits on the robot.
[[nodiscard]] slam::Pose2 sensorMount();

/// The room as a grid of cells: occupied where a surface passes and inside boxes, free in the room, unknown outside.
/// The grid lies anyhow over the room: its corner is drawn from the seed.
[[nodiscard]] slam::GridMap drawnMap(const Arena& arena, std::uint64_t seed, double resolution = 0.05);

/// A scan without noise from a pose of the sensor.
[[nodiscard]] slam::Scan exactScan(const Arena& arena, const slam::Pose2& T_arena_sensor,
                                   const RunOptions& options = {});

}  // namespace yarm::test
