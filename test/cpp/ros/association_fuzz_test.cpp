// Messages with absurd numbers (infinite, NaN, 1e300, zero, negative, quaternions of length 0) through the readers, the
// association, the grid and predict_new_state, under the sanitizers: refused with a reason or survived. The same
// numbers also straight into the library, past the readers. association_fuzz_test [sets [seed]]
#include "absurd.hpp"
#include "yarm/perception/association.hpp"
#include "yarm/perception/occupancy.hpp"
#include "yarm/perception/solids.hpp"
#include "yarm/ros/conversions.hpp"
#include "yarm/ros/prediction.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <limits>

namespace {

using yarm::test::Absurd;
namespace pc = yarm::perception;

std::uint64_t sets_to_try = 500;
std::uint64_t first_seed = 1;

geometry_msgs::Pose pose(Absurd& absurd) {
  geometry_msgs::Pose made;
  made.position.x = absurd.number(-2.0, 2.0);
  made.position.y = absurd.number(-2.0, 2.0);
  made.position.z = absurd.number(0.0, 1.0);
  made.orientation.x = absurd.number(-1.0, 1.0);
  made.orientation.y = absurd.number(-1.0, 1.0);
  made.orientation.z = absurd.number(-1.0, 1.0);
  made.orientation.w = absurd.number(0.1, 1.0);
  if (absurd.chance(0.01)) {
    made.orientation = geometry_msgs::Quaternion();
  }
  return made;
}

const char* const kKinds[] = {"Mobile", "Manipulator", "Debris", "Target", "Obstacle", "Spoon"};

yarm::ObjectRegistry registry(Absurd& absurd) {
  yarm::ObjectRegistry message;
  for (int i = 0; i < 5; ++i) {
    yarm::RegisteredObject entry;
    entry.name = "thing_" + std::to_string(i);
    entry.seed_frame = entry.name;
    for (int link = 0; link < 1 + i % 3; ++link) {
      entry.link_frames.push_back(entry.name + "/" + std::to_string(link));
    }
    for (int s = 0; s < absurd.below(4); ++s) {
      shape_msgs::SolidPrimitive primitive;
      primitive.type = static_cast<std::uint8_t>(1 + absurd.below(4));
      const int dimensions = primitive.type == 1 ? 3 : primitive.type == 2 ? 1 : 2;
      for (int d = 0; d < dimensions; ++d) {
        primitive.dimensions.push_back(absurd.number(0.02, 1.0));
      }
      entry.shapes.push_back(primitive);
      entry.shape_poses.push_back(pose(absurd));
      entry.shape_frames.push_back(entry.link_frames[static_cast<std::size_t>(s) % entry.link_frames.size()]);
    }
    message.entries.push_back(entry);
  }
  return message;
}

yarm::TransformStampedVector seeds(Absurd& absurd) {
  yarm::TransformStampedVector message;
  for (int i = 0; i < 5; ++i) {
    const geometry_msgs::Pose at = pose(absurd);
    geometry_msgs::TransformStamped transform;
    transform.transform.translation.x = at.position.x;
    transform.transform.translation.y = at.position.y;
    transform.transform.translation.z = at.position.z;
    transform.transform.rotation = at.orientation;
    message.transforms.push_back(transform);
    message.type.push_back(absurd.chance(0.5) ? "static" : "dynamic");
    message.frame.push_back("thing_" + std::to_string(i));
    message.object.push_back(kKinds[absurd.below(absurd.chance(0.05) ? 6 : 5)]);
  }
  return message;
}

/// Points in the box, each a voxel of its own, all in one cluster.
pc::MergedSet merged(Absurd& absurd) {
  pc::MergedSet set;
  set.clusters.resize(1);
  for (int i = 0; i < 40; ++i) {
    pc::MergedPoint p;
    p.x = static_cast<float>(absurd.number(-2.4, 2.4));
    p.y = static_cast<float>(absurd.number(-2.4, 2.4));
    p.z = static_cast<float>(absurd.number(0.05, 1.2));
    p.sigma = 0.01F;
    p.uz = -1.F;
    p.camera = i % 4;
    set.points.push_back(p);
    set.voxel_of_point.push_back(i);
    set.centroids.emplace_back(p.x, p.y, p.z);
    set.voxel_points.push_back(1);
    set.cluster_of_voxel.push_back(0);
    set.clusters[0].push_back(i);
  }
  for (int camera = 0; camera < 4; ++camera) {
    if (absurd.chance(0.1)) {
      set.absent.push_back(camera);
    }
  }
  return set;
}

/// Where the links of known objects are, as far as a reader takes the poses.
pc::LinkPoses linkPoses(Absurd& absurd, const pc::Knowledge& known) {
  pc::LinkPoses links;
  for (const auto& [name, object] : known) {
    for (const std::string& frame : object.link_frames) {
      const auto read = yarm::readPose(pose(absurd));
      if (read.ok()) {
        links[frame] = read.value;
      }
    }
  }
  return links;
}

struct Chain {
  std::unique_ptr<pc::Associator> associator = pc::makeAssociator("yarm", {});
  std::unique_ptr<pc::Associator> original = pc::makeAssociator("original", {});
  pc::OccupancyBuilder builder{pc::GridSpec{}};

  void run(const pc::MergedSet& set, const std::vector<pc::Seed>& seeds, const pc::Knowledge& knowledge,
           const pc::LinkPoses& links, bool calibrating) {
    for (const auto* one : {&associator, &original}) {
      const pc::AssociatedSet& result = (*one)->associate({&set, &seeds, &knowledge, &links, calibrating});
      const pc::OccupancyGrid& grid = builder.build(result);
      ASSERT_EQ(grid.object_cells.size(), result.objects.size());
      yarm::AssociatedClusterVector message;
      yarm::fillAssociated(result, grid.spec, message);
      pc::AssociatedSet back;
      pc::GridSpec spec;
      static_cast<void>(yarm::readAssociated(message, back, spec));
    }
  }
};

TEST(Association, survivesMessagesThatLie) {
  Absurd absurd(first_seed);
  Chain chain;
  std::uint64_t refused = 0;
  for (std::uint64_t i = 0; i < sets_to_try; ++i) {
    absurd.rate(0.005);
    const auto known = yarm::readRegistry(registry(absurd));
    const auto placed = yarm::readSeeds(seeds(absurd));
    refused += known.ok() && placed.ok() ? 0U : 1U;
    for (const auto& [name, object] : known.value) {
      for (const pc::Solid& solid : object.solids) {
        ASSERT_EQ(pc::solidFault(solid), "") << name;
      }
    }
    const pc::LinkPoses links = linkPoses(absurd, known.value);
    absurd.rate(0.0);
    chain.run(merged(absurd), placed.value, known.value, links, i % 20 < 5);
  }
  std::printf("%llu sets, something refused in %llu\n", static_cast<unsigned long long>(sets_to_try),
              static_cast<unsigned long long>(refused));
  EXPECT_GT(refused, sets_to_try / 10);
  EXPECT_LT(refused, sets_to_try);
}

// What a client of predict_new_state may ask: names that are no object, twice the same, poses that are none.
TEST(Prediction, survivesQuestionsThatLie) {
  Absurd absurd(first_seed + 2);
  Chain chain;
  std::uint64_t refused = 0;
  std::uint64_t conflicts = 0;
  for (std::uint64_t i = 0; i < sets_to_try; ++i) {
    absurd.rate(0.0);
    const auto known = yarm::readRegistry(registry(absurd));
    const auto placed = yarm::readSeeds(seeds(absurd));
    const pc::MergedSet set = merged(absurd);
    const pc::LinkPoses links = linkPoses(absurd, known.value);
    const pc::AssociatedSet& present =
        chain.associator->associate({&set, &placed.value, &known.value, &links, i % 20 < 5});
    absurd.rate(0.02);
    yarm::PredictNewState::Request request;
    yarm::PredictNewState::Response response;
    for (int move = 0; move < absurd.below(4); ++move) {
      request.names.push_back("thing_" + std::to_string(absurd.below(absurd.chance(0.1) ? 9 : 5)));
      request.poses.push_back(pose(absurd));
    }
    if (absurd.chance(0.05)) {
      request.poses.emplace_back();
    }
    yarm::answerPrediction(request, present, pc::GridSpec{}, absurd.number(0.001, 0.2), response);
    const bool was_refused = response.message.rfind("refused: ", 0) == 0;
    refused += was_refused ? 1U : 0U;
    conflicts += response.cells.empty() ? 0U : 1U;
    ASSERT_TRUE(response.collision || !was_refused) << response.message;
    ASSERT_FALSE(response.message.empty());
  }
  std::printf("%llu questions, %llu refused, %llu with cells in conflict\n",
              static_cast<unsigned long long>(sets_to_try), static_cast<unsigned long long>(refused),
              static_cast<unsigned long long>(conflicts));
  EXPECT_GT(conflicts, 0U);
  EXPECT_GT(refused, sets_to_try / 10);
  EXPECT_LT(refused, sets_to_try);
}

Eigen::Isometry3d rawPose(Absurd& absurd) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(absurd.number(-2.0, 2.0), absurd.number(-2.0, 2.0), absurd.number(0.0, 1.0));
  T.linear()(0, 0) = absurd.number(0.9, 1.0);
  return T;
}

// Past the readers: whatever reaches the library, no number is cast that does not fit.
TEST(Association, survivesAnythingInTheLibrary) {
  Absurd absurd(first_seed + 1);
  Chain chain;
  absurd.rate(0.05);
  for (std::uint64_t i = 0; i < sets_to_try / 4; ++i) {
    std::vector<pc::Seed> seeds;
    pc::Knowledge knowledge;
    pc::LinkPoses links;
    for (int s = 0; s < 5; ++s) {
      pc::Seed seed;
      seed.name = "thing_" + std::to_string(s);
      seed.object = static_cast<pc::ObjectKind>(absurd.below(5));
      seed.is_static = absurd.chance(0.5);
      seed.T_world_seed = rawPose(absurd);
      seeds.push_back(seed);
      pc::KnownObject& object = knowledge[seed.name];
      object.seed_frame = seed.name;
      object.link_frames = {seed.name + "/a", seed.name + "/b"};
      links[object.link_frames[0]] = rawPose(absurd);
      links[object.link_frames[1]] = rawPose(absurd);
      for (int k = 0; k < absurd.below(3); ++k) {
        pc::Solid solid;
        solid.shape = static_cast<pc::Solid::Shape>(absurd.below(4));
        solid.size = Eigen::Vector3d(absurd.number(0.02, 1.0), absurd.number(0.02, 1.0), absurd.number(0.02, 1.0));
        solid.T_frame_solid = rawPose(absurd);
        solid.frame = object.link_frames[0];
        object.solids.push_back(solid);
      }
    }
    chain.run(merged(absurd), seeds, knowledge, links, i % 20 < 5);
  }
}

TEST(Readers, nameWhatTheyRefuse) {
  yarm::ObjectRegistry message;
  message.entries.resize(1);
  yarm::RegisteredObject& entry = message.entries[0];
  entry.name = "table";
  entry.shapes.resize(1);
  entry.shapes[0].type = shape_msgs::SolidPrimitive::BOX;
  entry.shape_poses.resize(1);
  entry.shape_poses[0].orientation.w = 1.0;
  entry.shape_frames = {"table"};
  for (const double bad : {0.0, -1.0, 1e300, std::numeric_limits<double>::infinity()}) {
    entry.shapes[0].dimensions = {1.0, bad, 1.0};
    const std::string reason = yarm::readRegistry(message).reason;
    EXPECT_NE(reason.find("table: edge " + std::to_string(bad) + " m, must be above 0 and at most 20"),
              std::string::npos)
        << reason;
  }
  entry.shapes[0].dimensions = {1.0, 1.0, 1.0};
  entry.shape_poses[0].position.y = -1e300;
  EXPECT_NE(yarm::readRegistry(message).reason.find("m off on an axis, at most 10000"), std::string::npos);
  entry.shape_poses[0].position.y = 0.0;
  EXPECT_EQ(yarm::readRegistry(message).reason, "");
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    sets_to_try = std::strtoull(argv[1], nullptr, 10);
  }
  if (argc > 2) {
    first_seed = std::strtoull(argv[2], nullptr, 10);
  }
  std::printf("seed %llu\n", static_cast<unsigned long long>(first_seed));
  return RUN_ALL_TESTS();
}
