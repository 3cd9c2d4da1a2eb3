// Does a camera show what is there now? A picture that never changes shows nothing, and dirt shows as a hole that
// stays.
#pragma once

#include "yarm/perception/types.hpp"

#include <cstdint>
#include <vector>

namespace yarm::perception {

/// When a camera's pictures count as frozen, or a part of them as covered.
struct PictureWatchParams {
  double frozen_after{0.0};  ///< a picture the same to the byte for so long, by its stamps, is frozen, s; 0 for never
  double spot_after{0.0};    ///< a part of the image without readings for so long is covered, s; 0 for never
  double nearest{0.3};       ///< a depth below this is no reading, metres
};

/// What a camera's newest picture tells of the camera.
struct Picture {
  bool frozen{false};
  double same_s{0.0};   ///< how long it has been the same to the byte, s
  double covered{0.0};  ///< share of the image that used to have readings and has had none for `spot_after`
  int u{0};             ///< middle of that part, pixels
  int v{0};
};

/// Follows the pictures of each camera. Noise changes every picture of a real depth camera, so one that stays the same
/// is not a picture of now; recordings of one cloud and simulations without noise are frozen, too. Not thread safe.
class PictureWatch {
 public:
  PictureWatch(const PictureWatchParams& params, std::size_t cameras) : params_(params), cameras_(cameras) {}

  /// Judges a camera's new cloud, whose stamp is newer than the last one's. Looks at one point of sixteen for changes,
  /// and at one of four, of one cloud in five, for readings.
  Picture judge(std::size_t camera, const CameraCloud& cloud);
  /// Forgets everything (the scene was started again).
  void reset();

 private:
  static constexpr std::size_t kEdge = 20;  // parts of the image along each side

  struct Part {
    float smooth{0.F};  // share of readings, over about ten looks
    float usual{0.F};   // the largest of these
    StampNs dead_ns{0};
    bool dead{false};
  };
  struct Camera {
    std::uint64_t print{0};
    StampNs same_ns{0};
    int clouds{0};
    std::vector<Part> parts;
    Picture last;
  };

  void lookForSpots(Camera& camera, const CameraCloud& cloud) const;
  void tellSpots(Camera& camera, const CameraCloud& cloud) const;

  PictureWatchParams params_;
  std::vector<Camera> cameras_;
};

}  // namespace yarm::perception
