// Kalman filter of a box along one axis: both edges, each measured on its own, and the velocity they share.
#pragma once

#include <Eigen/Core>

namespace yarm::perception {

/// Where a set shows the two edges of a thing along an axis. An edge that is cut was seen at the border of the volume:
/// the thing itself may reach further, so that edge is not measured.
struct SeenEdges {
  double low{0.0};       ///< metres
  double high{0.0};      ///< metres
  bool low_cut{false};   ///< the low edge is the border's
  bool high_cut{false};  ///< the high edge is the border's
  double variance{0.0};  ///< of an edge, m^2
};

/// Constant velocity with white acceleration; edges wander on their own besides, slowly. A part of a body that comes
/// into view at the border moves one edge only; its middle and its extent would lag.
class AxisFilter {
 public:
  explicit AxisFilter(const SeenEdges& first);

  /// Moves on by dt >= 0 seconds.
  void predict(double dt);
  /// Takes a measurement. An edge that is far from where it should be is believed the less, so that what comes out
  /// from behind something, or goes there, is not taken for motion; what is seen outside is inside from then on.
  void update(const SeenEdges& seen);
  /// Stands where it was, for all that is known: nothing is known of its velocity.
  void stand();

  [[nodiscard]] double low() const { return x_[0]; }
  [[nodiscard]] double high() const { return x_[1]; }
  [[nodiscard]] double middle() const { return 0.5 * (x_[0] + x_[1]); }
  [[nodiscard]] double extent() const { return x_[1] - x_[0]; }
  [[nodiscard]] double velocity() const { return x_[2]; }
  /// Covariance of middle and velocity.
  [[nodiscard]] Eigen::Matrix2d covariance() const;

 private:
  void measure(int edge, double value, double variance);
  /// Sets an edge that was not measured, or wrongly predicted; the velocity learns nothing from it.
  void place(int edge, double value, double variance);

  Eigen::Vector3d x_;  // low edge, high edge, velocity
  Eigen::Matrix3d P_;
};

}  // namespace yarm::perception
