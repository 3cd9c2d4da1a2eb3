// Which point belongs to whom. Bodies that touch melt into one cluster; each must still get its own points.
#pragma once

#include "yarm/perception/tracks.hpp"
#include "yarm/perception/types.hpp"

#include <memory>
#include <set>
#include <string>
#include <vector>

namespace yarm::perception {

/// Parameters of the association.
struct AssociationParams {
  GridSpec grid;                  ///< of the map the result goes to
  double search_radius{0.2};      ///< r: reach of a seed, and of a robot over stray points, metres
  double shape_tolerance{0.015};  ///< how far a body may differ from its known shape, metres
  double noise_sigmas{4.5};       ///< a known surface explains points up to this many sigmas of their noise from it
  int unknown_min_points{2};      ///< fewest points in a set that speak for an unknown thing
  int unknown_window{3};          ///< sets looked back at for persistence
  int unknown_hits{2};            ///< sets of that window in which an unknown thing must show
  double cloud_spacing{0.05};     ///< point spacing of clouds learnt in calibration, metres
  double debris_size{0.25};       ///< longest edge of a thing at rest that is debris although nobody registered it,
                                  ///< metres; 0: none is
  double debris_rest{1.0};        ///< as long it must have been at rest, seconds
};

/// Everything one set is associated from.
struct AssociationInput {
  const MergedSet* set{nullptr};                   ///< points, voxels, clusters
  const std::vector<Seed>* seeds{nullptr};         ///< all registered objects at the capture time
  const Knowledge* knowledge{nullptr};             ///< known shapes by object name
  const LinkPoses* links{nullptr};                 ///< world <- tf frame at the capture time
  bool calibrating{false};                         ///< true while the Commander calibrates
  const std::set<std::string>* grasping{nullptr};  ///< mobile robots that say that something hangs on their hand
  bool timely{true};                               ///< seeds and links are known at the capture time, not of before
};

/// Gives each point of a set to an object. Keeps a memory of the objects: one instance a cell, not thread safe.
class Associator {
 public:
  virtual ~Associator() = default;
  Associator(const Associator&) = delete;
  Associator& operator=(const Associator&) = delete;

  /// Associates one set. The result is valid until the next call.
  virtual const AssociatedSet& associate(const AssociationInput& input) = 0;
  /// The unknown things that it follows, after the last set, also those that do not show now; ascending numbers. The
  /// "original" follows nothing.
  [[nodiscard]] virtual const std::vector<TrackedObject>& tracks() const = 0;
  /// Forgets everything (the clock went back, the scene was started again).
  virtual void reset() = 0;

 protected:
  Associator() = default;
};

/// "yarm": known shapes and calibrated surfaces first, then connectivity. "original": the published algorithm with all
/// its weaknesses, for comparison. Throws std::invalid_argument, naming every fault, on a bad name or bad parameters.
[[nodiscard]] std::unique_ptr<Associator> makeAssociator(const std::string& name, const AssociationParams& params);

}  // namespace yarm::perception
