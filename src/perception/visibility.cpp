#include "yarm/perception/visibility.hpp"

#include "cell_views.hpp"
#include "crop_kernel.hpp"
#include "depth_view.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

namespace yarm::perception {

namespace {

void clearVotes(const GridSpec& grid, CellVotes& votes) {
  votes.grid = grid;
  votes.through.assign(grid.count(), 0);
  votes.inside.assign(grid.count(), 0);
  votes.behind.assign(grid.count(), 0);
}

std::uint16_t bitOf(std::size_t camera) {
  return static_cast<std::uint16_t>(1U << camera);
}

}  // namespace

/// One camera: its optics and pose, and the cells as it sees them from there.
class VisibilityVoter::Camera {
 public:
  /// Brings the views up to the cloud's optics and pose; whether they are others now. Sets the fault.
  bool follow(const GridSpec& grid, const CameraCloud& cloud) {
    if (optics_ && pose_.matrix() == cloud.T_world_camera.matrix() && fits(*optics_, cloud)) {
      return false;
    }
    views_.reset();
    optics_ = fitPinhole(cloud);
    pose_ = cloud.T_world_camera;
    fault_ =
        optics_ ? "" : "its cloud is no image of a pinhole camera, so that nothing can be told of what it sees through";
    if (optics_) {
      views_ = std::make_unique<CellViews>(grid, *optics_, pose_);
    }
    return optics_.has_value();
  }

  void vote(const CameraCloud& cloud, const MergeParams& merge, const VisibilityParams& params, std::uint16_t bit,
            SeenThrough& seen, CellVotes& votes) {
    if (views_) {
      clearDepths(cloud, makeCropSetup(merge, pose_), merge, params, static_cast<float>(votes.grid.min[2]),
                  views_->rows(), clear_);
      windows_.take(clear_, cloud.width, views_->rows());
      views_->vote(windows_, bit, seen, votes);
    }
  }

  void cover(const VisibilityParams& params, std::uint16_t bit, CellVotes& votes) const {
    if (views_) {
      std::vector<float> clear;
      clearDepthsOfEmptyCell(*optics_, pose_, params, clear);
      DepthWindows windows;
      windows.take(clear, optics_->width, views_->rows());
      SeenThrough by_nobody;  // here every camera is asked
      views_->vote(windows, bit, by_nobody, votes);
    }
  }

  [[nodiscard]] const std::string& fault() const { return fault_; }
  [[nodiscard]] Eigen::Vector3d place() const {
    constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
    return optics_ ? Eigen::Vector3d(pose_.translation().cast<double>()) : Eigen::Vector3d::Constant(kNowhere);
  }

 private:
  std::optional<Pinhole> optics_;
  Eigen::Isometry3f pose_{Eigen::Isometry3f::Identity()};
  std::unique_ptr<CellViews> views_;
  std::vector<float> clear_;
  DepthWindows windows_;
  std::string fault_;
};

VisibilityVoter::VisibilityVoter(const GridSpec& grid, const MergeParams& merge, const VisibilityParams& params,
                                 std::size_t cameras)
    : grid_(grid), finder_(grid), merge_(merge), params_(params) {
  if (cameras > kMostViews) {
    throw std::invalid_argument("visibility: " + std::to_string(cameras) + " cameras, at most " +
                                std::to_string(kMostViews) + " can be told apart; switch it off or use fewer");
  }
  for (std::size_t c = 0; c < cameras; ++c) {
    cameras_.push_back(std::make_unique<Camera>());
  }
}

VisibilityVoter::~VisibilityVoter() = default;

void VisibilityVoter::vote(const std::vector<CameraCloud>& clouds, const MergedSet& set, CellVotes& votes) {
  clearVotes(grid_, votes);
  votes.stamp_ns = set.stamp_ns;
  std::uint32_t seeing = 0;
  SeenThrough seen;
  for (std::size_t c = 0; c < std::min(clouds.size(), cameras_.size()); ++c) {
    const bool absent = std::count(set.absent.begin(), set.absent.end(), static_cast<std::int32_t>(c)) > 0;
    if (absent || clouds[c].width * clouds[c].height == 0) {
      continue;
    }
    seeing |= bitOf(c);
    views_ += cameras_[c]->follow(grid_, clouds[c]) ? 1 : 0;
    cameras_[c]->vote(clouds[c], merge_, params_, bitOf(c), seen, votes);
  }
  for (const MergedPoint& p : set.points) {
    const int cell = finder_.indexOf(p.x, p.y, p.z);
    const auto bit = static_cast<std::uint16_t>(bitOf(static_cast<std::size_t>(p.camera)) & seeing);
    if (cell >= 0) {
      votes.inside[static_cast<std::size_t>(cell)] |= bit;
    }
  }
  for (std::size_t i = 0; i < votes.inside.size(); ++i) {
    const auto not_inside = static_cast<std::uint16_t>(~votes.inside[i]);
    votes.through[i] &= not_inside;
    votes.behind[i] &= not_inside;
  }
}

void VisibilityVoter::coverage(CellVotes& votes) const {
  clearVotes(grid_, votes);
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    cameras_[c]->cover(params_, bitOf(c), votes);
  }
  std::fill(votes.behind.begin(), votes.behind.end(), 0);
}

const std::string& VisibilityVoter::fault(std::size_t camera) const {
  return cameras_[camera]->fault();
}

Eigen::Vector3d VisibilityVoter::place(std::size_t camera) const {
  return cameras_[camera]->place();
}

void VisibilityMap::update(const CellVotes& votes) {
  const GridSpec& grid = votes.grid;
  if (states_.empty() || grid.size != grid_.size || grid.min != grid_.min || grid.max != grid_.max) {
    grid_ = grid;
    states_.assign(grid.count(), CellState::kNeverSeen);
    seen_ns_.assign(grid.count(), 0);
  }
  stamp_ns_ = votes.stamp_ns;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const CellState unseen = states_[i] == CellState::kNeverSeen ? CellState::kNeverSeen : CellState::kHidden;
    const CellState clear = votes.through[i] != 0 ? CellState::kFree : unseen;
    states_[i] = votes.inside[i] != 0 ? CellState::kOccupied : clear;
  }
  for (std::size_t i = 0; i < states_.size(); ++i) {
    seen_ns_[i] = isSeen(states_[i]) ? stamp_ns_ : seen_ns_[i];
  }
}

void VisibilityMap::ages(std::vector<float>& ages_s) const {
  ages_s.resize(states_.size());
  for (std::size_t i = 0; i < states_.size(); ++i) {
    ages_s[i] = states_[i] == CellState::kNeverSeen ? std::numeric_limits<float>::infinity()
                                                    : static_cast<float>(stamp_ns_ - seen_ns_[i]) * 1e-9F;
  }
}

void VisibilityMap::describe(const CellVotes& votes, const CellVotes& coverage, SeenCells& seen) const {
  seen.states = states_;
  seen.behind.clear();
  seen.unseen.clear();
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (!isSeen(states_[i])) {
      seen.behind.push_back(votes.behind[i] & coverage.through[i]);
      seen.unseen.push_back(static_cast<std::uint16_t>(coverage.through[i] & ~votes.behind[i]));
    }
  }
}

void VisibilityMap::reset() {
  states_.clear();
}

}  // namespace yarm::perception
