#include "stray_debris.hpp"

#include "yarm/perception/solids.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

namespace yarm::perception {

namespace {

constexpr float kStill = 0.035F;        // what moves less is at rest: noise of its middle, metres
constexpr float kAround = 0.05F;        // around a thing its ground is looked at too, metres
constexpr float kOver = 0.03F;          // a rise this near to a piece's edge is the piece, metres
constexpr float kBelow = 0.04F;         // points so far under the ground are on a side, metres
constexpr float kLeastRise = 0.012F;    // of a pixel's mean on a thing over the ground, metres
constexpr float kShareOfHeight = 0.4F;  // and at least this share of the thing's height
constexpr float kTop = 0.85F;           // share of the pixels on it below the height of its top
constexpr std::array<float, 4> kOverGround{0.F, 0.25F, 0.6F,
                                           0.9F};  // where a ray that meets the ground passes, in heights
constexpr float kPitch = 0.03F;                    // pixels are about so far apart there, metres
constexpr float kSamePixel = 200.F;                // directions are told apart to 1 in this
constexpr float kUnderTip = 0.35F;                 // a cup is no farther under the end effector, metres
constexpr float kNearBy = 0.5F;                    // what has left its place comes to rest no farther away, metres
constexpr StampNs kMissed = 300'000'000;           // a candidate that does not show for so long is none
constexpr StampNs kFalls = 2'000'000'000;          // what has left a hand is not looked for so long
constexpr StampNs kMayReturn = 4'000'000'000;      // and what has left its place is the same when it rests so soon
constexpr int kEmptySets = 5;                      // in a row that look through a piece's place
constexpr std::size_t kMostPieces = 32;

std::uint64_t pixelOf(const MergedPoint& p) {
  const auto part = [](float u) { return static_cast<std::uint64_t>(std::lround((u + 1.F) * kSamePixel)); };
  return (((static_cast<std::uint64_t>(p.camera) << 10U | part(p.ux)) << 10U | part(p.uy)) << 10U) | part(p.uz);
}

/// Height of the lowest part of a robot over a place under its end effector, metres; +inf without one.
float cupOver(const ObjectMemory& robot, const Eigen::Vector3d& place) {
  const auto tip = static_cast<float>(robot.seed().T_world_seed.translation().z());
  const Eigen::Vector3f from(static_cast<float>(place.x()), static_cast<float>(place.y()), tip - kUnderTip);
  float least = std::numeric_limits<float>::infinity();
  for (const Solid& solid : robot.solids()) {
    if (const auto T = robot.poseOf(solid.frame)) {
      const Eigen::Isometry3f T_solid_world = (*T * solid.T_frame_solid).inverse().cast<float>();
      least = std::min(least, rayEntry(solid.shape, solid.size.cast<float>(), T_solid_world * from,
                                       T_solid_world.linear() * Eigen::Vector3f::UnitZ()));
    }
  }
  return from.z() + least;
}

}  // namespace

StrayDebris::StrayDebris(const AssociationParams& params) : params_(params), rest_(params) {}

void StrayDebris::put(Piece& piece, const Eigen::Vector3d& middle) {
  piece.seed.T_world_seed.setIdentity();
  piece.seed.T_world_seed.rotate(
      Eigen::AngleAxisd(static_cast<double>(piece.footprint.axis_rad), Eigen::Vector3d::UnitZ()));
  piece.seed.T_world_seed.pretranslate(middle);
}

void StrayDebris::hang(Piece& piece, const PresentSet& set) const {
  const auto named = [&](const ObjectMemory* object) { return object->seed().name == piece.held->robot; };
  const auto robot = std::find_if(set.objects.begin(), set.objects.end(), named);
  if (robot == set.objects.end()) {
    return;
  }
  piece.seed.T_world_seed = (*robot)->seed().T_world_seed * piece.held->T_tip_piece;
  const float cup = cupOver(**robot, piece.seed.T_world_seed.translation());
  if (std::isfinite(cup)) {
    piece.seed.T_world_seed.translation().z() = static_cast<double>(cup - 0.5F * piece.height);
  }
}

void StrayDebris::join(PresentSet& set, const LinkPoses& links) {
  const auto is_over = [&](const std::unique_ptr<Piece>& piece) {
    return set.calibrating || (piece->lost && set.stamp_ns - piece->left_ns > kMayReturn);
  };
  pieces_.erase(std::remove_if(pieces_.begin(), pieces_.end(), is_over), pieces_.end());
  joined_.clear();
  first_ = set.objectCount();
  for (const std::unique_ptr<Piece>& piece : pieces_) {
    if (piece->lost) {
      continue;
    }
    if (piece->held) {
      hang(*piece, set);
    }
    piece->seed.stamp_ns = set.stamp_ns;
    piece->memory.refresh(piece->seed, &piece->known, links);
    joined_.push_back(piece.get());
  }
  for (Piece* piece : joined_) {
    set.objects.push_back(&piece->memory);
    set.robots.push_back(0);
    set.solid.push_back(0);
  }
}

void StrayDebris::update(const PresentSet& set, const SceneModel& model) {
  found_.clear();
  if (params_.debris_size <= 0.0) {
    return;
  }
  rest_.update(set, model, first_);
  if (set.calibrating) {
    candidates_.clear();
    return;
  }
  follow(set);
  collect(set);
  look(set);
  const auto rested = static_cast<StampNs>(1e9 * params_.debris_rest);
  for (const Candidate& candidate : candidates_) {
    if (set.stamp_ns - candidate.since_ns >= rested && candidate.shown_ns == set.stamp_ns &&
        4 * candidate.shown >= 3 * candidate.sets) {
      believe(candidate, set.stamp_ns);
    }
  }
  candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(),
                                   [&](const Candidate& c) { return set.stamp_ns - c.since_ns >= rested; }),
                    candidates_.end());
}

void StrayDebris::follow(const PresentSet& set) {
  for (const Rise& rise : rest_.rises()) {
    if (!isDebris(set, rise) || isTaken(set, rise)) {
      continue;
    }
    const auto near = [&](const Candidate& c) { return (c.anchor - rise.middle).norm() <= kStill; };
    auto candidate = std::find_if(candidates_.begin(), candidates_.end(), near);
    if (candidate == candidates_.end()) {
      candidates_.push_back({rise.middle, rise, set.stamp_ns, set.stamp_ns, 0, 0, {}});
      candidate = std::prev(candidates_.end());
    }
    candidate->rise = rise;
    candidate->shown_ns = set.stamp_ns;
    ++candidate->shown;
  }
  for (Candidate& candidate : candidates_) {
    ++candidate.sets;
  }
  const auto missed = [&](const Candidate& c) { return set.stamp_ns - c.shown_ns > kMissed; };
  candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), missed), candidates_.end());
}

bool StrayDebris::isDebris(const PresentSet& set, const Rise& rise) const {
  if (rise.tall || rise.box.sizes().maxCoeff() > static_cast<float>(params_.debris_size) + kAround) {
    return false;
  }
  for (int i = 0; i < first_; ++i) {
    const Seed& seed = set.object(i).seed();
    const Eigen::Vector2f place = seed.T_world_seed.translation().head<2>().cast<float>();
    if (seed.object == ObjectKind::kDebris && (place - rise.middle).norm() < kDebrisReach) {
      return false;
    }
  }
  return true;
}

/// Whether a rise is a piece that is known already.
bool StrayDebris::isTaken(const PresentSet& set, const Rise& rise) const {
  return std::any_of(joined_.begin(), joined_.end(), [&](const Piece* piece) {
    const float off = (piece->footprint.middle - rise.middle).norm();
    return !piece->held && !piece->on.empty() &&
           (off <= kOver || (set.stamp_ns - piece->left_ns > kFalls && off <= 0.5F * piece->footprint.width));
  });
}

void StrayDebris::collect(const PresentSet& set) {
  for (std::size_t i = 0; i < set.points->size() && !candidates_.empty(); ++i) {
    const MergedPoint& p = (*set.points)[i];
    if (set.owner[i] != kNobody && !set.object(set.owner[i]).isFixture()) {
      continue;
    }
    for (Candidate& candidate : candidates_) {
      const Eigen::Vector2f reach = Eigen::Vector2f::Constant(kAround);
      const Eigen::AlignedBox2f around(candidate.rise.box.min() - reach, candidate.rise.box.max() + reach);
      const float rise = p.z - candidate.rise.ground;
      if (around.contains(Eigen::Vector2f(p.x, p.y)) && rise > -kBelow &&
          rise <= static_cast<float>(params_.debris_size)) {
        Pixel& pixel = candidate.pixels[pixelOf(p)];
        pixel.sum += Eigen::Vector3f(p.x, p.y, p.z);
        pixel.ray = Eigen::Vector3f(p.ux, p.uy, p.uz);
        ++pixel.readings;
      }
    }
  }
}

StrayDebris::Outline StrayDebris::outlineOf(const Candidate& candidate) {
  Outline outline;
  const float height = candidate.rise.height;
  const float least = std::max(kLeastRise, kShareOfHeight * height);
  for (const auto& [key, pixel] : candidate.pixels) {
    const Eigen::Vector3f mean = pixel.sum / static_cast<float>(pixel.readings);
    const float rise = mean.z() - candidate.rise.ground;
    if (2 * pixel.readings < candidate.sets) {
      continue;
    }
    if (rise > least) {
      outline.on.emplace_back(mean.head<2>());
      outline.rises.push_back(rise);
      outline.pixels.emplace(key, mean);
      continue;
    }
    for (const float share : kOverGround) {
      outline.beside.emplace_back((mean + pixel.ray * (share * height / pixel.ray.z())).head<2>());
    }
  }
  return outline;
}

void StrayDebris::believe(const Candidate& candidate, StampNs stamp_ns) {
  Outline outline = outlineOf(candidate);
  std::vector<float>& heights = outline.rises;
  const std::optional<Footprint> footprint = footprintOf(outline.on, outline.beside, kPitch);
  Piece* piece = footprint ? leftNear(footprint->middle, stamp_ns) : nullptr;
  if (!footprint || footprint->length > static_cast<float>(params_.debris_size) ||
      (piece == nullptr && pieces_.size() >= kMostPieces)) {
    return;
  }
  if (piece == nullptr) {
    pieces_.push_back(std::make_unique<Piece>());
    piece = pieces_.back().get();
    piece->number = next_number_++;
  }
  const auto top = heights.begin() + static_cast<std::ptrdiff_t>(kTop * static_cast<float>(heights.size() - 1) + 0.5F);
  std::nth_element(heights.begin(), top, heights.end());
  piece->footprint = *footprint;
  piece->ground = candidate.rise.ground;
  piece->height = *top;
  piece->on = std::move(outline.pixels);
  piece->left_ns = -1;
  piece->empty_sets = 0;
  piece->lost = false;
  piece->seed.name = strayName(piece->number);
  piece->seed.object = ObjectKind::kDebris;
  piece->seed.is_static = false;
  Solid box;
  box.size = Eigen::Vector3f(footprint->length, footprint->width, piece->height).cast<double>();
  box.frame = piece->seed.name;
  piece->known = {piece->seed.name, {piece->seed.name}, {box}};
  put(*piece, {static_cast<double>(footprint->middle.x()), static_cast<double>(footprint->middle.y()),
               static_cast<double>(piece->ground + 0.5F * piece->height)});
  const Eigen::Vector2f half = Eigen::Vector2f::Constant(0.5F * footprint->length + kOver);
  const Eigen::Vector2f low = footprint->middle - half;
  const Eigen::Vector2f high = footprint->middle + half;
  found_.emplace_back(Eigen::Vector3f(low.x(), low.y(), piece->ground - kBelow),
                      Eigen::Vector3f(high.x(), high.y(), piece->ground + piece->height + kAround));
}

/// The piece that has left its place, or a hand, not long ago and not far from here; null for none.
StrayDebris::Piece* StrayDebris::leftNear(const Eigen::Vector2f& place, StampNs stamp_ns) {
  Piece* nearest = nullptr;
  float least = kNearBy;
  for (const std::unique_ptr<Piece>& piece : pieces_) {
    const float off = (piece->footprint.middle - place).norm();
    const bool left = piece->left_ns >= 0 && stamp_ns - piece->left_ns <= kMayReturn;
    if (!piece->held && off < (left ? least : std::min(least, 0.5F * piece->footprint.length))) {
      nearest = piece.get();
      least = off;
    }
  }
  return nearest;
}

void StrayDebris::look(const PresentSet& set) {
  std::vector<Eigen::Vector2i> votes(joined_.size(), Eigen::Vector2i::Zero());  // still there, looked through
  for (const MergedPoint& p : *set.points) {
    const Eigen::Vector3f place(p.x, p.y, p.z);
    for (std::size_t k = 0; k < joined_.size(); ++k) {
      const Piece& piece = *joined_[k];
      if ((place.head<2>() - piece.footprint.middle).norm() > piece.footprint.length + 2.F * kAround) {
        continue;
      }
      const auto pixel = piece.on.find(pixelOf(p));
      if (pixel != piece.on.end()) {
        const Eigen::Vector3f ray(p.ux, p.uy, p.uz);
        const float beyond = (place - pixel->second).dot(ray);
        const float half = 0.5F * (pixel->second.z() - piece.ground) / std::abs(p.uz);
        votes[k] += Eigen::Vector2i(std::abs(beyond) <= half ? 1 : 0, beyond > half ? 1 : 0);
      }
    }
  }
  for (std::size_t k = 0; k < joined_.size(); ++k) {
    Piece& piece = *joined_[k];
    const bool unknown = piece.held || (piece.left_ns >= 0 && set.stamp_ns - piece.left_ns < kFalls);
    piece.empty_sets = !unknown && votes[k].y() > 3 * votes[k].x() ? piece.empty_sets + 1 : 0;
    const bool not_found = !piece.held && piece.on.empty() && set.stamp_ns - piece.left_ns > kMayReturn;
    if (piece.empty_sets >= kEmptySets || not_found) {
      piece.lost = true;
      piece.left_ns = set.stamp_ns;
    }
  }
}

void StrayDebris::carry(const PresentSet& set, const std::vector<Hands::Load>& loads) {
  for (std::size_t k = 0; k < joined_.size(); ++k) {
    Piece& piece = *joined_[k];
    const auto is_load = [&](const Hands::Load& load) { return load.piece == first_ + static_cast<int>(k); };
    const auto load = std::find_if(loads.begin(), loads.end(), is_load);
    if (load != loads.end()) {
      piece.held = piece.held ? piece.held : Held{set.object(load->robot).seed().name, load->T_tip_piece};
      piece.lost = false;
      piece.left_ns = -1;
    } else if (piece.held) {
      piece.held.reset();
      piece.left_ns = set.stamp_ns;
      piece.on.clear();
      const Eigen::Isometry3d& T = piece.seed.T_world_seed;
      piece.footprint.middle = T.translation().head<2>().cast<float>();
      piece.footprint.axis_rad = static_cast<float>(std::atan2(T.linear()(1, 0), T.linear()(0, 0)));
      piece.ground = rest_.groundAt(piece.footprint.middle.x(), piece.footprint.middle.y());
      piece.lost = std::isnan(piece.ground);
      const double height = static_cast<double>(piece.ground + 0.5F * piece.height);
      put(piece, {T.translation().x(), T.translation().y(), piece.lost ? T.translation().z() : height});
    }
  }
}

std::optional<PieceView> StrayDebris::viewOf(int object) const {
  if (object < first_) {
    return std::nullopt;
  }
  const Piece& piece = *joined_[static_cast<std::size_t>(object - first_)];
  PieceView view;
  const Eigen::Isometry3d& T = piece.seed.T_world_seed;
  view.top = T.translation() + 0.5 * static_cast<double>(piece.height) * Eigen::Vector3d::UnitZ();
  view.axis_rad = std::remainder(std::atan2(T.linear()(1, 0), T.linear()(0, 0)), EIGEN_PI);
  view.length = static_cast<double>(piece.footprint.length);
  view.width = static_cast<double>(piece.footprint.width);
  return view;
}

bool StrayDebris::foundAt(const Eigen::Vector3f& point) const {
  return std::any_of(found_.begin(), found_.end(), [&](const Eigen::AlignedBox3f& box) { return box.contains(point); });
}

void StrayDebris::reset() {
  rest_.reset();
  candidates_.clear();
  pieces_.clear();
  joined_.clear();
  found_.clear();
  next_number_ = 1;
}

}  // namespace yarm::perception
