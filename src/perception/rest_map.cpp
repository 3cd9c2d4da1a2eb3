#include "rest_map.hpp"

#include "yarm/perception/solids.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace yarm::perception {

namespace {

constexpr float kSpot = 0.02F;               // edge of a spot, metres
constexpr int kBeside = 2;                   // spots beside a higher top that count as that high
constexpr int kGap = 3;                      // spots no farther apart than this belong to one thing
constexpr float kRise = 0.012F;              // what rises less is the body's own, metres
constexpr float kRiseSigmas = 4.0F;          // and less than this many sigmas of the mean
constexpr float kBelow = 0.04F;              // points so far under the ground are on a side, metres
constexpr int kMostPoints = 10;              // of a spot that count: the older ones fade
constexpr int kLeastPoints = 6;              // of a spot that says something
constexpr StampNs kStale = 500'000'000;      // a spot not seen for so long begins anew
constexpr StampNs kShownFor = 150'000'000;   // a spot rises as long after it was last seen
constexpr StampNs kTallFor = 1'000'000'000;  // a spot under something high is suspect for so long
constexpr float kNearRobot = 0.06F;          // what rises this near to a robot's surface may be the robot's, metres
constexpr float kFarUp = 10.F;               // from where the tops are looked for, metres

/// First and last of `count` spots from `from` on that lie between two coordinates, however far these are.
std::pair<int, int> spotsBetween(float low, float high, double from, int count) {
  const auto index = [&](float value) {
    const float at = std::floor((value - static_cast<float>(from)) / kSpot);
    return static_cast<int>(std::clamp(at, -1.F, static_cast<float>(count)));
  };
  return {std::max(0, index(low)), std::min(count - 1, index(high))};
}

}  // namespace

RestMap::RestMap(const AssociationParams& params)
    : params_(params),
      nx_(static_cast<int>(std::ceil((params.grid.max[0] - params.grid.min[0]) / static_cast<double>(kSpot)))),
      ny_(static_cast<int>(std::ceil((params.grid.max[1] - params.grid.min[1]) / static_cast<double>(kSpot)))),
      spots_(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_)) {}

int RestMap::spotAt(float x, float y) const {
  const float column = (x - static_cast<float>(params_.grid.min[0])) / kSpot;
  const float row = (y - static_cast<float>(params_.grid.min[1])) / kSpot;
  if (!(column >= 0.F && row >= 0.F && column < static_cast<float>(nx_) && row < static_cast<float>(ny_))) {
    return -1;
  }
  return static_cast<int>(column) * ny_ + static_cast<int>(row);
}

Eigen::Vector2f RestMap::centreOf(int spot) const {
  return {static_cast<float>(params_.grid.min[0]) + (static_cast<float>(spot / ny_) + 0.5F) * kSpot,
          static_cast<float>(params_.grid.min[1]) + (static_cast<float>(spot % ny_) + 0.5F) * kSpot};
}

/// Calls `use(spot)` for the spots within a gap of one.
template <class Use>
void RestMap::around(std::size_t spot, int gap, Use&& use) const {
  const int at = static_cast<int>(spot);
  for (int x = std::max(0, at / ny_ - gap); x <= std::min(nx_ - 1, at / ny_ + gap); ++x) {
    for (int y = std::max(0, at % ny_ - gap); y <= std::min(ny_ - 1, at % ny_ + gap); ++y) {
      use(static_cast<std::size_t>(x * ny_ + y));
    }
  }
}

void RestMap::refreshGround(const PresentSet& set) {
  std::vector<float> drawn;
  for (const ObjectMemory* object : set.objects) {
    for (const Solid& solid : object->solids()) {
      const auto T = object->isFixture() ? object->poseOf(solid.frame) : std::nullopt;
      if (T) {
        const Eigen::Matrix4f pose = (*T * solid.T_frame_solid).matrix().cast<float>();
        drawn.insert(drawn.end(), pose.data(), pose.data() + pose.size());
        drawn.insert(drawn.end(), {static_cast<float>(solid.shape), static_cast<float>(solid.size.x()),
                                   static_cast<float>(solid.size.y()), static_cast<float>(solid.size.z())});
      }
    }
  }
  if (drawn == drawn_) {
    return;
  }
  drawn_ = std::move(drawn);
  for (Spot& spot : spots_) {
    spot.ground = std::numeric_limits<float>::quiet_NaN();
  }
  for (int i = 0; i < set.objectCount(); ++i) {
    raise(set, i);
  }
  widen();
}

/// Raises the ground to the tops of a fixed body's solids.
void RestMap::raise(const PresentSet& set, int object) {
  const ObjectMemory& body = set.object(object);
  for (const Solid& solid : body.solids()) {
    const auto T = body.isFixture() ? body.poseOf(solid.frame) : std::nullopt;
    if (!T) {
      continue;
    }
    const Eigen::Isometry3f T_world_solid = (*T * solid.T_frame_solid).cast<float>();
    const Eigen::Isometry3f T_solid_world = T_world_solid.inverse();
    const Eigen::Vector3f size = solid.size.cast<float>();
    const Eigen::Vector3f half = T_world_solid.linear().cwiseAbs() * halfExtents(solid.shape, size);
    const Eigen::Vector3f low = T_world_solid.translation() - half;
    const Eigen::Vector3f high = T_world_solid.translation() + half;
    if (!(low.x() <= high.x() && low.y() <= high.y())) {
      continue;
    }
    const auto [first_x, last_x] = spotsBetween(low.x(), high.x(), params_.grid.min[0], nx_);
    const auto [first_y, last_y] = spotsBetween(low.y(), high.y(), params_.grid.min[1], ny_);
    for (int x = first_x; x <= last_x; ++x) {
      for (int y = first_y; y <= last_y; ++y) {
        const int at = x * ny_ + y;
        const Eigen::Vector2f centre = centreOf(at);
        const float down = rayEntry(solid.shape, size, T_solid_world * Eigen::Vector3f(centre.x(), centre.y(), kFarUp),
                                    T_solid_world.linear() * -Eigen::Vector3f::UnitZ());
        if (std::isfinite(down)) {
          float& ground = spots_[static_cast<std::size_t>(at)].ground;
          ground = std::isnan(ground) ? kFarUp - down : std::max(ground, kFarUp - down);
        }
      }
    }
  }
}

/// Spots beside a higher top become as high.
void RestMap::widen() {
  std::vector<float> drawn(spots_.size());
  std::transform(spots_.begin(), spots_.end(), drawn.begin(), [](const Spot& spot) { return spot.ground; });
  tops_.clear();
  for (int i = 0; i < static_cast<int>(spots_.size()); ++i) {
    float& ground = spots_[static_cast<std::size_t>(i)].ground;
    if (std::isnan(ground)) {
      continue;
    }
    tops_.push_back(i);
    for (int x = std::max(0, i / ny_ - kBeside); x <= std::min(nx_ - 1, i / ny_ + kBeside); ++x) {
      for (int y = std::max(0, i % ny_ - kBeside); y <= std::min(ny_ - 1, i % ny_ + kBeside); ++y) {
        const float beside = drawn[static_cast<std::size_t>(x * ny_ + y)];
        ground = std::isnan(beside) ? ground : std::max(ground, beside);
      }
    }
  }
}

void RestMap::update(const PresentSet& set, const SceneModel& model, int first_stray) {
  refreshGround(set);
  if (calibrating_ && !set.calibrating) {
    learn();
  }
  calibrating_ = set.calibrating;
  stamp_ns_ = set.stamp_ns;
  std::vector<char> counts(set.objects.size());
  for (int i = 0; i < set.objectCount(); ++i) {
    counts[static_cast<std::size_t>(i)] = set.object(i).isFixture() || i >= first_stray ? 1 : 0;
  }
  for (std::size_t i = 0; i < set.points->size(); ++i) {
    const int owner = set.owner[i];
    if (owner == kNobody || counts[static_cast<std::size_t>(owner)] != 0) {
      take((*set.points)[i], owner == kNobody, model, set.robots);
    }
  }
}

void RestMap::take(const MergedPoint& p, bool nobodys, const SceneModel& model, const std::vector<char>& robots) {
  const int at = spotAt(p.x, p.y);
  if (at < 0 || std::isnan(spots_[static_cast<std::size_t>(at)].ground)) {
    return;
  }
  Spot& spot = spots_[static_cast<std::size_t>(at)];
  const float rise = p.z - spot.ground - spot.learnt;
  if (rise > static_cast<float>(params_.debris_size)) {
    spot.tall_ns = nobodys ? stamp_ns_ : spot.tall_ns;
    return;
  }
  if (rise < -kBelow || (rise > kRise && model.nearest({p.x, p.y, p.z}, robots, kNearRobot).object != kNobody)) {
    return;
  }
  if (stamp_ns_ - spot.seen_ns > kStale) {
    spot.points = 0;
    spot.mean = 0.F;
  }
  spot.points = std::min(spot.points + 1, kMostPoints);
  spot.mean += (rise - spot.mean) / static_cast<float>(spot.points);
  spot.variance = p.sigma * p.uz * p.sigma * p.uz;
  spot.seen_ns = stamp_ns_;
}

/// What rises belongs to the body, and the spots beside it, which noise lets a point of it meet now and then.
void RestMap::learn() {
  std::vector<float> learnt(spots_.size(), 0.F);
  for (const std::int32_t at : tops_) {
    const Spot& spot = spots_[static_cast<std::size_t>(at)];
    if (rises(spot)) {
      around(static_cast<std::size_t>(at), kGap,
             [&](std::size_t beside) { learnt[beside] = std::max(learnt[beside], spot.learnt + spot.mean); });
    }
  }
  for (const std::int32_t at : tops_) {
    Spot& spot = spots_[static_cast<std::size_t>(at)];
    spot.learnt = std::max(spot.learnt, learnt[static_cast<std::size_t>(at)]);
    spot.points = 0;
    spot.mean = 0.F;
  }
}

bool RestMap::rises(const Spot& spot) const {
  return spot.points >= kLeastPoints && spot.mean > kRise && stamp_ns_ - spot.seen_ns <= kShownFor &&
         spot.mean * spot.mean * static_cast<float>(spot.points) > kRiseSigmas * kRiseSigmas * spot.variance;
}

std::vector<Rise> RestMap::rises() const {
  std::vector<Rise> found;
  std::vector<char> taken(spots_.size(), 0);
  for (int gap = kGap; gap >= 1; --gap) {
    std::vector<char> met = taken;
    for (const std::int32_t at : tops_) {
      if (met[static_cast<std::size_t>(at)] != 0 || !rises(spots_[static_cast<std::size_t>(at)])) {
        continue;
      }
      const std::vector<std::size_t> spots = grow(static_cast<std::size_t>(at), gap, met);
      const Rise rise = describe(spots);
      if (gap == 1 || rise.box.sizes().maxCoeff() <= static_cast<float>(params_.debris_size)) {
        found.push_back(rise);
        std::for_each(spots.begin(), spots.end(), [&](std::size_t spot) { taken[spot] = 1; });
      }
    }
  }
  return found;
}

std::vector<std::size_t> RestMap::grow(std::size_t first, int gap, std::vector<char>& met) const {
  std::vector<std::size_t> spots{first};
  met[first] = 1;
  for (std::size_t next = 0; next < spots.size(); ++next) {
    around(spots[next], gap, [&](std::size_t beside) {
      if (met[beside] == 0 && rises(spots_[beside])) {
        met[beside] = 1;
        spots.push_back(beside);
      }
    });
  }
  return spots;
}

Rise RestMap::describe(const std::vector<std::size_t>& spots) const {
  Rise rise;
  rise.ground = std::numeric_limits<float>::infinity();
  for (const std::size_t at : spots) {
    const Spot& spot = spots_[at];
    const Eigen::Vector2f centre = centreOf(static_cast<int>(at));
    rise.box.extend(centre - Eigen::Vector2f::Constant(0.5F * kSpot));
    rise.box.extend(centre + Eigen::Vector2f::Constant(0.5F * kSpot));
    rise.middle += centre / static_cast<float>(spots.size());
    rise.ground = std::min(rise.ground, spot.ground + spot.learnt);
    rise.height = std::max(rise.height, spot.mean);
    around(at, kGap, [&](std::size_t beside) {
      rise.tall = rise.tall || (spots_[beside].tall_ns >= 0 && stamp_ns_ - spots_[beside].tall_ns < kTallFor);
    });
  }
  return rise;
}

float RestMap::groundAt(float x, float y) const {
  const int at = spotAt(x, y);
  return at < 0 ? std::numeric_limits<float>::quiet_NaN()
                : spots_[static_cast<std::size_t>(at)].ground + spots_[static_cast<std::size_t>(at)].learnt;
}

void RestMap::reset() {
  std::fill(spots_.begin(), spots_.end(), Spot{});
  tops_.clear();
  drawn_.clear();
  calibrating_ = false;
}

}  // namespace yarm::perception
