// What lies on the tops of the fixed bodies: how high the points are over each spot of them, averaged over half a
// second. A single reading cannot tell a thing of some centimetres from the table under it, an average can.
#pragma once

#include "present_set.hpp"
#include "scene_model.hpp"

#include <Eigen/Geometry>

#include <cstdint>
#include <limits>
#include <vector>

namespace yarm::perception {

/// Something that rises over a fixed body: connected spots of a map.
struct Rise {
  Eigen::AlignedBox2f box;           ///< around its spots, metres, world
  Eigen::Vector2f middle{0.F, 0.F};  ///< of its spots, metres, world
  float ground{0.F};                 ///< height of the body's top under it, metres, world
  float height{0.F};                 ///< of its highest spot over that, metres
  bool tall{false};                  ///< something near it is higher than `debris_size`
};

/// Spots of 2 cm on the tops of the registered fixed bodies with known shapes. What is there in calibration belongs to
/// the bodies. A spot beside a higher top counts as that high, so that noise at an edge is no rise. One instance an
/// association, not thread safe.
class RestMap {
 public:
  explicit RestMap(const AssociationParams& params);

  /// Takes a set whose points have owners: those of fixed bodies, of nobody and of the objects from `first_stray` on
  /// count; what rises within the noise of a robot's surface does not. O(points).
  void update(const PresentSet& set, const SceneModel& model, int first_stray);
  /// What rises now. Spots some centimetres apart are one thing's, since pixels are, unless that is larger than
  /// `debris_size`: then it is taken for several that lie closer together.
  [[nodiscard]] std::vector<Rise> rises() const;
  /// Height of the fixed body's top at a place, metres, world; NaN where there is none.
  [[nodiscard]] float groundAt(float x, float y) const;
  void reset();

 private:
  struct Spot {
    float ground{std::numeric_limits<float>::quiet_NaN()};  ///< of the drawn body, with higher ones beside it
    float learnt{0.F};                                      ///< height of what is on it since calibration
    float mean{0.F};                                        ///< of the points over the ground
    float variance{0.F};                                    ///< of one point
    int points{0};                                          ///< behind the mean
    StampNs seen_ns{-1};
    StampNs tall_ns{-1};
  };

  void refreshGround(const PresentSet& set);
  void raise(const PresentSet& set, int object);
  void widen();
  void take(const MergedPoint& p, bool nobodys, const SceneModel& model, const std::vector<char>& robots);
  void learn();
  [[nodiscard]] bool rises(const Spot& spot) const;
  [[nodiscard]] int spotAt(float x, float y) const;
  [[nodiscard]] Eigen::Vector2f centreOf(int spot) const;
  template <class Use>
  void around(std::size_t spot, int gap, Use&& use) const;
  /// The spots that rise, each within `gap` spots of another, from the first on; those in `met` are left out, and
  /// added.
  [[nodiscard]] std::vector<std::size_t> grow(std::size_t first, int gap, std::vector<char>& met) const;
  [[nodiscard]] Rise describe(const std::vector<std::size_t>& spots) const;

  AssociationParams params_;
  int nx_;
  int ny_;
  std::vector<Spot> spots_;         // row-major x, y
  std::vector<std::int32_t> tops_;  // spots with ground
  std::vector<float> drawn_;        // what the ground was drawn from
  StampNs stamp_ns_{0};
  bool calibrating_{false};
};

}  // namespace yarm::perception
