// The ROS edge of perception: layouts that lie, messages there and back, seeds in time, parameters refused all at once.
#include "yarm/ros/conversions.hpp"
#include "yarm/ros/node_params.hpp"
#include "yarm/ros/pool.hpp"
#include "yarm/ros/side_object.hpp"
#include "yarm/sync/seed_buffer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

namespace {

namespace pc = yarm::perception;
using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

PointCloud2 goodCloud(std::uint32_t width = 4, std::uint32_t height = 3, std::uint32_t step = 16) {
  PointCloud2 cloud;
  const char* const fields[] = {"x", "y", "z", "rgb"};
  for (std::uint32_t i = 0; i < 4; ++i) {
    PointField field;
    field.name = fields[i];
    field.offset = 4 * i;
    field.datatype = PointField::FLOAT32;
    field.count = 1;
    cloud.fields.push_back(field);
  }
  cloud.width = width;
  cloud.height = height;
  cloud.point_step = step;
  cloud.row_step = width * step;
  cloud.data.resize(static_cast<std::size_t>(cloud.row_step) * height);
  cloud.header.stamp.fromNSec(1'500'000'000);
  return cloud;
}

TEST(ViewOf, aGoodCloudIsReadInPlace) {
  const PointCloud2 cloud = goodCloud();
  const auto view = yarm::viewOf(cloud);
  ASSERT_TRUE(view.ok()) << view.reason;
  EXPECT_EQ(view.value.data, cloud.data.data());
  EXPECT_EQ(view.value.width * view.value.height, 12U);
  EXPECT_EQ(view.value.z_offset, 8U);
  EXPECT_EQ(view.value.stamp_ns, 1'500'000'000);
}

TEST(ViewOf, anEmptyCloudIsGood) {
  EXPECT_TRUE(yarm::viewOf(goodCloud(0, 0)).ok());
  EXPECT_TRUE(yarm::viewOf(goodCloud(0, 1)).ok());
  PointCloud2 many_rows = goodCloud(0, 1);
  many_rows.height = 0xFFFFFFFF;
  EXPECT_EQ(yarm::viewOf(many_rows).value.height, 0U);  // nobody is to walk through four billion empty rows
}

TEST(ViewOf, paddedRowsAreGood) {
  PointCloud2 cloud = goodCloud();
  cloud.row_step += 64;
  cloud.data.resize(static_cast<std::size_t>(cloud.row_step) * cloud.height - 64);  // the last row needs no padding
  EXPECT_TRUE(yarm::viewOf(cloud).ok());
  cloud.data.pop_back();
  EXPECT_FALSE(yarm::viewOf(cloud).ok());
}

template <class Spoil>
std::string reasonAfter(Spoil spoil) {
  PointCloud2 cloud = goodCloud();
  spoil(cloud);
  return yarm::viewOf(cloud).reason;
}

TEST(ViewOf, everyLieIsNamed) {
  const auto has = [](const std::string& reason, const char* part) {
    EXPECT_NE(reason.find(part), std::string::npos) << "'" << reason << "' lacks '" << part << "'";
  };
  has(reasonAfter([](PointCloud2& c) { c.is_bigendian = 1; }), "big-endian");
  has(reasonAfter([](PointCloud2& c) { c.point_step = 0; }), "point_step 0");
  has(reasonAfter([](PointCloud2& c) { c.fields[1].name = "w"; }), "field y is missing");
  has(reasonAfter([](PointCloud2& c) { c.fields[3].name = "x"; }), "twice");
  has(reasonAfter([](PointCloud2& c) { c.fields[2].datatype = PointField::FLOAT64; }), "datatype 8");
  has(reasonAfter([](PointCloud2& c) { c.fields[2].count = 3; }), "count 3");
  has(reasonAfter([](PointCloud2& c) { c.fields[2].offset = 13; }), "offset 13 lies outside");
  has(reasonAfter([](PointCloud2& c) { c.fields[2].offset = 0xFFFFFFFF; }), "lies outside");
  has(reasonAfter([](PointCloud2& c) { c.row_step = 1; }), "row_step 1");
  has(reasonAfter([](PointCloud2& c) { c.data.pop_back(); }), "data holds 191 bytes, the layout needs 192");
  has(reasonAfter([](PointCloud2& c) { c.width = c.height = 0xFFFFFFFF; }), "points, at most");
  has(reasonAfter([](PointCloud2& c) { c.fields.resize(100); }), "100 fields");
}

pc::MergedSet someSet() {
  pc::MergedSet set;
  set.stamp_ns = 2'000'000'123;
  set.points = {{0.1F, 0.2F, 0.3F, 0.01F, 1.F, 0.F, 0.F, 2}, {-1.F, 2.F, 1.F, 0.02F, 0.F, 1.F, 0.F, 0}};
  return set;
}

TEST(MergedPoints, comeBackAsTheyWere) {
  const pc::MergedSet set = someSet();
  PointCloud2 message;
  message.header.stamp = yarm::toTime(set.stamp_ns);
  yarm::fillMergedPoints(set, message);
  pc::MergedSet back;
  back.centroids.resize(7);
  ASSERT_TRUE(yarm::readMergedPoints(message, pc::MergeParams(), back).ok());
  EXPECT_EQ(back.stamp_ns, set.stamp_ns);
  EXPECT_TRUE(back.centroids.empty());
  ASSERT_EQ(back.points.size(), 2U);
  EXPECT_EQ(back.points[0].sigma, set.points[0].sigma);
  EXPECT_EQ(back.points[0].camera, 2);
}

TEST(MergedPoints, absentCamerasTravelAlong) {
  pc::MergedSet set = someSet();
  set.absent = {1, 3};
  PointCloud2 message;
  yarm::fillMergedPoints(set, message);
  EXPECT_EQ(message.is_dense, 0);
  EXPECT_EQ(message.width, 4U);
  EXPECT_EQ(message.data.size(), message.row_step);
  pc::MergedSet back;
  back.absent = {7};
  ASSERT_TRUE(yarm::readMergedPoints(message, pc::MergeParams(), back).ok());
  EXPECT_EQ(back.absent, set.absent);
  EXPECT_EQ(back.points.size(), 2U);
  yarm::fillMergedPoints(someSet(), message);
  ASSERT_TRUE(yarm::readMergedPoints(message, pc::MergeParams(), back).ok());
  EXPECT_TRUE(back.absent.empty());
}

TEST(MergedPoints, aPointOutsideTheBoxIsRefused) {
  for (const float bad : {3.F, -3.F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    pc::MergedSet set = someSet();
    set.points[1].y = bad;
    PointCloud2 message;
    yarm::fillMergedPoints(set, message);
    EXPECT_FALSE(yarm::readMergedPoints(message, pc::MergeParams(), set).ok()) << bad;
  }
}

TEST(MergedPoints, anotherLayoutIsRefused) {
  pc::MergedSet set;
  EXPECT_FALSE(yarm::readMergedPoints(goodCloud(), pc::MergeParams(), set).ok());
}

TEST(Associated, comesBackAsItWas) {
  pc::AssociatedSet set;
  set.stamp_ns = 5'000'000'001;
  pc::AssociatedObject object;
  object.name = "debris_1";
  object.object = pc::ObjectKind::kDebris;
  object.is_static = false;
  object.stamp_ns = 4'900'000'000;
  object.T_world_seed.translation() = Eigen::Vector3d(1.0, 2.0, 3.0);
  object.T_world_seed.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  object.points = {{0.1F, 0.2F, 0.3F}};
  object.hidden = {{0.4F, 0.5F, 0.6F}, {0.7F, 0.8F, 0.9F}};
  object.attached_to = {"table"};
  object.piece = pc::PieceView{12, {0.1, 0.2, 0.77}, 0.4, 0.15, 0.06, 0b1010U};
  object.carried = pc::CarriedPiece{"ankurbot_1", Eigen::Isometry3d(Eigen::Translation3d(0.01, 0.02, -0.1))};
  set.objects = {object};
  pc::GridSpec grid;
  grid.size = {10, 20, 30};
  yarm::AssociatedClusterVector message;
  yarm::fillAssociated(set, grid, message);
  pc::AssociatedSet back;
  pc::GridSpec grid_back;
  const auto read = yarm::readAssociated(message, back, grid_back);
  ASSERT_TRUE(read.ok()) << read.reason;
  EXPECT_EQ(grid_back.size, grid.size);
  EXPECT_EQ(back.stamp_ns, set.stamp_ns);
  ASSERT_EQ(back.objects.size(), 1U);
  const pc::AssociatedObject& b = back.objects[0];
  EXPECT_EQ(b.name, object.name);
  EXPECT_EQ(b.object, object.object);
  EXPECT_FALSE(b.is_static);
  EXPECT_EQ(b.stamp_ns, object.stamp_ns);
  EXPECT_TRUE(b.T_world_seed.isApprox(object.T_world_seed, 1e-12));
  EXPECT_EQ(b.points, object.points);
  EXPECT_EQ(b.hidden, object.hidden);
  EXPECT_EQ(b.attached_to, object.attached_to);
  ASSERT_TRUE(b.piece);
  EXPECT_EQ(b.piece->points, 12U);
  EXPECT_EQ(b.piece->top, object.piece->top);
  EXPECT_EQ(b.piece->axis_rad, 0.4);
  EXPECT_EQ(b.piece->length, 0.15);
  EXPECT_EQ(b.piece->width, 0.06);
  EXPECT_EQ(b.piece->cameras, 0b1010U);
  ASSERT_TRUE(b.carried);
  EXPECT_EQ(b.carried->robot, "ankurbot_1");
  EXPECT_TRUE(b.carried->T_tip_piece.isApprox(object.carried->T_tip_piece, 1e-12));
}

TEST(Associated, whatIsNoPieceOfDebrisStaysSo) {
  pc::AssociatedSet set;
  set.objects.resize(1);
  set.objects[0].name = "table";
  yarm::AssociatedClusterVector message;
  yarm::fillAssociated(set, {}, message);
  pc::AssociatedSet back;
  back.objects.resize(1);
  back.objects[0].piece = pc::PieceView{};
  back.objects[0].carried = pc::CarriedPiece{};
  pc::GridSpec grid;
  ASSERT_TRUE(yarm::readAssociated(message, back, grid).ok());
  EXPECT_FALSE(back.objects[0].piece);
  EXPECT_FALSE(back.objects[0].carried);
}

TEST(Associated, aPieceWithAbsurdNumbersIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  pc::PieceView view{12, {0.1, 0.2, 0.77}, 0.4, 0.15, 0.06, 1U};
  EXPECT_TRUE(yarm::readPiece(yarm::pieceMessage("debris_1", view)).ok());
  view.axis_rad = nan;
  EXPECT_FALSE(yarm::readPiece(yarm::pieceMessage("debris_1", view)).ok());
  pc::CarriedPiece carried{"ankurbot_1", Eigen::Isometry3d::Identity()};
  EXPECT_TRUE(yarm::readCarried(yarm::carriedMessage("debris_1", carried)).ok());
  carried.T_tip_piece.translation().x() = nan;
  EXPECT_FALSE(yarm::readCarried(yarm::carriedMessage("debris_1", carried)).ok());
  carried = {"", Eigen::Isometry3d::Identity()};
  EXPECT_FALSE(yarm::readCarried(yarm::carriedMessage("debris_1", carried)).ok());
}

TEST(Associated, whatNobodyRegisteredIsToldByAFieldNotByItsName) {
  pc::AssociatedSet set;
  set.objects.resize(2);
  set.objects[0].name = pc::unknownName(12);
  set.objects[0].is_unknown = true;
  set.objects[1].name = "unknown_1";  // somebody registered a thing under such a name
  yarm::AssociatedClusterVector message;
  yarm::fillAssociated(set, {}, message);
  pc::AssociatedSet read;
  pc::GridSpec grid;
  ASSERT_EQ(yarm::readAssociated(message, read, grid).reason, "");
  EXPECT_EQ(read.objects[0].name, "unknown_12");
  EXPECT_TRUE(read.objects[0].is_unknown);
  EXPECT_FALSE(read.objects[1].is_unknown);
}

TEST(Associated, nonsenseIsRefusedAllAtOnce) {
  yarm::AssociatedClusterVector message;
  message.clusters.resize(1);
  message.clusters[0].frame = "thing";
  message.clusters[0].object = "Spoon";
  pc::AssociatedSet set;
  pc::GridSpec grid;
  const std::string reason = yarm::readAssociated(message, set, grid).reason;
  for (const char* part : {"the grid has 0 cells", "unknown kind 'Spoon'", "quaternion has length 0"}) {
    EXPECT_NE(reason.find(part), std::string::npos) << reason;
  }
}

pc::SeenCells seenCells() {
  using State = pc::CellState;
  return {{{1.0, 2.0, 3.0}, {-1.0, 0.0, 2.5}},
          {State::kFree, State::kHidden, State::kOccupied, State::kNeverSeen},
          {1, 2},
          {2, 0}};
}

TEST(SeenCells, comeBackAsTheyWere) {
  const pc::SeenCells seen = seenCells();
  yarm::SeenCells message;
  yarm::fillSeenCells(seen, message);
  message.age_s.assign(4, 0.5F);
  pc::SeenCells back;
  const auto read = yarm::readSeenCells(message, 4, back);
  ASSERT_TRUE(read.ok()) << read.reason;
  EXPECT_EQ(back.cameras, seen.cameras);
  EXPECT_EQ(back.states, seen.states);
  EXPECT_EQ(back.behind, seen.behind);
  EXPECT_EQ(back.unseen, seen.unseen);
}

TEST(SeenCells, everyLieIsNamed) {
  const auto reason = [](auto spoil) {
    yarm::SeenCells message;
    yarm::fillSeenCells(seenCells(), message);
    spoil(message);
    pc::SeenCells back;
    return yarm::readSeenCells(message, 4, back).reason;
  };
  const auto has = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' lacks '" << part << "'";
  };
  has(reason([](yarm::SeenCells& m) { m.states[2] = 4; }), "states must be 0 to 3");
  has(reason([](yarm::SeenCells& m) { m.states[2] = -1; }), "states must be 0 to 3");
  has(reason([](yarm::SeenCells& m) { m.states.pop_back(); }), "3 states and 0 ages, the map has 4 cells");
  has(reason([](yarm::SeenCells& m) { m.age_s.resize(3); }), "4 states and 3 ages, the map has 4 cells");
  has(reason([](yarm::SeenCells& m) { m.behind.pop_back(); }), "1 and 2 entries for 2 cells that are not seen");
  has(reason([](yarm::SeenCells& m) { m.unseen.resize(9); }), "2 and 9 entries for 2 cells that are not seen");
  has(reason([](yarm::SeenCells& m) { m.cameras.resize(17); }), "17 cameras, at most 16");
}

TEST(Registry, solidsAreReadAndNonsenseIsNamed) {
  yarm::ObjectRegistry message;
  message.entries.resize(2);
  yarm::RegisteredObject& table = message.entries[0];
  table.name = "table";
  table.shapes.resize(1);
  table.shapes[0].type = shape_msgs::SolidPrimitive::CYLINDER;
  table.shapes[0].dimensions = {0.5, 0.1};  // height, radius
  table.shape_poses.resize(1);
  table.shape_poses[0].orientation.w = 1.0;
  table.shape_frames = {"table"};
  message.entries[1] = table;
  message.entries[1].name = "cone";
  message.entries[1].shapes[0].type = shape_msgs::SolidPrimitive::CONE;
  const auto read = yarm::readRegistry(message);
  EXPECT_NE(read.reason.find("cone: solid of type 4"), std::string::npos) << read.reason;
  ASSERT_EQ(read.value.count("table"), 1U);
  const pc::Solid& solid = read.value.at("table").solids.at(0);
  EXPECT_EQ(solid.shape, pc::Solid::Shape::kCylinder);
  EXPECT_FLOAT_EQ(solid.size.x(), 0.1F);
  EXPECT_FLOAT_EQ(solid.size.z(), 0.5F);
  EXPECT_TRUE(read.value.at("cone").solids.empty());
}

pc::Seed seedAt(const std::string& name, double x, double yaw, std::int64_t stamp_ns) {
  pc::Seed seed;
  seed.name = name;
  seed.T_world_seed.translation().x() = x;
  seed.T_world_seed.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  seed.stamp_ns = stamp_ns;
  return seed;
}

constexpr std::int64_t kMs = 1'000'000;

TEST(SeedBuffer, seedsAreInterpolatedToTheStamp) {
  yarm::SeedBuffer buffer;
  buffer.add(100 * kMs, {seedAt("a", 0.0, 0.0, 100 * kMs)}, 100 * kMs);
  buffer.add(120 * kMs, {seedAt("a", 1.0, 0.4, 120 * kMs)}, 120 * kMs);
  const auto found = buffer.lookup(105 * kMs);
  EXPECT_EQ(found.match, yarm::SeedMatch::exact);
  ASSERT_EQ(found.seeds.size(), 1U);
  EXPECT_NEAR(found.seeds[0].T_world_seed.translation().x(), 0.25, 1e-12);
  const Eigen::AngleAxisd turn(found.seeds[0].T_world_seed.linear());
  EXPECT_NEAR(turn.angle(), 0.1, 1e-9);
  EXPECT_EQ(found.seeds[0].stamp_ns, 105 * kMs);
}

TEST(SeedBuffer, beyondTheEndTheNewestSeedsSayHowOldTheyAre) {
  yarm::SeedBuffer buffer;
  EXPECT_EQ(buffer.lookup(1).match, yarm::SeedMatch::none);
  buffer.add(100 * kMs, {seedAt("a", 3.0, 0.0, 100 * kMs)}, 100 * kMs);
  EXPECT_FALSE(buffer.covers(130 * kMs));
  const auto found = buffer.lookup(130 * kMs);
  EXPECT_EQ(found.match, yarm::SeedMatch::newest);
  EXPECT_EQ(found.lag_ns, 30 * kMs);
  EXPECT_EQ(found.seeds[0].T_world_seed.translation().x(), 3.0);
}

TEST(SeedBuffer, objectsExistAsTheMessageAfterTheStampSays) {
  yarm::SeedBuffer buffer;
  buffer.add(100 * kMs, {seedAt("gone", 0.0, 0.0, 100 * kMs), seedAt("stays", 0.0, 0.0, 100 * kMs)}, 100 * kMs);
  buffer.add(120 * kMs, {seedAt("stays", 1.0, 0.0, 120 * kMs), seedAt("new", 5.0, 0.0, 120 * kMs)}, 120 * kMs);
  const auto found = buffer.lookup(110 * kMs);
  ASSERT_EQ(found.seeds.size(), 2U);
  EXPECT_EQ(found.seeds[0].name, "stays");
  EXPECT_EQ(found.seeds[1].name, "new");
  EXPECT_EQ(found.seeds[1].T_world_seed.translation().x(), 5.0);
}

TEST(SeedBuffer, aStaleSeedIsNotCarriedForward) {
  yarm::SeedBuffer buffer;
  buffer.add(100 * kMs, {seedAt("a", 7.0, 0.0, 40 * kMs)}, 100 * kMs);
  buffer.add(120 * kMs, {seedAt("a", 7.0, 0.0, 40 * kMs)}, 120 * kMs);
  EXPECT_EQ(buffer.lookup(110 * kMs).seeds[0].stamp_ns, 40 * kMs);
}

TEST(SeedBuffer, aClockThatGoesBackEmptiesIt) {
  yarm::SeedBuffer buffer;
  buffer.add(9000 * kMs, {seedAt("a", 0.0, 0.0, 9000 * kMs)}, 9000 * kMs);
  buffer.noticeClock(10 * kMs);
  EXPECT_FALSE(buffer.covers(17 * kMs));
  EXPECT_EQ(buffer.add(16 * kMs, {seedAt("a", 1.0, 0.0, 16 * kMs)}, 16 * kMs), "");
  EXPECT_EQ(buffer.lookup(16 * kMs).seeds[0].T_world_seed.translation().x(), 1.0);
}

TEST(SeedBuffer, seedsThatComeBeforeTheirClockAreTheFirstOfTheNewTime) {
  yarm::SeedBuffer buffer;
  buffer.add(9000 * kMs, {seedAt("a", 0.0, 0.0, 9000 * kMs)}, 9000 * kMs);
  EXPECT_NE(buffer.add(16 * kMs, {seedAt("a", 1.0, 0.0, 16 * kMs)}, 9000 * kMs), "");
  buffer.noticeClock(16 * kMs);
  EXPECT_EQ(buffer.lookup(16 * kMs).seeds.at(0).T_world_seed.translation().x(), 1.0);
}

TEST(SeedBuffer, stampsFarFromTheClockAreRefusedAndChangeNothing) {
  yarm::SeedBuffer buffer;
  for (std::int64_t now_ms = 10000; now_ms < 10200; now_ms += 16) {
    EXPECT_EQ(buffer.add(now_ms * kMs, {seedAt("a", 1.0, 0.0, now_ms * kMs)}, now_ms * kMs), "");
    for (const std::int64_t bad_ms : {std::int64_t{0}, now_ms - 6000, now_ms - 150, now_ms + 600, now_ms + 1000000}) {
      EXPECT_NE(buffer.add(bad_ms * kMs, {seedAt("a", 9.0, 0.0, bad_ms * kMs)}, now_ms * kMs), "") << bad_ms;
    }
    const auto found = buffer.lookup((now_ms - 8) * kMs);
    EXPECT_EQ(found.match, yarm::SeedMatch::exact);
    EXPECT_EQ(found.seeds.at(0).T_world_seed.translation().x(), 1.0);
    EXPECT_FALSE(buffer.covers((now_ms + 1) * kMs));
  }
  const std::string fault = buffer.add(0, {}, 12000 * kMs);
  EXPECT_NE(fault.find("its stamp 0.000 s is 12.000 s behind the clock, at most 5.0 s"), std::string::npos) << fault;
}

TEST(SeedBuffer, aWrongStampFromBeforeTheTimeWasKnownIsForgotten) {
  yarm::SeedBuffer buffer;
  EXPECT_EQ(buffer.add(1000000 * kMs, {seedAt("a", 9.0, 0.0, 1000000 * kMs)}, 0), "");
  EXPECT_EQ(buffer.add(1000 * kMs, {seedAt("a", 1.0, 0.0, 1000 * kMs)}, 1000 * kMs), "");
  EXPECT_EQ(buffer.lookup(1000 * kMs).seeds.at(0).T_world_seed.translation().x(), 1.0);
}

TEST(Seeds, aTransformThatMakesNoSenseIsLeftOutAndNamed) {
  yarm::TransformStampedVector message;
  message.transforms.resize(3);
  message.frame = {"right", "turned_by_nothing", "nowhere"};
  message.type = {"static", "dynamic", "dynamic"};
  message.object = {"Obstacle", "Mobile", "Mobile"};
  message.transforms[0].transform.rotation.w = 1.0;
  message.transforms[2].transform.rotation.w = 1.0;
  message.transforms[2].transform.translation.y = std::numeric_limits<double>::quiet_NaN();
  const auto read = yarm::readSeeds(message);
  ASSERT_EQ(read.value.size(), 1U);
  EXPECT_EQ(read.value[0].name, "right");
  for (const char* name : {"turned_by_nothing", "nowhere"}) {
    EXPECT_NE(read.reason.find(name), std::string::npos) << read.reason;
  }
}

TEST(Params, faultsAreListedAllAtOnce) {
  XmlRpc::XmlRpcValue values;
  values["voxel_size_x"] = 7.0;
  values["backend"] = std::string("magic");
  values["sync"] = 1;
  values["voxel_size"] = 0.1;
  try {
    yarm::readParams<yarm::MergeCloudsParams>(values, "/merge_clouds");
    FAIL() << "nothing was refused";
  } catch (const yarm::ParamError& error) {
    const std::string text = error.what();
    for (const char* part : {"/merge_clouds: ", "voxel_size_x = 7", "0.001 to 1 m", "one of 'fused', 'pcl'",
                             "sync = 1: must be true or false", "voxel_size: unknown parameter"}) {
      EXPECT_NE(text.find(part), std::string::npos) << text;
    }
  }
}

TEST(Params, valuesReachTheLibrarysStructs) {
  XmlRpc::XmlRpcValue values;
  values["voxel_size_z"] = 0.001;
  values["floor_sigmas"] = 0;
  values["noise_base"] = 0.005;
  const auto params = yarm::readParams<yarm::MergeCloudsParams>(values, "x").mergeParams();
  EXPECT_EQ(params.voxel_size[2], 0.001);
  EXPECT_EQ(params.floor_sigmas, 0.0);
  EXPECT_FLOAT_EQ(params.noise.base, 0.005F);
}

TEST(SideObject, travelsWithItsMessageAndOnlyWithIt) {
  const auto side = boost::make_shared<int>(42);
  const boost::shared_ptr<const PointCloud2> message = yarm::withSide(std::make_unique<PointCloud2>(), side);
  ASSERT_TRUE(yarm::sideOf<int>(message));
  EXPECT_EQ(*yarm::sideOf<int>(message), 42);
  const boost::shared_ptr<const PointCloud2> plain = boost::make_shared<PointCloud2>();
  EXPECT_FALSE(yarm::sideOf<int>(plain));
}

TEST(Pool, anObjectComesBackWithItsBuffers) {
  const yarm::Pool<std::vector<int>> pool(1);
  const int* buffer = nullptr;
  {
    const auto object = pool.acquire();
    object->resize(1000);
    buffer = object->data();
  }
  const auto again = pool.acquire();
  EXPECT_EQ(again->data(), buffer);
  EXPECT_NE(pool.acquire()->data(), buffer);
}

}  // namespace
