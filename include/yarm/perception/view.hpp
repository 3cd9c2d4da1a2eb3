// Does a camera see? A map must not say "free" because nothing was seen.
#pragma once

#include "yarm/perception/types.hpp"

#include <string>
#include <vector>

namespace yarm::perception {

/// When a camera counts as seeing, and a set of cameras as a view. A cloud's view is its share of finite points: every
/// camera of a cell sees floor or bodies nearly everywhere, and NaN where nothing is in range.
struct ViewParams {
  double min_view{0.02};      ///< least share of finite points of a camera that sees
  double usual_view{0.5};     ///< and the least part of what that camera usually sees
  double least_cameras{0.5};  ///< least share of the cameras that must see
};

/// What one camera's cloud shows.
struct View {
  bool sees{false};
  double share{0.0};  ///< of finite points
  double usual{0.0};  ///< the largest share this camera has shown, smoothed over about ten clouds
};

/// Follows what each camera sees. Not thread safe.
class ViewWatch {
 public:
  ViewWatch(const ViewParams& params, std::size_t cameras) : params_(params), cameras_(cameras) {}

  /// Judges a camera's new cloud.
  View judge(std::size_t camera, const CameraReport& report);
  /// Cameras that must see for a set to be a map: at least one.
  [[nodiscard]] std::size_t needed() const;
  /// Forgets what is usual (the scene was started again).
  void reset();

 private:
  struct Camera {
    double smooth{0.0};
    double usual{0.0};
    bool heard{false};
  };

  ViewParams params_;
  std::vector<Camera> cameras_;
};

}  // namespace yarm::perception
