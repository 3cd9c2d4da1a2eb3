// Is a camera where it is said to be? Its points near known static surfaces tell.
#pragma once

#include "yarm/perception/association.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

namespace yarm::perception {

/// When a camera counts as off.
struct CameraWatchParams {
  double warn_deg{0.4};   ///< a camera that fits the static surfaces better when turned by this is off, degrees
  double error_deg{1.0};  ///< and by this, badly so, degrees
};

/// How one camera's points lie to the known static surfaces.
struct CameraFit {
  std::int32_t camera{0};
  std::size_t points{0};   ///< points looked at
  double off_m{0.0};       ///< their median distance to the surfaces as they are, without sign, metres
  double turned_deg{0.0};  ///< the turn about the camera that brings them nearest to the surfaces, degrees
};

/// Collects each camera's points within 12 cm of known static surfaces and away from known moving ones, and finds the
/// small turn about the camera that brings them onto the surfaces: one step of point-to-plane ICP (Chen and Medioni,
/// 1991), trimmed (Chetverikov et al., 2002). A camera that is shifted shows as turned, too: 1 cm at 3 m is 0.2
/// degrees. Turns that the surfaces in view do not tell are taken as none, and so are those that move the points across
/// the surfaces by less than these are exact themselves: 5 mm. Not thread safe.
class CameraWatch {
 public:
  CameraWatch();
  ~CameraWatch();
  CameraWatch(const CameraWatch&) = delete;
  CameraWatch& operator=(const CameraWatch&) = delete;

  /// Takes some points of a set. O(points kept x known solids).
  void add(const AssociationInput& input);
  /// The fit of every camera with enough points since the last call, by camera; starts afresh.
  std::vector<CameraFit> take();

 private:
  /// A point near a surface, seen from the camera.
  struct Sample {
    Eigen::Vector3f point;    // world
    Eigen::Vector3f ray;      // unit vector from the camera, world
    Eigen::Vector3f normal;   // of the surface, world
    float distance;           // from the surface along the normal
    float inverse_deviation;  // of the noise across the surface, 1/metres
  };
  struct Model;

  [[nodiscard]] static CameraFit fit(std::int32_t camera, const std::vector<Sample>& samples);

  std::unique_ptr<Model> model_;
  std::map<std::int32_t, std::vector<Sample>> samples_;
};

}  // namespace yarm::perception
