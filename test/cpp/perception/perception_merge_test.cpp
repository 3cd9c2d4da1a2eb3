// Crop, voxels and clusters: PCL's own filters are the oracle, and both back ends must agree with it.
#include "scene_factory.hpp"

#include "yarm/perception/merge.hpp"

#include <gtest/gtest.h>
#include <pcl/common/transforms.h>
#include <pcl/filters/crop_box.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>

namespace yarm::test {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

/// A random cloud around the box, some of it NaN, with its camera.
struct RandomCamera {
  std::vector<float> data;
  pc::CameraCloud cloud;
};

RandomCamera randomCamera(std::mt19937_64& random, std::size_t count, std::size_t floats_a_point = 4,
                          std::size_t x_at = 0) {
  std::uniform_real_distribution<float> spread(-4.F, 4.F);
  std::uniform_real_distribution<float> forward(0.5F, 6.F);
  std::uniform_real_distribution<float> chance(0.F, 1.F);
  RandomCamera camera;
  camera.data.assign(count * floats_a_point, 1e30F);
  for (std::size_t i = 0; i < count; ++i) {
    const bool seen = chance(random) > 0.1F;
    float* p = &camera.data[i * floats_a_point + x_at];
    p[0] = seen ? spread(random) : std::numeric_limits<float>::quiet_NaN();
    p[1] = seen ? spread(random) : std::numeric_limits<float>::quiet_NaN();
    p[2] = seen ? forward(random) : std::numeric_limits<float>::quiet_NaN();
  }
  camera.cloud.width = count;
  camera.cloud.height = 1;
  camera.cloud.point_step = 4 * floats_a_point;
  camera.cloud.x_offset = 4 * x_at;
  camera.cloud.y_offset = 4 * x_at + 4;
  camera.cloud.z_offset = 4 * x_at + 8;
  const float angle = 6.28F * chance(random);
  camera.cloud.T_world_camera = lookAt({3.F * std::cos(angle), 3.F * std::sin(angle), 2.F}, {0.F, 0.F, 0.3F});
  camera.cloud.data = reinterpret_cast<const std::uint8_t*>(camera.data.data());
  return camera;
}

/// Transform and crop by PCL alone.
Cloud::Ptr oracleCrop(const std::vector<pc::CameraCloud>& clouds, const pc::MergeParams& params) {
  Cloud::Ptr merged(new Cloud);
  for (const pc::CameraCloud& c : clouds) {
    Cloud::Ptr raw(new Cloud);
    for (std::size_t i = 0; i < c.width * c.height; ++i) {
      const auto* p = reinterpret_cast<const float*>(c.data + i * c.point_step + c.x_offset);
      raw->emplace_back(p[0], p[1], p[2]);
    }
    raw->is_dense = false;
    Cloud::Ptr world(new Cloud);
    pcl::transformPointCloud(*raw, *world, c.T_world_camera.matrix());
    pcl::CropBox<pcl::PointXYZ> crop;
    crop.setInputCloud(world);
    crop.setMin({static_cast<float>(params.box_min[0]), static_cast<float>(params.box_min[1]),
                 static_cast<float>(params.box_min[2]), 1});
    crop.setMax({static_cast<float>(params.box_max[0]), static_cast<float>(params.box_max[1]),
                 static_cast<float>(params.box_max[2]), 1});
    Cloud kept;
    crop.filter(kept);
    *merged += kept;
  }
  return merged;
}

Cloud oracleVoxels(const Cloud::Ptr& cloud, const pc::MergeParams& params) {
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(cloud);
  grid.setLeafSize(static_cast<float>(params.voxel_size[0]), static_cast<float>(params.voxel_size[1]),
                   static_cast<float>(params.voxel_size[2]));
  Cloud voxels;
  grid.filter(voxels);
  return voxels;
}

std::set<std::set<int>> oracleClusters(const Cloud& voxels, const pc::ClusterParams& params) {
  const Cloud::Ptr cloud(new Cloud(voxels));
  const pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>);
  tree->setInputCloud(cloud);
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
  extraction.setClusterTolerance(params.tolerance);
  extraction.setMinClusterSize(params.min_size);
  extraction.setMaxClusterSize(params.max_size);
  extraction.setSearchMethod(tree);
  extraction.setInputCloud(cloud);
  std::vector<pcl::PointIndices> found;
  extraction.extract(found);
  std::set<std::set<int>> result;
  for (const auto& f : found) {
    result.emplace(f.indices.begin(), f.indices.end());
  }
  return result;
}

std::set<std::set<int>> partitionOf(const pc::MergedSet& set) {
  std::set<std::set<int>> result;
  for (const auto& c : set.clusters) {
    result.emplace(c.begin(), c.end());
  }
  return result;
}

void expectCentroids(const pc::MergedSet& set, const Cloud& voxels) {
  ASSERT_EQ(set.centroids.size(), voxels.size());
  for (std::size_t v = 0; v < voxels.size(); ++v) {
    EXPECT_LT((set.centroids[v] - voxels[v].getVector3fMap()).norm(), 1e-4F) << "voxel " << v;
  }
}

void expectCrop(const pc::MergedSet& set, const Cloud& crop) {
  ASSERT_EQ(set.points.size(), crop.size());
  for (std::size_t i = 0; i < crop.size(); ++i) {
    const Eigen::Vector3f p(set.points[i].x, set.points[i].y, set.points[i].z);
    EXPECT_EQ(p, Eigen::Vector3f(crop[i].getVector3fMap())) << "point " << i;
  }
}

void expectConsistent(const pc::MergedSet& set) {
  ASSERT_EQ(set.voxel_of_point.size(), set.points.size());
  std::vector<std::int32_t> counts(set.centroids.size(), 0);
  for (const std::int32_t v : set.voxel_of_point) {
    ++counts.at(static_cast<std::size_t>(v));
  }
  EXPECT_EQ(counts, set.voxel_points);
  std::size_t clustered = 0;
  for (std::size_t c = 0; c < set.clusters.size(); ++c) {
    clustered += set.clusters[c].size();
    for (const std::int32_t v : set.clusters[c]) {
      EXPECT_EQ(set.cluster_of_voxel.at(static_cast<std::size_t>(v)), static_cast<std::int32_t>(c));
    }
  }
  EXPECT_EQ(clustered, set.centroids.size() - static_cast<std::size_t>(std::count(set.cluster_of_voxel.begin(),
                                                                                  set.cluster_of_voxel.end(), -1)));
}

class BothBackends : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Perception, BothBackends, testing::Values("fused", "pcl"));

TEST_P(BothBackends, AgreeWithPclOnRandomClouds) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    pc::MergeParams params;
    params.floor_sigmas = 0.0;
    params.voxel_size[2] = seed % 3 == 0 ? 0.001 : 0.1;
    pc::ClusterParams cluster;
    cluster.tolerance = seed % 2 == 0 ? 0.2 : 0.13;
    const auto backend = pc::makeBackend(GetParam(), params, cluster);
    pc::MergedSet set;
    for (int repeat = 0; repeat < 2; ++repeat) {  // the second time on used buffers
      std::vector<RandomCamera> cameras;
      std::vector<pc::CameraCloud> clouds;
      for (int c = 0; c < 1 + static_cast<int>(seed % 4); ++c) {
        cameras.push_back(randomCamera(random, 2000 + seed * 37, seed % 2 == 0 ? 4 : 8, seed % 4 == 3 ? 2 : 0));
        clouds.push_back(cameras.back().cloud);
      }
      for (std::size_t c = 0; c < cameras.size(); ++c) {
        clouds[c].data = reinterpret_cast<const std::uint8_t*>(cameras[c].data.data());
      }
      backend->merge(clouds, set);
      backend->cluster(set);
      const Cloud::Ptr crop = oracleCrop(clouds, params);
      ASSERT_GT(crop->size(), 100U);
      expectCrop(set, *crop);
      const Cloud voxels = oracleVoxels(crop, params);
      expectCentroids(set, voxels);
      EXPECT_EQ(partitionOf(set), oracleClusters(voxels, cluster));
      expectConsistent(set);
    }
  }
}

TEST_P(BothBackends, AgreeWithPclOnTheCell) {
  const Scene scene = standardCell(3, 3);
  SceneFactory factory(5);
  factory.render(scene);
  const auto clouds = factory.clouds(7);
  for (const double voxel_z : {0.1, 0.001}) {
    pc::MergeParams params;
    params.voxel_size[2] = voxel_z;
    params.floor_sigmas = 0.0;
    const auto backend = pc::makeBackend(GetParam(), params, {});
    pc::MergedSet set;
    backend->merge(clouds, set);
    backend->cluster(set);
    const Cloud::Ptr crop = oracleCrop(clouds, params);
    expectCrop(set, *crop);
    const Cloud voxels = oracleVoxels(crop, params);
    expectCentroids(set, voxels);
    EXPECT_EQ(partitionOf(set), oracleClusters(voxels, {}));
    EXPECT_EQ(set.stamp_ns, 7);
  }
}

TEST_P(BothBackends, VoxeliseAgainGivesTheSame) {
  SceneFactory factory(6);
  factory.render(standardCell(2, 1));
  const auto backend = pc::makeBackend(GetParam(), {}, {});
  pc::MergedSet set;
  backend->merge(factory.clouds(1), set);
  backend->cluster(set);
  pc::MergedSet again;
  again.points = set.points;
  backend->voxelise(again);
  backend->cluster(again);
  EXPECT_EQ(again.centroids, set.centroids);
  EXPECT_EQ(again.voxel_of_point, set.voxel_of_point);
  EXPECT_EQ(again.clusters, set.clusters);
}

TEST_P(BothBackends, EmptyAndAllNanCloudsCountAsReceived) {
  std::vector<float> nans(4 * 320, std::numeric_limits<float>::quiet_NaN());
  pc::CameraCloud nan_cloud;
  nan_cloud.data = reinterpret_cast<const std::uint8_t*>(nans.data());
  nan_cloud.width = 320;
  nan_cloud.height = 1;
  nan_cloud.stamp_ns = 20;
  pc::CameraCloud empty;
  empty.stamp_ns = 10;
  const auto backend = pc::makeBackend(GetParam(), {}, {});
  pc::MergedSet set;
  backend->merge({nan_cloud, empty}, set);
  backend->cluster(set);
  EXPECT_EQ(set.stamp_ns, 10);
  EXPECT_TRUE(set.points.empty());
  EXPECT_TRUE(set.centroids.empty());
  EXPECT_TRUE(set.clusters.empty());
  ASSERT_EQ(set.cameras.size(), 2U);
  EXPECT_EQ(set.cameras[0].points, 320U);
  EXPECT_EQ(set.cameras[0].finite, 0U);
  EXPECT_FALSE(set.cameras[0].dropped);
  EXPECT_FALSE(set.cameras[1].dropped);
}

TEST_P(BothBackends, AnAbsurdPointIsLeftOutAndCountedTheOthersStay) {
  std::mt19937_64 random(3);
  for (const float value : {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(), 1e9F}) {
    for (const std::size_t at : {std::size_t{0}, std::size_t{501}, std::size_t{999}}) {
      RandomCamera camera = randomCamera(random, 1000);
      camera.cloud.data = reinterpret_cast<const std::uint8_t*>(camera.data.data());
      const auto backend = pc::makeBackend(GetParam(), {}, {});
      pc::MergedSet whole;
      backend->merge({camera.cloud}, whole);
      for (int axis = 0; axis < 3; ++axis) {
        camera.data[4 * at + static_cast<std::size_t>(axis)] = std::numeric_limits<float>::quiet_NaN();
      }
      pc::MergedSet without;
      backend->merge({camera.cloud}, without);
      camera.data[4 * at + at % 3] = value;
      pc::MergedSet set;
      backend->merge({camera.cloud}, set);
      EXPECT_EQ(set.cameras[0].absurd, 1U);
      EXPECT_EQ(whole.cameras[0].absurd, 0U);
      EXPECT_FALSE(set.cameras[0].dropped);
      EXPECT_EQ(set.cameras[0].finite, without.cameras[0].finite);
      EXPECT_EQ(set.centroids, without.centroids);
      EXPECT_GT(set.points.size(), 0U);
    }
  }
}

TEST_P(BothBackends, ACloudFullOfAbsurdPointsIsDroppedTheOthersStay) {
  std::mt19937_64 random(3);
  RandomCamera good = randomCamera(random, 1000);
  RandomCamera bad = randomCamera(random, 1000);
  for (std::size_t at = 0; at < 11; ++at) {  // one more than the share that is let pass
    bad.data[4 * (90 * at) + 1] = std::numeric_limits<float>::infinity();
  }
  bad.cloud.data = reinterpret_cast<const std::uint8_t*>(bad.data.data());
  good.cloud.data = reinterpret_cast<const std::uint8_t*>(good.data.data());
  const auto backend = pc::makeBackend(GetParam(), {}, {});
  pc::MergedSet set;
  backend->merge({bad.cloud, good.cloud}, set);
  EXPECT_TRUE(set.cameras[0].dropped);
  EXPECT_EQ(set.cameras[0].absurd, 11U);
  EXPECT_EQ(set.cameras[0].finite, 0U);
  EXPECT_EQ(set.cameras[0].kept, 0U);
  EXPECT_FALSE(set.cameras[1].dropped);
  EXPECT_EQ(set.points.size(), set.cameras[1].kept);
  EXPECT_GT(set.points.size(), 0U);
}

TEST_P(BothBackends, RowsWithPaddingAreRead) {
  std::mt19937_64 random(4);
  const RandomCamera flat = randomCamera(random, 64);
  std::vector<float> padded;
  for (int row = 0; row < 8; ++row) {
    padded.insert(padded.end(), flat.data.begin() + row * 32, flat.data.begin() + (row + 1) * 32);
    padded.insert(padded.end(), 5, 1e30F);
  }
  pc::CameraCloud rows = flat.cloud;
  rows.width = 8;
  rows.height = 8;
  rows.row_step = (32 + 5) * 4;
  rows.data = reinterpret_cast<const std::uint8_t*>(padded.data());
  pc::CameraCloud one = flat.cloud;
  one.data = reinterpret_cast<const std::uint8_t*>(flat.data.data());
  const auto backend = pc::makeBackend(GetParam(), {}, {});
  pc::MergedSet a;
  pc::MergedSet b;
  backend->merge({one}, a);
  backend->merge({rows}, b);
  ASSERT_GT(a.points.size(), 0U);
  EXPECT_EQ(a.centroids, b.centroids);
}

TEST(Backends, FusedAndPclGiveTheSamePointsToTheBit) {
  for (const double floor : {0.0, 4.5}) {
    SceneFactory factory(8);
    factory.render(standardCell(3, 2));
    pc::MergeParams params;
    params.floor_sigmas = floor;
    pc::MergedSet fused;
    pc::MergedSet pcl_set;
    pc::makeBackend("fused", params, {})->merge(factory.clouds(1), fused);
    pc::makeBackend("pcl", params, {})->merge(factory.clouds(1), pcl_set);
    ASSERT_EQ(fused.points.size(), pcl_set.points.size());
    EXPECT_EQ(std::memcmp(fused.points.data(), pcl_set.points.data(), fused.points.size() * sizeof(pc::MergedPoint)),
              0);
    EXPECT_EQ(fused.voxel_of_point, pcl_set.voxel_of_point);
  }
}

TEST(Backends, TheVectorPathEqualsThePortableOne) {
  SceneFactory factory(9);
  factory.render(standardCell(2, 2));
  auto clouds = factory.clouds(1);
  std::vector<std::vector<float>> tight;  // 12 bytes a point: too short for the vector path
  for (const pc::CameraCloud& c : clouds) {
    const auto* data = reinterpret_cast<const float*>(c.data);
    std::vector<float> out;
    for (std::size_t i = 0; i < c.width * c.height; ++i) {
      out.insert(out.end(), data + 4 * i, data + 4 * i + 3);
    }
    tight.push_back(std::move(out));
  }
  const auto backend = pc::makeBackend("fused", {}, {});
  pc::MergedSet vector_path;
  backend->merge(clouds, vector_path);
  for (std::size_t c = 0; c < clouds.size(); ++c) {
    clouds[c].data = reinterpret_cast<const std::uint8_t*>(tight[c].data());
    clouds[c].point_step = 12;
  }
  pc::MergedSet portable;
  backend->merge(clouds, portable);
  ASSERT_GT(portable.points.size(), 1000U);
  ASSERT_EQ(vector_path.points.size(), portable.points.size());
  EXPECT_EQ(
      std::memcmp(vector_path.points.data(), portable.points.data(), portable.points.size() * sizeof(pc::MergedPoint)),
      0);
}

TEST(FloorMargin, DropsTheNoisyFloorAndKeepsLowDebris) {
  Scene scene = standardCell(0, 0);
  addDebris(scene, "debris_1", 1.2, 0.8, 0.5, 0.0);  // on the floor
  SceneFactory factory(11);
  int floor_points = 0;
  int floor_points_plain = 0;
  int debris_sets = 0;
  pc::MergeParams plain;
  plain.floor_sigmas = 0.0;
  const auto with = pc::makeBackend("fused", {}, {});
  const auto without = pc::makeBackend("fused", plain, {});
  constexpr int kSets = 20;
  for (int i = 0; i < kSets; ++i) {
    factory.render(scene);
    pc::MergedSet set;
    with->merge(factory.clouds(i), set);
    const auto truth = factory.truthOf(set);
    floor_points += static_cast<int>(std::count(truth.begin(), truth.end(), kFloor));
    debris_sets += std::count(truth.begin(), truth.end(), scene.indexOf("debris_1")) > 0 ? 1 : 0;
    without->merge(factory.clouds(i), set);
    const auto plain_truth = factory.truthOf(set);
    floor_points_plain += static_cast<int>(std::count(plain_truth.begin(), plain_truth.end(), kFloor));
  }
  EXPECT_LE(floor_points, 15 * kSets);
  EXPECT_GT(floor_points_plain, 1000 * kSets) << "the test must show what the margin is for";
  EXPECT_GE(debris_sets, kSets - 1);
}

TEST(MergeParams, EveryFaultIsNamedAtOnce) {
  pc::MergeParams params;
  params.voxel_size[1] = -1.0;
  params.floor_sigmas = -2.0;
  pc::ClusterParams cluster;
  cluster.min_size = 0;
  try {
    static_cast<void>(pc::makeBackend("fused", params, cluster));
    FAIL() << "bad parameters were taken";
  } catch (const std::invalid_argument& error) {
    const std::string text = error.what();
    for (const char* name : {"voxel_size = -1", "floor_sigmas = -2", "min_size = 0"}) {
      EXPECT_NE(text.find(name), std::string::npos) << name << " in: " << text;
    }
  }
  EXPECT_THROW(static_cast<void>(pc::makeBackend("other", {}, {})), std::invalid_argument);
  params = {};
  params.voxel_size = {0.001, 0.001, 0.001};
  EXPECT_THROW(static_cast<void>(pc::makeBackend("fused", params, {})), std::invalid_argument);
}

}  // namespace
}  // namespace yarm::test
