// What the cameras see of each cell of the grid: what is free because it was seen through, and what is hidden.
#pragma once

#include "yarm/perception/merge.hpp"
#include "yarm/perception/types.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace yarm::perception {

/// Most cameras whose views are told apart: one bit each.
constexpr std::size_t kMostViews = 16;

/// When a camera has seen through a cell.
struct VisibilityParams {
  double noise_sigmas{3.0};     ///< a reading must lie beyond the cell by this many sigmas of its noise
  double range{10.0};           ///< greatest depth at which a camera measures, metres
  bool unread_is_clear{false};  ///< a pixel without a reading has nothing in its range; else it says nothing
};

/// What each camera says of each cell in one set; bit c of an entry is camera c's vote, entries are row-major x, y, z.
/// A camera has at most one vote a cell; none = outside its image, no reading, no view in this set, or not asked, as
/// an earlier one sees through the cell or something in it.
struct CellVotes {
  GridSpec grid;
  StampNs stamp_ns{0};                 ///< oldest capture time of the set
  std::vector<std::uint16_t> through;  ///< it sees through the whole cell, whatever its pixels
  std::vector<std::uint16_t> inside;   ///< it sees something in the cell
  std::vector<std::uint16_t> behind;   ///< something nearer hides the cell or a part of it
};

/// Lets the cameras of each set vote. A cell's view by a camera is computed once from its pose; optics are taken from
/// the clouds, which must be images of a pinhole camera. A camera votes "through" only when each pixel onto which any
/// point of the cell falls, or lies between, has a reading beyond the cell: no cell of which a part is hidden is voted
/// through. What the merge takes for the floor was seen through to the floor. Not thread safe.
class VisibilityVoter {
 public:
  /// Throws std::invalid_argument with more than kMostViews cameras.
  VisibilityVoter(const GridSpec& grid, const MergeParams& merge, const VisibilityParams& params, std::size_t cameras);
  ~VisibilityVoter();
  VisibilityVoter(const VisibilityVoter&) = delete;
  VisibilityVoter& operator=(const VisibilityVoter&) = delete;

  /// Votes on one set: the clouds and what they were merged to, whose absent cameras have no vote. Buffers of `votes`
  /// are used again. O(pixels + cells), mostly less.
  void vote(const std::vector<CameraCloud>& clouds, const MergedSet& set, CellVotes& votes);

  /// What each camera that has voted so far would see through in a cell in which nothing is. Only `through` is filled.
  void coverage(CellVotes& votes) const;
  /// Where a camera is, metres, world; NaN until it has had a view.
  [[nodiscard]] Eigen::Vector3d place(std::size_t camera) const;
  /// Goes up by one whenever a camera's pose or optics are found to be others: then the coverage is another one.
  [[nodiscard]] int views() const { return views_; }
  /// Why a camera cannot vote; empty when it can, or has not been asked yet.
  [[nodiscard]] const std::string& fault(std::size_t camera) const;

 private:
  class Camera;

  GridSpec grid_;
  CellFinder finder_;
  MergeParams merge_;
  VisibilityParams params_;
  std::vector<std::unique_ptr<Camera>> cameras_;
  int views_{0};
};

/// What is known of a cell. Values as in MapMetaData.
enum class CellState : std::int8_t { kNeverSeen = 0, kHidden = 1, kFree = 2, kOccupied = 3 };

/// Whether a camera sees the cell now.
constexpr bool isSeen(CellState state) {
  return state == CellState::kFree || state == CellState::kOccupied;
}

/// What is known of the cells after a set, and why the others are not seen. Bit c of an entry is camera c; only cameras
/// count that would see the cell, were nothing there.
struct SeenCells {
  std::vector<Eigen::Vector3d> cameras;  ///< where each is, metres, world
  std::vector<CellState> states;         ///< of all cells, row-major x, y, z
  std::vector<std::uint16_t> behind;     ///< of each cell that is not seen, in their order: something nearer hides it
  std::vector<std::uint16_t> unseen;     ///< likewise: the camera says nothing of it
};

/// Follows the cells over the sets. A cell is occupied when a camera sees something in it, else free when a camera
/// sees through it; else it is hidden, or never seen when it was neither before. Not thread safe.
class VisibilityMap {
 public:
  /// Takes the votes of a set on. Another grid than before starts afresh.
  void update(const CellVotes& votes);
  /// States of all cells, row-major x, y, z; empty before the first set.
  [[nodiscard]] const std::vector<CellState>& states() const { return states_; }
  /// Seconds from the last direct view of each cell (free or occupied) to the last set; +inf for never.
  void ages(std::vector<float>& ages_s) const;
  /// The states with what the votes on the last set say of the cells that are not seen. `coverage`: as coverage gives
  /// it. `seen.cameras` stays as it is; buffers are used again.
  void describe(const CellVotes& votes, const CellVotes& coverage, SeenCells& seen) const;
  /// Forgets everything (the clock went back, the scene was started again).
  void reset();

 private:
  GridSpec grid_;
  StampNs stamp_ns_{0};
  std::vector<CellState> states_;
  std::vector<StampNs> seen_ns_;  // last direct view; only where the state is not kNeverSeen
};

}  // namespace yarm::perception
