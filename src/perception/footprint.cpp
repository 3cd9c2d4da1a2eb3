#include "footprint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace yarm::perception {

namespace {

constexpr float kPi = 3.14159265358979F;
constexpr int kDirections = 90;     // over half a turn, for the first look
constexpr float kIntruder = 4e-4F;  // area that a point beside the thing counts when it lies within, m^2
constexpr float kWithin = 0.003F;   // so far inside of the points it lies within, metres

struct Interval {
  float low{std::numeric_limits<float>::infinity()};
  float high{-std::numeric_limits<float>::infinity()};
  void extend(float value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] bool holds(float value, float margin) const { return value > low + margin && value < high - margin; }
};

/// A rectangle along one direction, and what speaks against it.
struct Guess {
  Footprint footprint;
  float cost{std::numeric_limits<float>::infinity()};
};

/// An edge between the outermost point on the thing and the nearest beside it.
void place(Interval& edges, const Interval& beside, float pitch) {
  edges.low = 0.5F * (edges.low + std::max(beside.low, edges.low - pitch));
  edges.high = 0.5F * (edges.high + std::min(beside.high, edges.high + pitch));
}

Guess along(float angle, const std::vector<Eigen::Vector2f>& on, const std::vector<Eigen::Vector2f>& beside,
            float pitch) {
  const Eigen::Vector2f u(std::cos(angle), std::sin(angle));
  const Eigen::Vector2f v(-u.y(), u.x());
  Interval a;
  Interval b;
  for (const Eigen::Vector2f& p : on) {
    a.extend(u.dot(p));
    b.extend(v.dot(p));
  }
  Interval beside_a{-std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()};
  Interval beside_b = beside_a;
  int within = 0;
  for (const Eigen::Vector2f& p : beside) {
    const float pa = u.dot(p);
    const float pb = v.dot(p);
    within += a.holds(pa, kWithin) && b.holds(pb, kWithin) ? 1 : 0;
    if (b.holds(pb, -kWithin)) {
      beside_a.low = pa <= a.low ? std::max(beside_a.low, pa) : beside_a.low;
      beside_a.high = pa >= a.high ? std::min(beside_a.high, pa) : beside_a.high;
    }
    if (a.holds(pa, -kWithin)) {
      beside_b.low = pb <= b.low ? std::max(beside_b.low, pb) : beside_b.low;
      beside_b.high = pb >= b.high ? std::min(beside_b.high, pb) : beside_b.high;
    }
  }
  place(a, beside_a, pitch);
  place(b, beside_b, pitch);
  const float length = a.high - a.low;
  const float width = b.high - b.low;
  Guess guess;
  guess.cost = length * width + kIntruder * static_cast<float>(within);
  guess.footprint.middle = 0.5F * ((a.low + a.high) * u + (b.low + b.high) * v);
  guess.footprint.length = std::max(length, width);
  guess.footprint.width = std::min(length, width);
  const float turned = length >= width ? angle : angle + 0.5F * kPi;
  guess.footprint.axis_rad = turned > 0.5F * kPi ? turned - kPi : turned;
  return guess;
}

}  // namespace

std::optional<Footprint> footprintOf(const std::vector<Eigen::Vector2f>& on, const std::vector<Eigen::Vector2f>& beside,
                                     float pitch) {
  if (on.empty()) {
    return std::nullopt;
  }
  Guess best;
  for (int i = 0; i < kDirections / 2; ++i) {  // a rectangle is the same after a quarter of a turn
    const Guess guess = along(kPi * static_cast<float>(i) / kDirections, on, beside, pitch);
    best = guess.cost < best.cost ? guess : best;
  }
  return best.footprint;
}

}  // namespace yarm::perception
