// Which places the cameras of a set look through, judged from its points alone.
#pragma once

#include "yarm/perception/types.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace yarm::perception {

/// Most places that are asked about at once.
constexpr std::size_t kMostPlaces = 32;

/// Where the cameras are is found from their rays, so that nothing else must come along with the points. A camera looks
/// through a place when it has a view and none of its points lies on the line to it or at it. Points that a registered
/// body explains do not lie at it: where they are, the body is, not what is looked for. A place that is outside
/// its image, or that sends nothing back, cannot be told from one seen through: ask only cameras that have seen the
/// thing which is looked for. What hides a place from
/// outside of the box that the points are from is not known either.
class Sightlines {
 public:
  /// Takes a set and, for each of its points, whether a registered body explains it; both must live as long as this is
  /// asked. O(cameras).
  void take(const std::vector<MergedPoint>& points, const std::vector<std::int32_t>& absent,
            const std::vector<char>& explained);
  /// How many of the first kMostPlaces `places` one of `cameras` (a bit each) looks through; 0 when none of them has a
  /// view. O(points).
  [[nodiscard]] int seenThrough(const std::vector<Eigen::Vector3f>& places, std::uint32_t cameras) const;

 private:
  struct Camera {
    bool known{false};
    bool absent{false};
    Eigen::Vector3f place{Eigen::Vector3f::Zero()};
    std::size_t begin{0};  ///< its points of the set
    std::size_t end{0};
  };

  /// Finds the camera's place where its rays meet.
  void locate(Camera& camera) const;
  /// The places that a camera does not look through, a bit each.
  [[nodiscard]] std::uint32_t stopped(const Camera& camera, const std::vector<Eigen::Vector3f>& places) const;

  const std::vector<MergedPoint>* points_{nullptr};
  const std::vector<char>* explained_{nullptr};
  std::vector<Camera> cameras_;
};

}  // namespace yarm::perception
