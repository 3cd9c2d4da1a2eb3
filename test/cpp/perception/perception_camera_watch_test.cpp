// A camera that is off shows in its points near known static surfaces; one that is not, does not.
#include "association_score.hpp"

#include "yarm/perception/camera_watch.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace yarm::test {
namespace {

constexpr int kSets = 6;  // about a second's

/// The fits of all cameras after some sets of a scene, camera `off` turned about an axis of its optical frame.
std::vector<pc::CameraFit> fits(const Scene& scene, std::uint64_t seed, std::size_t off, double turn_deg,
                                const Eigen::Vector3f& axis) {
  SceneFactory factory(seed);
  const auto backend = pc::makeBackend("fused", {}, {});
  const auto seeds = scene.seeds(1);
  const pc::Knowledge knowledge = scene.knowledge();
  pc::CameraWatch watch;
  pc::MergedSet set;
  for (int k = 0; k < kSets; ++k) {
    factory.render(scene);
    std::vector<pc::CameraCloud> clouds = factory.clouds(1);
    clouds[off].T_world_camera.rotate(Eigen::AngleAxisf(static_cast<float>(turn_deg * M_PI / 180.0), axis));
    backend->merge(clouds, set);
    watch.add({&set, &seeds, &knowledge, &scene.poses, false});
  }
  return watch.take();
}

TEST(CameraWatch, CamerasThatAreRightAreNotCalledOff) {
  double worst = 0.0;
  for (const Sequence& sequence : scoredSequences()) {
    for (const int k : {0, sequence.sets / 2, sequence.sets - 1}) {
      Scene scene = sequence.scene;
      for (int i = 0; i <= k; ++i) {
        sequence.at(scene, i);
      }
      for (const pc::CameraFit& fit : fits(scene, 5, 0, 0.0, Eigen::Vector3f::UnitX())) {
        worst = std::max(worst, fit.turned_deg);
        EXPECT_LT(fit.turned_deg, pc::CameraWatchParams().warn_deg) << sequence.name << ", set " << k;
      }
    }
  }
  std::printf("cameras that are right: at most %.2f deg\n", worst);
}

TEST(CameraWatch, ATurnedCameraIsNamedAndMeasured) {
  const Scene scene = standardCell(2, 2);
  const pc::CameraWatchParams params;
  for (std::size_t camera = 0; camera < 4; ++camera) {
    for (const Eigen::Vector3f& axis : {Eigen::Vector3f(1.F, 0.F, 0.F), Eigen::Vector3f(0.F, 1.F, 0.F)}) {
      for (const double turn_deg : {1.0, -1.0, 2.0}) {
        const auto found = fits(scene, 6, camera, turn_deg, axis);
        ASSERT_EQ(found.size(), 4U);
        for (std::size_t c = 0; c < 4; ++c) {
          if (c != camera) {
            EXPECT_LT(found[c].turned_deg, params.warn_deg) << "camera " << c;
          }
        }
        std::printf("camera %zu turned by %4.1f deg about %s: found %.2f deg, %.0f mm off\n", camera, turn_deg,
                    axis.x() > 0.F ? "x" : "y", found[camera].turned_deg, 1000.0 * found[camera].off_m);
        EXPECT_GT(found[camera].turned_deg, params.warn_deg) << "camera " << camera;
        EXPECT_GT(found[camera].turned_deg, std::abs(turn_deg) > 1.5 ? params.error_deg : 0.0) << "camera " << camera;
        EXPECT_LT(found[camera].turned_deg, 1.4 * std::abs(turn_deg)) << "camera " << camera;
      }
    }
  }
}

TEST(CameraWatch, WithoutStaticSurfacesNothingIsSaid) {
  Scene scene = standardCell(2, 0);
  scene.remove("table");
  scene.remove("stand");
  EXPECT_TRUE(fits(scene, 7, 1, 2.0, Eigen::Vector3f::UnitX()).empty());
}

}  // namespace
}  // namespace yarm::test
