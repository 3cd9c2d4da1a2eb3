#ifndef YARM_JOINT_MASKS_HPP
#define YARM_JOINT_MASKS_HPP

// Which edges of a robot another one blocks where it stands, as bits.

#include <cstdint>
#include <vector>

#include "fleet.hpp"

namespace yarm::joint {

/// Made for each place when it is first asked for. For fleets in which what is in the way does not depend on who it is.
class Masks {
 public:
  explicit Masks(const Fleet& fleet);

  /// Bytes that all masks of a fleet may take; kTooMany for a fleet that they are not for.
  static std::int64_t bytes(const Fleet& fleet);
  static constexpr std::int64_t kTooMany = std::int64_t{1} << 60;

  /// Bits of a robot's edges, by their number in its graph, that are not free while all others stand at their places.
  const std::vector<std::uint64_t>& blocked(std::size_t i, const Places& places);
  /// Look-ups made since this was last asked.
  std::int64_t work();

 private:
  const std::vector<std::uint64_t>& mask(std::size_t i, std::size_t j, Place place);

  const Fleet& fleet_;
  std::vector<std::size_t> kind_;                               // first robot of the same kind
  std::vector<std::vector<std::vector<std::uint64_t>>> masks_;  // by two kinds, by place
  std::vector<std::uint64_t> sum_;
  std::int64_t work_ = 0;
};

}  // namespace yarm::joint

#endif  // YARM_JOINT_MASKS_HPP
