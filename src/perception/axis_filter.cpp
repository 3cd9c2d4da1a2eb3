#include "axis_filter.hpp"

#include <algorithm>
#include <cmath>

namespace yarm::perception {

namespace {

constexpr double kAcceleration = 0.03;        // spectral density of the acceleration, m^2/s^3
constexpr double kWander = 5e-4;              // variance that an edge gains in a second, m^2/s
constexpr double kFirstVelocity = 1.5 * 1.5;  // variance of a velocity of which nothing is known, (m/s)^2
constexpr double kUnseenEdge = 0.2 * 0.2;     // variance of an edge beyond the border, m^2
constexpr double kGateSigmas = 2.5;           // an edge further off is believed the less
constexpr double kSlack = 0.06;               // what is seen outside of the box by more widens it, metres

}  // namespace

AxisFilter::AxisFilter(const SeenEdges& first) : x_(first.low, first.high, 0.0), P_(Eigen::Matrix3d::Zero()) {
  P_.diagonal() << (first.low_cut ? kUnseenEdge : first.variance), (first.high_cut ? kUnseenEdge : first.variance),
      kFirstVelocity;
}

void AxisFilter::predict(double dt) {
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F(0, 2) = F(1, 2) = dt;
  x_ = F * x_;
  P_ = F * P_ * F.transpose();
  const double place = kAcceleration * dt * dt * dt / 3.0;
  const double both = kAcceleration * dt * dt / 2.0;
  Eigen::Matrix3d Q;
  Q << place + kWander * dt, place, both,  //
      place, place + kWander * dt, both,   //
      both, both, kAcceleration * dt;
  P_ += Q;
}

void AxisFilter::update(const SeenEdges& seen) {
  if (seen.low_cut) {
    place(0, std::min(x_[0], seen.low), kUnseenEdge);
  } else {
    measure(0, seen.low, seen.variance);
  }
  if (seen.high_cut) {
    place(1, std::max(x_[1], seen.high), kUnseenEdge);
  } else {
    measure(1, seen.high, seen.variance);
  }
  if (x_[0] > seen.low + kSlack) {
    place(0, seen.low, seen.variance);
  }
  if (x_[1] < seen.high - kSlack) {
    place(1, seen.high, seen.variance);
  }
}

void AxisFilter::stand() {
  x_[2] = 0.0;
  P_.row(2).setZero();
  P_.col(2).setZero();
  P_(2, 2) = kFirstVelocity;
}

Eigen::Matrix2d AxisFilter::covariance() const {
  Eigen::Matrix<double, 2, 3> H;
  H << 0.5, 0.5, 0.0, 0.0, 0.0, 1.0;
  return H * P_ * H.transpose();
}

void AxisFilter::measure(int edge, double value, double variance) {
  const double off = value - x_[edge];
  const double expected = P_(edge, edge) + variance;
  const double surprise = off * off / (kGateSigmas * kGateSigmas);
  const double total = std::max(expected, surprise);
  const Eigen::Vector3d gain = P_.col(edge) / total;
  x_ += gain * off;
  P_ -= gain * P_.row(edge).eval();
  P_ = 0.5 * (P_ + P_.transpose()).eval();
}

void AxisFilter::place(int edge, double value, double variance) {
  x_[edge] = value;
  P_.row(edge).setZero();
  P_.col(edge).setZero();
  P_(edge, edge) = variance;
}

}  // namespace yarm::perception
