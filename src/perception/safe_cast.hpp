// From floating point to int where the number may be anything: the plain cast is undefined outside the int's range.
#pragma once

namespace yarm::perception {

/// The whole part of `value` within [low, high]; `low` for NaN. The limits must fit a float exactly.
[[nodiscard]] inline int intWithin(float value, int low, int high) {
  if (!(value > static_cast<float>(low))) {  // true for NaN, too
    return low;
  }
  return value < static_cast<float>(high) ? static_cast<int>(value) : high;
}

}  // namespace yarm::perception
