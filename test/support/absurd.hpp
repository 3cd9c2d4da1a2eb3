#pragma once

#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <random>

namespace yarm::test {

/// Mostly sane numbers, and now and then one that is not.
class Absurd {
 public:
  explicit Absurd(std::uint64_t seed) : random_(seed) {}

  double number(double low, double high) {
    static constexpr double kInf = std::numeric_limits<double>::infinity();
    static constexpr double kBad[] = {
        kInf, -kInf, std::numeric_limits<double>::quiet_NaN(), 1e300, -1e300, 1e38, -1e12, 1e9, 1e5, 0.0, -1.0, 1e-300};
    if (chance(rate_)) {
      return kBad[random_() % std::size(kBad)];
    }
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  float single(double low, double high) {
    const double value = number(low, high);
    const bool fits = !(std::abs(value) > 3e38) || std::isinf(value);
    return static_cast<float>(fits ? value : std::copysign(3e38, value));
  }
  bool chance(double share) { return std::uniform_real_distribution<double>(0.0, 1.0)(random_) < share; }
  template <typename Integer>
  Integer below(Integer limit) {
    return static_cast<Integer>(random_() % static_cast<std::uint64_t>(limit));
  }
  /// How often numbers are bad from now on.
  void rate(double share) { rate_ = share; }

 private:
  std::mt19937_64 random_;
  double rate_ = 0.0;
};

}  // namespace yarm::test
