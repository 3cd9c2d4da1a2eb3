// What the cameras see of each cell, held against rays: no cell is called free of which a part is hidden.
#include "cell_views.hpp"
#include "scene_factory.hpp"

#include "yarm/perception/visibility.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace yarm::test {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// A set, what it was merged to, and the votes on it.
struct Voted {
  pc::MergedSet set;
  pc::CellVotes votes;
};

/// Cameras' clouds through merge and vote, one set after the other.
class Cell {
 public:
  explicit Cell(const pc::VisibilityParams& params = {})
      : backend_(pc::makeBackend("fused", merge, {})), voter(pc::GridSpec{}, merge, params, 4) {}

  Voted vote(const std::vector<pc::CameraCloud>& clouds, const std::vector<std::int32_t>& absent = {}) {
    Voted result;
    backend_->merge(clouds, result.set);
    result.set.absent = absent;
    voter.vote(clouds, result.set, result.votes);
    return result;
  }

  /// What each camera votes when it is asked alone: together, a later one is not asked about all.
  pc::CellVotes voteAlone(const std::vector<pc::CameraCloud>& clouds) {
    pc::CellVotes all;
    for (std::int32_t camera = 0; camera < 4; ++camera) {
      std::vector<std::int32_t> others{0, 1, 2, 3};
      others.erase(others.begin() + camera);
      const pc::CellVotes one = vote(clouds, others).votes;
      all.grid = one.grid;
      for (const auto of : {&pc::CellVotes::through, &pc::CellVotes::inside, &pc::CellVotes::behind}) {
        (all.*of).resize((one.*of).size(), 0);
        std::transform((one.*of).begin(), (one.*of).end(), (all.*of).begin(), (all.*of).begin(), std::bit_or<>());
      }
    }
    return all;
  }

  pc::MergeParams merge;

 private:
  std::unique_ptr<pc::MergeBackend> backend_;

 public:
  pc::VisibilityVoter voter;
};

/// Whether a pixel's reading says that its ray is clear up to a depth: by the definition, in double precision.
bool isClear(const pc::MergeParams& merge, const Eigen::Isometry3f& T_world_camera, const float* p, double depth) {
  if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]))) {
    return false;
  }
  const double height = (T_world_camera * Eigen::Vector3f(p[0], p[1], p[2])).z();
  const double sigma = merge.noise.sigma(p[2]);
  const double margin = merge.floor_sigmas * T_world_camera.translation().z() * sigma / p[2];
  return height < margin + 1e-5 || height <= 0.01 + 1e-5 || p[2] - 3.0 * sigma >= depth - 2e-3;
}

/// Sub-points of a cell that a camera does not see, of 5 x 5 x 5 with the corners; each asks the four pixels about it.
int hiddenPoints(const pc::MergeParams& merge, const Render& render, const pc::GridSpec& grid, int index, int* asked) {
  const double focal = 160.0 / std::tan(0.5 * CameraModel().fov_rad);
  const Eigen::Isometry3d T_camera_world = render.T_world_camera.cast<double>().inverse();
  const pc::Cell cell = grid.cellOf(index);
  int hidden = 0;
  for (int k = 0; k < 125; ++k) {
    const Eigen::Vector3d share(0.25 * (k % 5) - 0.5, 0.25 * (k / 5 % 5) - 0.5, 0.25 * (k / 25) - 0.5);
    const Eigen::Vector3d size(grid.resolution(0), grid.resolution(1), grid.resolution(2));
    const Eigen::Vector3d p = T_camera_world * (grid.centre(cell) + 0.998 * share.cwiseProduct(size));
    const double column = focal * p.x() / p.z() + 159.5;
    const double row = focal * p.y() / p.z() + 159.5;
    bool clear = p.z() > 0.0;
    for (const int pixel : {0, 1, 2, 3}) {
      const double u = std::floor(column) + pixel % 2;
      const double v = std::floor(row) + pixel / 2;
      clear = clear && u >= 0 && u < 320 && v >= 0 && v < 320 &&
              isClear(merge, render.T_world_camera, &render.data[4 * static_cast<std::size_t>(v * 320 + u)], p.z());
    }
    hidden += clear ? 0 : 1;
    ++*asked;
  }
  return hidden;
}

struct Score {
  int wrong{0};   ///< voted through, and a part is hidden
  int clear{0};   ///< seen through by the oracle
  int found{0};   ///< of these voted through
  int hidden{0};  ///< of which the oracle sees no part, or not all
};

Score against(const pc::MergeParams& merge, const std::vector<Render>& renders, const pc::CellVotes& votes, int step) {
  Score score;
  int asked = 0;
  for (std::size_t c = 0; c < renders.size(); ++c) {
    for (int cell = static_cast<int>(c); cell < static_cast<int>(votes.through.size()); cell += step) {
      const bool through = (votes.through[static_cast<std::size_t>(cell)] >> c & 1U) != 0;
      const bool clear = hiddenPoints(merge, renders[c], votes.grid, cell, &asked) == 0;
      score.wrong += through && !clear ? 1 : 0;
      score.clear += clear ? 1 : 0;
      score.found += through && clear ? 1 : 0;
      score.hidden += clear ? 0 : 1;
    }
  }
  EXPECT_GT(asked, 100000);
  return score;
}

TEST(Visibility, NoCellIsSeenThroughOfWhichARayOracleFindsAPartHidden) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SceneFactory factory(seed);
    const std::vector<Render>& renders = factory.render(standardCell(3, 3));
    Cell cell;
    const Score score = against(cell.merge, renders, cell.voteAlone(factory.clouds(1)), 61);
    EXPECT_EQ(score.wrong, 0) << "seed " << seed;
    EXPECT_GT(score.hidden, 500) << "seed " << seed;
    EXPECT_GT(score.found, 0.9 * score.clear) << "seed " << seed << ": " << score.found << " of " << score.clear;
  }
}

/// The clouds of a factory with readings that are missing or come too near, here and there.
std::vector<pc::CameraCloud> disturbed(const SceneFactory& factory, std::vector<Render>& renders, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> uniform(0.F, 1.F);
  std::vector<pc::CameraCloud> clouds = factory.clouds(1);
  for (std::size_t c = 0; c < renders.size(); ++c) {
    std::vector<float>& data = renders[c].data;
    for (std::size_t i = 0; i < data.size(); i += 4) {
      const float draw = uniform(random);
      const float scale = draw < 0.01F ? kNaN : (draw < 0.05F ? 0.2F + 0.7F * uniform(random) : 1.F);
      std::for_each(&data[i], &data[i] + 3, [scale](float& x) { x *= scale; });
    }
    clouds[c].data = reinterpret_cast<const std::uint8_t*>(data.data());
  }
  return clouds;
}

TEST(Visibility, NorInImagesOfRandomDepths) {
  for (const std::uint64_t seed : {11U, 12U}) {
    SceneFactory factory(seed);
    std::vector<Render> renders = factory.render(standardCell(0, 0));
    Cell cell;
    const Score score = against(cell.merge, renders, cell.voteAlone(disturbed(factory, renders, seed)), 61);
    EXPECT_EQ(score.wrong, 0) << "seed " << seed;
    EXPECT_GT(score.found, 0) << "seed " << seed;
    EXPECT_GT(score.hidden, 500) << "seed " << seed;
  }
}

TEST(Visibility, CamerasThatVoteTogetherComeToWhatTheyComeToAlone) {
  for (const std::uint64_t seed : {21U, 22U, 23U}) {
    SceneFactory factory(seed);
    std::vector<Render> renders = factory.render(standardCell(3, 3));
    const auto clouds = seed == 23U ? disturbed(factory, renders, seed) : factory.clouds(1);
    Cell cell;
    const pc::CellVotes alone = cell.voteAlone(clouds);
    const pc::CellVotes together = cell.vote(clouds).votes;
    EXPECT_EQ(together.inside, alone.inside) << "seed " << seed;
    std::size_t unseen = 0;
    std::size_t not_asked = 0;
    for (std::size_t i = 0; i < alone.through.size(); ++i) {
      ASSERT_EQ(together.through[i] & ~alone.through[i], 0) << "seed " << seed << ", cell " << i;
      ASSERT_EQ(together.behind[i] & ~alone.behind[i], 0) << "seed " << seed << ", cell " << i;
      if (alone.inside[i] == 0) {
        ASSERT_EQ(together.through[i] != 0, alone.through[i] != 0) << "seed " << seed << ", cell " << i;
      }
      if (alone.inside[i] == 0 && alone.through[i] == 0) {
        ASSERT_EQ(together.behind[i], alone.behind[i]) << "seed " << seed << ", cell " << i;
        ++unseen;
      }
      not_asked += together.through[i] != alone.through[i] ? 1U : 0U;
    }
    EXPECT_GT(unseen, 500U) << "seed " << seed;
    EXPECT_GT(not_asked, 5000U) << "seed " << seed;
  }
}

/// An image of clear depths in patches: readings, what is clear for good, and what is missing.
std::vector<float> patches(std::mt19937_64& random, std::size_t width, std::size_t height) {
  std::vector<float> clear(width * height + pc::kClearPadding, 0.F);
  const auto below = [&random](std::size_t limit) { return random() % limit; };
  for (int patch = 0; patch < 60; ++patch) {
    const std::size_t top = below(height);
    const std::size_t left = below(width);
    const std::size_t kind = below(5);
    const float depth = 1.F + static_cast<float>(below(300)) * 0.01F;
    const std::size_t bottom = std::min(height, top + 1 + below(30));
    for (std::size_t row = top; row < bottom; ++row) {
      for (std::size_t column = left; column < std::min(width, left + 20); ++column) {
        clear[row * width + column] = kind == 0 ? 0.F : (kind == 1 ? std::numeric_limits<float>::infinity() : depth);
      }
    }
  }
  return clear;
}

/// What eight boxes come to, by each of their pixels.
pc::EightFound lookAtPixels(const std::vector<float>& clear, std::size_t width,
                            const std::array<pc::DepthBox, 8>& boxes) {
  pc::EightFound found{0, 0, 0, 0};
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    for (std::size_t row = boxes[k].top; row <= boxes[k].bottom; ++row) {
      for (std::size_t column = boxes[k].left; column <= boxes[k].right; ++column) {
        const float depth = clear[row * width + column];
        found.before |= static_cast<unsigned>(depth > 0.F && depth < boxes[k].deepest) << k;
        found.missing |= static_cast<unsigned>(depth <= 0.F) << k;
        found.beyond |= static_cast<unsigned>(depth >= boxes[k].shallowest) << k;
        found.read |= static_cast<unsigned>(depth > 0.F) << k;
      }
    }
  }
  return found;
}

TEST(Visibility, WindowsSayWhatThePixelsOfABoxSay) {
  constexpr std::size_t kWidth = 90;
  constexpr std::size_t kHeight = 60;
  const pc::Rows rows{7, 55};
  std::mt19937_64 random(8);
  const auto between = [&random](std::size_t low, std::size_t high) { return low + random() % (high - low + 1); };
  for (int image = 0; image < 40; ++image) {
    const std::vector<float> clear = patches(random, kWidth, kHeight);
    std::array<pc::DepthWindows, 2> windows;
    windows[0].take(clear, kWidth, rows);
    windows[1].take(clear, kWidth, rows, true);
    for (int i = 0; i < 200; ++i) {
      std::array<pc::DepthBox, 8> boxes;
      const std::size_t most = between(1, 40);
      unsigned taken = 0;
      for (std::size_t k = 0; k < boxes.size(); ++k) {
        if (between(0, 9) > 0) {
          const std::size_t left = between(0, kWidth - 2);
          const std::size_t top = between(rows.first, rows.end - 2);
          const float depth = 1.005F + static_cast<float>(between(0, 300)) * 0.01F;
          boxes[k] = {static_cast<std::uint16_t>(left),
                      static_cast<std::uint16_t>(std::min(kWidth - 1, left + most)),
                      static_cast<std::uint16_t>(top),
                      static_cast<std::uint16_t>(std::min(rows.end - 1, top + most)),
                      depth + 0.5F,
                      depth};
          taken |= 1U << k;
        }
      }
      const pc::EightGroups eight(boxes);
      const pc::EightFound wanted = lookAtPixels(clear, kWidth, boxes);
      ASSERT_EQ(eight.taken, taken);
      for (const pc::DepthWindows& one : windows) {
        const pc::EightFound cells = one.lookAt(eight);
        const pc::EightFound groups = one.lookAtGroups(eight);
        ASSERT_EQ((cells.before ^ wanted.before) & taken, 0U) << "image " << image << ", boxes " << i;
        ASSERT_EQ((cells.missing ^ wanted.missing) & taken, 0U) << "image " << image << ", boxes " << i;
        ASSERT_EQ((groups.before ^ wanted.before) & taken, 0U) << "image " << image << ", boxes " << i;
        ASSERT_EQ((groups.missing ^ wanted.missing) & taken, 0U) << "image " << image << ", boxes " << i;
        ASSERT_EQ((groups.beyond ^ wanted.beyond) & taken, 0U) << "image " << image << ", boxes " << i;
        ASSERT_EQ((groups.read ^ wanted.read) & taken, 0U) << "image " << image << ", boxes " << i;
      }
    }
  }
}

TEST(Visibility, WindowsCoverABoxAsWideAsAGreatImage) {
  constexpr std::size_t kWidth = 4000;
  std::vector<float> clear(kWidth * 8 + pc::kClearPadding, 3.F);
  clear[5 * kWidth + kWidth - 1] = 1.F;  // its last column, and a reading missing in the middle
  clear[2 * kWidth + kWidth / 2] = 0.F;
  std::array<pc::DepthBox, 8> boxes;
  boxes[3] = {0, kWidth - 1, 0, 5, 2.F, 2.F};
  boxes[6] = {0, kWidth - 2, 0, 5, 2.F, 4.F};
  for (const bool scalar : {false, true}) {
    pc::DepthWindows windows;
    windows.take(clear, kWidth, {0, 8}, scalar);
    const pc::EightFound found = windows.lookAtGroups(pc::EightGroups(boxes));
    EXPECT_EQ(found.before & 0x48U, 0x08U);
    EXPECT_EQ(found.missing & 0x48U, 0x48U);
    EXPECT_EQ(found.beyond & 0x48U, 0x08U);
  }
}

TEST(Visibility, EightPixelsAtATimeSayTheSameAsOne) {
  SceneFactory factory(5);
  factory.render(standardCell(2, 2));
  const pc::CameraCloud cloud = factory.clouds(1).front();
  const pc::MergeParams merge;
  const auto optics = pc::fitPinhole(cloud);
  ASSERT_TRUE(optics.has_value());
  EXPECT_NEAR(optics->cx, 159.5, 0.01);
  EXPECT_NEAR(optics->fx, 160.0 / std::tan(0.5 * CameraModel().fov_rad), 0.01);
  const pc::CellViews views(pc::GridSpec{}, *optics, cloud.T_world_camera);
  std::array<pc::CellVotes, 2> votes;
  for (const bool scalar : {false, true}) {
    std::vector<float> clear;
    pc::clearDepths(cloud, pc::makeCropSetup(merge, cloud.T_world_camera), merge, {}, 0.01F, {0, cloud.height}, clear,
                    scalar);
    pc::CellVotes& mine = votes[scalar ? 1 : 0];
    mine.through.assign(pc::GridSpec{}.count(), 0);
    mine.behind = mine.through;
    pc::DepthWindows windows;
    windows.take(clear, cloud.width, views.rows(), scalar);
    pc::SeenThrough seen;
    views.vote(windows, 4, seen, mine);
  }
  EXPECT_EQ(votes[0].through, votes[1].through);
  EXPECT_EQ(votes[0].behind, votes[1].behind);
  EXPECT_GT(std::count(votes[0].through.begin(), votes[0].through.end(), 4), 30000);
}

/// One camera's votes on a grid; the first cloud of a factory.
pc::CellVotes votesOn(const pc::GridSpec& grid, const pc::CameraCloud& cloud) {
  const pc::MergeParams merge;
  const pc::CellViews views(grid, *pc::fitPinhole(cloud), cloud.T_world_camera);
  std::vector<float> clear;
  pc::clearDepths(cloud, pc::makeCropSetup(merge, cloud.T_world_camera), merge, {}, 0.01F, views.rows(), clear);
  pc::CellVotes votes;
  votes.through.assign(grid.count(), 0);
  votes.behind = votes.through;
  pc::DepthWindows windows;
  windows.take(clear, cloud.width, views.rows());
  pc::SeenThrough seen;
  views.vote(windows, 1, seen, votes);
  return votes;
}

TEST(Visibility, ACellHasTheSameVoteWhateverCellsItIsLookedAtWith) {
  SceneFactory factory(6);
  factory.render(standardCell(2, 2));
  const pc::CameraCloud cloud = factory.clouds(1).front();
  const pc::GridSpec whole;
  pc::GridSpec shifted;  // its blocks begin one cell further along each axis, and its last ones are cut
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    shifted.min[a] += whole.resolution(axis);
    shifted.size[a] -= 1;
  }
  const pc::CellVotes all = votesOn(whole, cloud);
  const pc::CellVotes some = votesOn(shifted, cloud);
  int others = 0;
  std::array<int, 3> counts{};
  for (std::size_t i = 0; i < shifted.count(); ++i) {
    const Eigen::Vector3d p = shifted.centre(shifted.cellOf(static_cast<int>(i)));
    const auto same = static_cast<std::size_t>(whole.indexOf(p.x(), p.y(), p.z()));
    others += all.through[same] != some.through[i] || all.behind[same] != some.behind[i] ? 1 : 0;
    ++counts[some.through[i] != 0 ? 0 : (some.behind[i] != 0 ? 1 : 2)];
  }
  EXPECT_LE(others, 3);  // a corner's rounding may move its pixel
  EXPECT_GT(counts[0], 30000);
  EXPECT_GT(counts[1], 5000);
  EXPECT_GT(counts[2], 500);
}

TEST(Visibility, AThingTakenAwayIsFreeInTheNextSetAndWhatNobodySeesAges) {
  Scene with = standardCell(0, 0);
  addBox(with, "box", {0.5, 0.5, 0.6}, {1.6, 0.0, 0.31}, true);
  Scene without = with;
  without.remove("box");
  SceneFactory factory(7);
  Cell cell;
  pc::VisibilityMap map;
  const auto step = [&](const Scene& scene, pc::StampNs stamp_ns, const std::vector<std::int32_t>& absent) {
    factory.render(scene);
    Voted voted = cell.vote(factory.clouds(stamp_ns), absent);
    map.update(voted.votes);
  };
  const auto state = [&](double x, double y, double z) {
    return map.states()[static_cast<std::size_t>(pc::GridSpec{}.indexOf(x, y, z))];
  };
  const auto age = [&](double x, double y, double z) {
    std::vector<float> ages_s;
    map.ages(ages_s);
    return ages_s[static_cast<std::size_t>(pc::GridSpec{}.indexOf(x, y, z))];
  };
  step(with, 1'000'000'000, {});
  EXPECT_EQ(state(1.6, 0.0, 0.3), pc::CellState::kNeverSeen);  // inside of the box
  EXPECT_EQ(age(1.6, 0.0, 0.3), std::numeric_limits<float>::infinity());
  EXPECT_EQ(state(1.85, 0.0, 0.3), pc::CellState::kOccupied);
  EXPECT_EQ(state(2.2, 0.0, 0.3), pc::CellState::kFree);
  step(without, 1'033'000'000, {});
  EXPECT_EQ(state(1.6, 0.0, 0.3), pc::CellState::kFree);
  EXPECT_EQ(state(1.85, 0.0, 0.3), pc::CellState::kFree);
  EXPECT_EQ(age(1.6, 0.0, 0.3), 0.F);
  step(with, 1'533'000'000, {});
  EXPECT_EQ(state(1.6, 0.0, 0.3), pc::CellState::kHidden);
  EXPECT_NEAR(age(1.6, 0.0, 0.3), 0.5F, 1e-5F);
  step(without, 1'566'000'000, {0, 1, 2, 3});  // a set of which no camera has a view shows nothing
  EXPECT_EQ(state(1.6, 0.0, 0.3), pc::CellState::kHidden);
  EXPECT_EQ(state(2.2, 0.0, 0.3), pc::CellState::kHidden);
  EXPECT_NEAR(age(2.2, 0.0, 0.3), 0.033F, 1e-5F);
  map.reset();
  EXPECT_TRUE(map.states().empty());
}

TEST(Visibility, WhatNoCameraCoversIsWhereTheEmptyFloorIsTooFarBehind) {
  SceneFactory factory(3);
  factory.render(standardCell(2, 2));
  for (const bool unread_is_clear : {false, true}) {
    pc::VisibilityParams params;
    params.unread_is_clear = unread_is_clear;
    Cell cell(params);
    cell.vote(factory.clouds(1));
    EXPECT_EQ(cell.voter.views(), 4);
    cell.vote(factory.clouds(2));
    EXPECT_EQ(cell.voter.views(), 4);  // nothing is computed again
    pc::CellVotes coverage;
    cell.voter.coverage(coverage);
    std::vector<int> lost;
    for (std::size_t i = 0; i < coverage.through.size(); ++i) {
      if (coverage.through[i] == 0) {
        lost.push_back(static_cast<int>(i));
      }
    }
    EXPECT_EQ(lost.empty(), unread_is_clear);
    EXPECT_LT(lost.size(), 500U);
    for (const int cell_index : lost) {
      EXPECT_GT(coverage.grid.centre(coverage.grid.cellOf(cell_index)).z(), 0.6);
    }
  }
}

TEST(Visibility, ACloudThatIsNoImageHasNoVoteAndIsNamed) {
  SceneFactory factory(4);
  std::vector<Render> renders = factory.render(standardCell(1, 0));
  std::vector<pc::CameraCloud> clouds = factory.clouds(1);
  std::mt19937_64 random(4);
  std::vector<std::array<float, 4>> points(320 * 320);
  std::copy(renders[1].data.begin(), renders[1].data.end(), points.front().data());
  std::shuffle(points.begin(), points.end(), random);
  clouds[1].data = reinterpret_cast<const std::uint8_t*>(points.data());
  Cell cell;
  const Voted voted = cell.vote(clouds);
  EXPECT_NE(cell.voter.fault(1), "");
  EXPECT_EQ(cell.voter.fault(0), "");
  for (const std::uint16_t votes : voted.votes.through) {
    ASSERT_EQ(votes & 2U, 0U);
  }
  EXPECT_THROW(pc::VisibilityVoter(pc::GridSpec{}, {}, {}, 17), std::invalid_argument);
}

}  // namespace
}  // namespace yarm::test
