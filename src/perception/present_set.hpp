// The set that is being associated, as the parts of the association hand it on.
#pragma once

#include "yarm/perception/association.hpp"

#include "object_memory.hpp"

#include <cstdint>
#include <vector>

namespace yarm::perception {

constexpr int kNobody = -1;  // owner of a point that is nobody's yet

constexpr float kDebrisReach = 0.13F;  // a loose thing of unknown shape reaches this far from its seed, metres

/// One set, the objects in it, and whose each point is so far.
struct PresentSet {
  const std::vector<MergedPoint>* points{nullptr};
  const std::vector<std::int32_t>* absent{nullptr};  ///< cameras without a view
  bool calibrating{false};
  std::int64_t number{0};               ///< of the set, counted by the association
  std::vector<ObjectMemory*> objects;   ///< registered ones, in the order of the seeds
  std::vector<char> robots;             ///< parallel to objects: is it a robot?
  std::vector<char> solid;              ///< parallel to objects: has it a body? All but targets
  std::vector<int> owner;               ///< of each point: index of the object, or kNobody
  std::vector<Eigen::Vector3f> placed;  ///< each point with its noise off a known surface taken away, metres, world
  StampNs stamp_ns{0};                  ///< capture time of the set

  [[nodiscard]] int objectCount() const { return static_cast<int>(objects.size()); }
  [[nodiscard]] ObjectMemory& object(int i) const { return *objects[static_cast<std::size_t>(i)]; }
  /// Where the camera saw a point, metres, world.
  [[nodiscard]] Eigen::Vector3f seenAt(std::size_t i) const {
    const MergedPoint& p = (*points)[i];
    return {p.x, p.y, p.z};
  }
};

}  // namespace yarm::perception
