// When a camera counts as seeing.
#include "yarm/perception/view.hpp"

#include <gtest/gtest.h>

namespace yarm::test {
namespace {

namespace pc = yarm::perception;

pc::CameraReport report(std::size_t finite, std::size_t points = 1000) {
  pc::CameraReport made;
  made.points = points;
  made.finite = finite;
  return made;
}

TEST(ViewWatch, ACameraThatSeesNothingIsBlindFromTheFirstCloudOn) {
  pc::ViewWatch watch({}, 1);
  EXPECT_FALSE(watch.judge(0, report(0)).sees);
  EXPECT_FALSE(watch.judge(0, report(0, 0)).sees);
  EXPECT_FALSE(watch.judge(0, report(19)).sees);
  EXPECT_TRUE(watch.judge(0, report(20)).sees);
}

TEST(ViewWatch, HalfOfWhatItUsuallySeesIsNeededForEver) {
  pc::ViewWatch watch({}, 2);
  for (int cloud = 0; cloud < 30; ++cloud) {
    EXPECT_TRUE(watch.judge(1, report(800)).sees);
  }
  for (int cloud = 0; cloud < 1000; ++cloud) {
    EXPECT_FALSE(watch.judge(1, report(399)).sees);
  }
  const pc::View back = watch.judge(1, report(401));
  EXPECT_TRUE(back.sees);
  EXPECT_NEAR(back.share, 0.401, 1e-9);
  EXPECT_NEAR(back.usual, 0.8, 1e-6);
  EXPECT_TRUE(watch.judge(0, report(100)).sees);  // the other camera has its own
  watch.reset();
  EXPECT_TRUE(watch.judge(1, report(399)).sees);
}

TEST(ViewWatch, OneRichCloudDoesNotRaiseWhatIsUsual) {
  pc::ViewWatch watch({}, 1);
  watch.judge(0, report(300));
  watch.judge(0, report(1000));
  EXPECT_TRUE(watch.judge(0, report(300)).sees);
}

TEST(ViewWatch, TheCamerasNeededAreAShareAndAtLeastOne) {
  EXPECT_EQ(pc::ViewWatch({}, 4).needed(), 2U);
  EXPECT_EQ(pc::ViewWatch({}, 3).needed(), 2U);
  EXPECT_EQ(pc::ViewWatch({}, 1).needed(), 1U);
  pc::ViewParams none;
  none.least_cameras = 0.0;
  EXPECT_EQ(pc::ViewWatch(none, 4).needed(), 1U);
}

}  // namespace
}  // namespace yarm::test
