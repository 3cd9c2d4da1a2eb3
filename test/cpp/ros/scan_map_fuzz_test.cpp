// Scans, transforms, maps and poses with absurd numbers and wrong lengths through the readers of amcl and
// slam_gmapping, and what these let through into localisation and map maker, under the sanitizers: refused with a
// reason or survived.
//   scan_map_fuzz_test [messages] [seed]
#include "absurd.hpp"
#include "yarm/ros/map_messages.hpp"
#include "yarm/ros/scan_reader.hpp"
#include "yarm/slam/localiser.hpp"
#include "yarm/slam/mapper.hpp"

#include <console_bridge/console.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

namespace {

using yarm::test::Absurd;
namespace slam = yarm::slam;

std::uint64_t messages_to_try = 10000;
std::uint64_t first_seed = 1;
constexpr std::uint64_t kMostInLibrary = 2000;  // localisation and map maker take a thousand times a reader's time
constexpr std::uint64_t kScansOfOneRobot = 40;

/// In a square room of 4 m; the beams' count does not always fit their angles.
sensor_msgs::LaserScan scan(Absurd& absurd, std::uint32_t nsec) {
  static constexpr std::uint32_t kOdd[] = {0, 1, 2, 7, 3000};
  sensor_msgs::LaserScan made;
  made.header.frame_id = absurd.chance(0.98) ? "laser" : absurd.chance(0.5) ? "" : "nobody";
  made.header.stamp = ros::Time(absurd.chance(0.98) ? 10 : absurd.chance(0.5) ? 0 : 0xfffffffe, nsec);
  made.angle_min = absurd.single(-3.1, -3.0);
  made.angle_max = absurd.single(3.0, 3.1);
  made.angle_increment = absurd.single(0.0174, 0.0176);
  made.range_min = absurd.single(0.05, 0.1);
  made.range_max = absurd.single(6.0, 10.0);
  const std::uint32_t count = absurd.chance(0.97) ? 360 : kOdd[absurd.below(std::size(kOdd))];
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle = -3.05 + 0.0175 * i;
    const double wall = 2.0 / std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle)));
    made.ranges.push_back(absurd.single(wall - 0.01, wall + 0.01));
  }
  return made;
}

geometry_msgs::Transform transform(Absurd& absurd, double x, double yaw) {
  geometry_msgs::Transform made;
  made.translation.x = absurd.number(x, x + 0.01);
  made.translation.y = absurd.number(0.0, 0.01);
  made.translation.z = absurd.number(0.2, 0.3);
  const bool upside_down = absurd.chance(0.01);
  made.rotation.x = upside_down ? std::cos(0.5 * yaw) : absurd.chance(0.01) ? absurd.number(-1.0, 1.0) : 0.0;
  made.rotation.y = upside_down ? std::sin(0.5 * yaw) : 0.0;
  made.rotation.z = upside_down ? 0.0 : std::sin(absurd.number(0.5 * yaw, 0.5 * yaw + 1e-6));
  made.rotation.w = upside_down ? 0.0 : std::cos(absurd.number(0.5 * yaw, 0.5 * yaw + 1e-6));
  return made;
}

/// Where the robot is at a time.
void place(Absurd& absurd, tf2::BufferCore& tf, const ros::Time& stamp, double x, double yaw) {
  geometry_msgs::TransformStamped odometry;
  odometry.header.stamp = stamp;
  odometry.header.frame_id = "odom";
  odometry.child_frame_id = "base";
  odometry.transform = transform(absurd, x, yaw);
  geometry_msgs::TransformStamped mount;
  mount.header.stamp = stamp;
  mount.header.frame_id = "base";
  mount.child_frame_id = "laser";
  mount.transform = transform(absurd, 0.05, 0.0);
  tf2_msgs::TFMessage message;
  message.transforms = {odometry, mount};
  static_cast<void>(yarm::takeTransforms(message, false, tf));
}

nav_msgs::OccupancyGrid map(Absurd& absurd) {
  static constexpr std::uint32_t kOdd[] = {0, 1, 65536, 0x7fffffff, 0xffffffff};
  nav_msgs::OccupancyGrid made;
  made.info.resolution = absurd.single(0.05, 0.2);
  made.info.width = absurd.chance(0.05) ? kOdd[absurd.below(std::size(kOdd))] : 5 + absurd.below(60);
  made.info.height = absurd.chance(0.05) ? kOdd[absurd.below(std::size(kOdd))] : 5 + absurd.below(60);
  made.info.origin.position.x = absurd.number(-3.0, -1.0);
  made.info.origin.position.y = absurd.number(-3.0, -1.0);
  made.info.origin.orientation.z = absurd.chance(0.1) ? absurd.number(-1.0, 1.0) : 0.0;
  made.info.origin.orientation.w = absurd.chance(0.1) ? absurd.number(-1.0, 1.0) : 1.0;
  const std::uint64_t count = static_cast<std::uint64_t>(made.info.width) * made.info.height;
  const std::uint64_t sent = absurd.chance(0.05) ? absurd.below(5000) : std::min<std::uint64_t>(count, 5000);
  for (std::uint64_t i = 0; i < sent; ++i) {
    const std::uint64_t column = i % std::max(1U, made.info.width);
    const bool is_wall = i < made.info.width || column == 0 || column + 1 == made.info.width;
    made.data.push_back(static_cast<std::int8_t>(absurd.chance(0.05) ? absurd.below(256) : is_wall ? 100 : 0));
  }
  return made;
}

geometry_msgs::PoseWithCovariance pose(Absurd& absurd) {
  geometry_msgs::PoseWithCovariance made;
  made.pose.position.x = absurd.number(-2.0, 2.0);
  made.pose.position.y = absurd.number(-2.0, 2.0);
  made.pose.orientation.z = absurd.chance(0.1) ? absurd.number(-1.0, 1.0) : 0.0;
  made.pose.orientation.w = absurd.chance(0.1) ? absurd.number(-1.0, 1.0) : 1.0;
  for (std::size_t i = 0; i < 36; i += 7) {
    made.covariance[i] = absurd.number(0.01, 0.3);
  }
  if (absurd.chance(0.05)) {
    made.covariance[absurd.below(36)] = absurd.number(-1.0, 1.0);
  }
  return made;
}

/// Robots that map, and that localise themselves in a map, one after the other.
class Robots {
 public:
  void take(const slam::Scan& scan) {
    ASSERT_FALSE(mapper_->addScan(scan).reason.find("nan") != std::string::npos) << "no number it has";
    if (localiser_) {
      const slam::LocaliserResult result = localiser_->addScan(scan);
      ASSERT_TRUE(!result.has_pose || std::isfinite(result.T_map_base.x + result.T_map_base.y + result.T_map_base.yaw));
    }
  }
  void take(const yarm::GridWithOrigin& map) {
    try {
      localiser_ = std::make_unique<slam::Localiser>(slam::turtlebotLocaliser(), map.grid, map.T_map_grid);
    } catch (const std::invalid_argument& error) {
      ASSERT_STRNE(error.what(), "");
    }
  }
  void take(const slam::PoseBelief& belief) {
    if (localiser_) {
      localiser_->believe(belief);
    }
  }
  void renew() {
    mapper_ = std::make_unique<slam::Mapper>(slam::Params{});
    localiser_.reset();
  }

 private:
  std::unique_ptr<slam::Mapper> mapper_ = std::make_unique<slam::Mapper>(slam::Params{});
  std::unique_ptr<slam::Localiser> localiser_;
};

/// What became of the messages of one kind.
struct Count {
  std::uint64_t taken = 0;
  std::uint64_t refused = 0;

  void add(bool good) { ++(good ? taken : refused); }
  void expectBoth(const char* what) const {
    std::printf("%s: %llu taken, %llu refused\n", what, static_cast<unsigned long long>(taken),
                static_cast<unsigned long long>(refused));
    EXPECT_GT(taken, 0U) << what;
    EXPECT_GT(refused, 0U) << what;
  }
};

TEST(Readers, surviveMessagesThatLieAndTheRestSurvivesWhatTheyLetThrough) {
  console_bridge::setLogLevel(console_bridge::CONSOLE_BRIDGE_LOG_NONE);
  Absurd absurd(first_seed);
  Robots robots;
  Count scans, maps, poses;
  tf2::BufferCore tf;
  const yarm::ScanReaderParams params{"base", "odom", 0.3, 0.05, 20.0};
  for (std::uint64_t i = 0; i < messages_to_try; ++i) {
    const std::uint64_t step = i % kScansOfOneRobot;
    const bool in_library = i < kMostInLibrary;
    std::string reason;
    if (step == 0) {
      tf.clear();
      robots.renew();
      absurd.rate(0.01);
      const auto read = yarm::gridOf(map(absurd), &reason);
      ASSERT_TRUE(read || !reason.empty());
      maps.add(read.has_value());
      if (read && in_library) {
        robots.take(*read);
      }
    }
    if (step % 8 == 0) {
      absurd.rate(0.005);
      const auto read = yarm::beliefOf(pose(absurd), &reason);
      ASSERT_TRUE(read || !reason.empty());
      poses.add(read.has_value());
      if (read && in_library) {
        robots.take(*read);
      }
    }
    absurd.rate(absurd.chance(0.3) ? 0.02 : 0.0);
    const sensor_msgs::LaserScan message = scan(absurd, static_cast<std::uint32_t>(step + 1) * 20000000U);
    place(absurd, tf, message.header.stamp, 0.02 * static_cast<double>(step), 0.2 * static_cast<double>(step));
    const yarm::ScanOrFault read = yarm::readScan(message, tf, params);
    ASSERT_EQ(read.fault.empty(), read.topic.empty()) << read.fault;
    scans.add(read.fault.empty());
    if (read.fault.empty() && in_library) {
      robots.take(read.scan);
    }
  }
  scans.expectBoth("scans");
  maps.expectBoth("maps");
  poses.expectBoth("poses");
}

TEST(Readers, refuseTransformsThatWouldEndTheProcess) {
  Absurd absurd(first_seed);
  for (const std::uint32_t sec : {0U, 10U, 0x7fffffffU, 0x80000000U, 0xffffffffU}) {
    tf2::BufferCore tf;
    tf2_msgs::TFMessage message;
    message.transforms.resize(1);
    message.transforms[0].header.frame_id = "odom";
    message.transforms[0].child_frame_id = "base";
    message.transforms[0].header.stamp = ros::Time(sec, 999999999);
    message.transforms[0].transform = transform(absurd, 0.0, 0.0);
    const std::string fault = yarm::takeTransforms(message, false, tf);
    EXPECT_EQ(fault.empty(), sec <= 0x7fffffffU) << fault;
    EXPECT_EQ(tf.canTransform("odom", "base", ros::Time()), sec <= 0x7fffffffU);
  }
}

TEST(Readers, refuseAScanAfterWhichNothingCanBeSent) {
  Absurd absurd(first_seed);
  tf2::BufferCore tf;
  sensor_msgs::LaserScan message = scan(absurd, 0);
  message.header.frame_id = "laser";
  for (const std::uint32_t sec : {10U, 0x7fffffffU, 0x80000000U, 0xffffffffU}) {
    message.header.stamp = ros::Time(sec, 999999999);
    tf.clear();
    place(absurd, tf, message.header.stamp, 0.0, 0.0);
    const yarm::ScanOrFault read = yarm::readScan(message, tf, {"base", "odom", 0.3, 0.05, 20.0});
    EXPECT_EQ(read.topic, sec > 0x7fffffffU ? "stamp" : "") << read.fault;
  }
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    messages_to_try = std::strtoull(argv[1], nullptr, 10);
  }
  if (argc > 2) {
    first_seed = std::strtoull(argv[2], nullptr, 10);
  }
  std::printf("seed %llu\n", static_cast<unsigned long long>(first_seed));
  return RUN_ALL_TESTS();
}
