// Clouds whose layout lies, read under AddressSanitizer: whatever viewOf lets through can be read to its last byte.
//   cloud_reader_fuzz_test [clouds] [seed]
// The first number is how many clouds to try; the tests try few, bench/perception_nodes.py many.
#include "crop_kernel.hpp"
#include "yarm/ros/conversions.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>

namespace {

namespace pc = yarm::perception;
using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

std::uint64_t clouds_to_try = 20'000;
std::uint64_t first_seed = 1;

class Fuzzer {
 public:
  explicit Fuzzer(std::uint64_t seed) : random_(seed) {}

  PointCloud2 next() {
    PointCloud2 cloud = plausible();
    const std::uint32_t lies = pick(4);
    for (std::uint32_t i = 0; i < lies; ++i) {
      lie(cloud);
    }
    cloud.data.shrink_to_fit();
    return cloud;
  }

 private:
  std::uint32_t pick(std::uint32_t below) { return static_cast<std::uint32_t>(random_() % below); }

  std::uint32_t oddNumber() {
    static const std::uint32_t odd[] = {0,   1,   2,     3,     4,          7,          8,          11,
                                        12,  13,  15,    16,    17,         31,         32,         100,
                                        255, 256, 65535, 65536, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFB, 0xFFFFFFFF};
    return pick(3) == 0 ? static_cast<std::uint32_t>(random_()) : odd[pick(sizeof(odd) / sizeof(odd[0]))];
  }

  float oddFloat() {
    static const float odd[] = {0.F,
                                1.F,
                                -1.F,
                                1e30F,
                                99.F,
                                101.F,
                                std::numeric_limits<float>::infinity(),
                                std::numeric_limits<float>::quiet_NaN(),
                                std::numeric_limits<float>::denorm_min()};
    if (pick(8) != 0) {
      return static_cast<float>(pick(2000)) * 0.002F - 2.F;
    }
    return odd[pick(sizeof(odd) / sizeof(odd[0]))];
  }

  PointCloud2 plausible() {
    PointCloud2 cloud;
    const std::uint32_t steps[] = {12, 13, 16, 16, 16, 20, 32};
    cloud.point_step = steps[pick(7)];
    cloud.width = pick(40);
    cloud.height = 1 + pick(5);
    cloud.row_step = cloud.width * cloud.point_step + (pick(4) == 0 ? pick(20) : 0);
    const char* const names[] = {"x", "y", "z"};
    const std::uint32_t shift = cloud.point_step > 12 && pick(3) == 0 ? 1 : 0;
    for (std::uint32_t i = 0; i < 3; ++i) {
      PointField field;
      field.name = names[i];
      field.offset = 4 * i + shift;
      field.datatype = PointField::FLOAT32;
      field.count = 1;
      cloud.fields.push_back(field);
    }
    cloud.data.resize(static_cast<std::size_t>(cloud.row_step) * cloud.height);
    for (std::size_t i = 0; i + 4 <= cloud.data.size(); i += 4) {
      const float value = oddFloat();
      std::memcpy(&cloud.data[i], &value, 4);
    }
    return cloud;
  }

  void lie(PointCloud2& cloud) {
    switch (pick(10)) {
      case 0:
        cloud.width = oddNumber();
        break;
      case 1:
        cloud.height = oddNumber();
        break;
      case 2:
        cloud.point_step = oddNumber();
        break;
      case 3:
        cloud.row_step = oddNumber();
        break;
      case 4:
        cloud.fields[pick(static_cast<std::uint32_t>(cloud.fields.size()))].offset = oddNumber();
        break;
      case 5:
        cloud.fields[pick(static_cast<std::uint32_t>(cloud.fields.size()))].datatype =
            static_cast<std::uint8_t>(pick(256));
        break;
      case 6:
        cloud.fields[pick(static_cast<std::uint32_t>(cloud.fields.size()))].count = oddNumber();
        break;
      case 7:
        cloud.is_bigendian = static_cast<std::uint8_t>(pick(256));
        break;
      case 8:
        cloud.data.resize(pick(static_cast<std::uint32_t>(cloud.data.size()) + 40));
        break;
      default:
        cloud.fields.push_back(cloud.fields[0]);
        cloud.fields.back().name = std::string(pick(5), 'x');
        break;
    }
  }

  std::mt19937_64 random_;
};

TEST(CloudReader, survivesCloudsThatLie) {
  Fuzzer fuzzer(first_seed);
  pc::CropSetup setup = pc::makeCropSetup(pc::MergeParams(), Eigen::Isometry3f::Identity());
  std::vector<pc::Survivor> fast;
  std::vector<pc::Survivor> plain;
  std::uint64_t accepted = 0;
  std::uint64_t points = 0;
  for (std::uint64_t i = 0; i < clouds_to_try; ++i) {
    const PointCloud2 cloud = fuzzer.next();
    const auto view = yarm::viewOf(cloud);
    if (!view.ok()) {
      continue;
    }
    ++accepted;
    points += view.value.width * view.value.height;
    fast.clear();
    plain.clear();
    const pc::CropCount count = pc::cropCloud(setup, view.value, fast);
    const pc::CropCount plain_count = pc::cropCloud(setup, view.value, plain, true);
    EXPECT_EQ(count.finite, plain_count.finite);
    EXPECT_EQ(count.absurd, plain_count.absurd);
    EXPECT_LE(count.finite + count.absurd, view.value.width * view.value.height);
    EXPECT_EQ(fast.size(), plain.size());
  }
  std::printf("%llu clouds, %llu of them read, %llu points\n", static_cast<unsigned long long>(clouds_to_try),
              static_cast<unsigned long long>(accepted), static_cast<unsigned long long>(points));
  EXPECT_GT(accepted, clouds_to_try / 10);
  EXPECT_LT(accepted, clouds_to_try);
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    clouds_to_try = std::strtoull(argv[1], nullptr, 10);
  }
  if (argc > 2) {
    first_seed = std::strtoull(argv[2], nullptr, 10);
  }
  return RUN_ALL_TESTS();
}
