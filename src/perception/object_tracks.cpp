#include "object_tracks.hpp"

#include "assignment.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

namespace yarm::perception {

namespace {

constexpr std::size_t kMostTracks = 64;
constexpr double kLongestStep = 1.0;         // between two sets, seconds; what is longer is not predicted
constexpr double kOutermost = 0.03;          // share of the points that lies outside of an edge: noise
constexpr double kEdgeNoise = 0.02;          // of an edge of many points, metres
constexpr double kFewNoise = 0.1;            // over the root of the number of points: of an edge of few, metres
constexpr double kAtBorder = 0.06;           // an edge this near to the border of the volume is cut by it, metres
constexpr double kNear = 0.15;               // a group this near to where a track should be may be its, metres
constexpr double kGateSigmas = 3.0;          // and nearer than this many sigmas of its place besides
constexpr double kFarthest = 0.8;            // but no group further away, metres
constexpr double kPlaceNoise = 0.1;          // how well a group tells where its thing is, at most, metres
constexpr double kNoGroup = 1e4;             // cost of a track without a group: any other that it may have is cheaper
constexpr double kNotBelieved = 1.0;         // cost of a group's going to a track that is not believed yet
constexpr double kMiddles = 0.1;             // weight of the middles beside the edges
constexpr double kBeyond = 0.15;             // a group larger than its track by more is more than that track, metres
constexpr double kAround = 0.1;              // around a track's box, metres
constexpr std::size_t kLeastShare = 5;       // points of a group that is shared out
constexpr int kGoneSets = 2;                 // sets in a row that must look through the place of one that ends
constexpr std::size_t kMostOfBody = 512;     // points of a view that is kept, about
constexpr double kFullView = 0.7;            // share of the fullest view's points that makes a view as full
constexpr double kFades = 0.98;              // of the fullest view's points, from set to set
constexpr double kStands = 0.1;              // what was slower when it was hidden stands there, m/s
constexpr StampNs kOutside = 1'000'000'000;  // one that was at the border may come back from outside as long
constexpr StampNs kCovered = 700'000'000;    // as long as one thing may walk before another one

using Axes = std::array<AxisFilter, 3>;

Eigen::AlignedBox3d boxOf(const Axes& axes) {
  return {Eigen::Vector3d(axes[0].low(), axes[1].low(), axes[2].low()),
          Eigen::Vector3d(axes[0].high(), axes[1].high(), axes[2].high())};
}

Eigen::AlignedBox3d boxOf(const std::array<SeenEdges, 3>& edges) {
  return {Eigen::Vector3d(edges[0].low, edges[1].low, edges[2].low),
          Eigen::Vector3d(edges[0].high, edges[1].high, edges[2].high)};
}

Eigen::AlignedBox3d widened(const Eigen::AlignedBox3d& box, double by) {
  return {box.min() - Eigen::Vector3d::Constant(by), box.max() + Eigen::Vector3d::Constant(by)};
}

Eigen::Vector3d middleOf(const Axes& axes) {
  return {axes[0].middle(), axes[1].middle(), axes[2].middle()};
}

Eigen::Vector3f pointOf(const MergedPoint& p) {
  return {p.x, p.y, p.z};
}

/// Whether a thing is cut by the border of the volume along x or y.
bool isAtBorder(const std::array<SeenEdges, 3>& edges) {
  return edges[0].low_cut || edges[0].high_cut || edges[1].low_cut || edges[1].high_cut;
}

/// Horizontal gap between what two groups show, metres.
double gapBetween(const std::array<SeenEdges, 3>& a, const std::array<SeenEdges, 3>& b) {
  const auto along = [&](std::size_t axis) {
    return std::max({0.0, a[axis].low - b[axis].high, b[axis].low - a[axis].high});
  };
  return std::hypot(along(0), along(1));
}

/// Whether one box is larger than another along x or y, by more than a thing's edges wander.
bool isBeyond(const Eigen::AlignedBox3d& box, const Eigen::AlignedBox3d& other) {
  const Eigen::Vector3d more = box.sizes() - other.sizes();
  return std::max(more.x(), more.y()) > kBeyond;
}

/// Horizontal distance of a point from a track's middle, in halves of its box.
double off(const MergedPoint& p, const Axes& axes) {
  const double x = (static_cast<double>(p.x) - axes[0].middle()) / std::max(axes[0].extent(), kAround);
  const double y = (static_cast<double>(p.y) - axes[1].middle()) / std::max(axes[1].extent(), kAround);
  return x * x + y * y;
}

}  // namespace

ObjectTracks::Shown ObjectTracks::shownBy(const std::vector<MergedPoint>& points, Group group) const {
  Shown shown;
  const auto outside = static_cast<std::ptrdiff_t>(kOutermost * static_cast<double>(group.size()));
  std::vector<float> along(group.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::transform(group.begin(), group.end(), along.begin(),
                   [&](std::uint32_t i) { return pointOf(points[i])[static_cast<int>(axis)]; });
    SeenEdges& edges = shown.edges[axis];
    std::nth_element(along.begin(), along.begin() + outside, along.end());
    edges.low = static_cast<double>(along[static_cast<std::size_t>(outside)]);
    std::nth_element(along.begin(), along.end() - 1 - outside, along.end());
    edges.high = static_cast<double>(*(along.end() - 1 - outside));
    edges.low_cut = edges.low < params_.grid.min[axis] + kAtBorder;
    edges.high_cut = edges.high > params_.grid.max[axis] - kAtBorder;
    edges.variance = kEdgeNoise * kEdgeNoise + kFewNoise * kFewNoise / static_cast<double>(group.size());
  }
  for (const std::uint32_t i : group) {
    shown.cameras |= 1U << (static_cast<std::uint32_t>(points[i].camera) % 32U);
  }
  shown.points = std::move(group);
  return shown;
}

double ObjectTracks::cost(const Track& track, const Shown& shown) const {
  const Eigen::AlignedBox3d box = boxOf(track.axes);
  const Eigen::AlignedBox3d seen = boxOf(shown.edges);
  double sum = track.number == 0 ? kNotBelieved : 0.0;
  double uncertain = 0.0;
  for (int axis = 0; axis < 2; ++axis) {
    const double variance = track.axes[static_cast<std::size_t>(axis)].covariance()(0, 0);
    const double middle = seen.center()[axis] - box.center()[axis];
    const double edge = std::min(
        {std::abs(seen.min()[axis] - box.min()[axis]), std::abs(seen.max()[axis] - box.max()[axis]), std::abs(middle)});
    sum += (edge * edge + kMiddles * middle * middle) / (variance + kPlaceNoise * kPlaceNoise);
    uncertain = std::max(uncertain, variance);
  }
  const double gate = std::min(kFarthest, kNear + kGateSigmas * std::sqrt(uncertain));
  return box.squaredExteriorDistance(seen) > gate * gate ? kNoGroup : sum;
}

void ObjectTracks::joinAtBorder(const std::vector<MergedPoint>& points, std::vector<Shown>& shown) const {
  for (std::size_t g = 0; g < shown.size(); ++g) {
    const auto joins = [&](const Shown& other) {
      return &other != &shown[g] && isAtBorder(shown[g].edges) && isAtBorder(other.edges) &&
             gapBetween(shown[g].edges, other.edges) <= params_.search_radius;
    };
    for (auto other = std::find_if(shown.begin() + static_cast<std::ptrdiff_t>(g), shown.end(), joins);
         other != shown.end();
         other = std::find_if(shown.begin() + static_cast<std::ptrdiff_t>(g), shown.end(), joins)) {
      Group all = std::move(shown[g].points);
      all.insert(all.end(), other->points.begin(), other->points.end());
      shown[g] = shownBy(points, std::move(all));
      shown.erase(other);
    }
  }
}

std::vector<int> ObjectTracks::bringTogether(const std::vector<MergedPoint>& points, std::vector<Shown>& shown) const {
  std::vector<std::vector<double>> costs(tracks_.size(), std::vector<double>(shown.size()));
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    for (std::size_t g = 0; g < shown.size(); ++g) {
      costs[t][g] = cost(tracks_[t], shown[g]);
    }
  }
  std::vector<int> of = assignAtLeastCost(costs, kNoGroup);
  joinParts(points, shown, of);
  shareJoint(points, shown, of);
  return of;
}

void ObjectTracks::joinParts(const std::vector<MergedPoint>& points, std::vector<Shown>& shown,
                             const std::vector<int>& of) const {
  for (std::size_t g = 0; g < shown.size(); ++g) {
    if (std::find(of.begin(), of.end(), static_cast<int>(g)) != of.end()) {
      continue;
    }
    for (std::size_t t = 0; t < of.size() && !shown[g].points.empty(); ++t) {
      const Eigen::AlignedBox3d box = widened(boxOf(tracks_[t].axes), kAround);
      if (of[t] == kUnassigned || !box.contains(boxOf(shown[g].edges).center())) {
        continue;
      }
      Shown& whole = shown[static_cast<std::size_t>(of[t])];
      if (!isBeyond(boxOf(whole.edges).merged(boxOf(shown[g].edges)), box)) {
        Group all = whole.points;
        all.insert(all.end(), shown[g].points.begin(), shown[g].points.end());
        whole = shownBy(points, std::move(all));
        shown[g].points.clear();
      }
    }
  }
}

void ObjectTracks::shareJoint(const std::vector<MergedPoint>& points, std::vector<Shown>& shown,
                              std::vector<int>& of) const {
  for (std::size_t t = 0; t < of.size(); ++t) {
    const Track& lacking = tracks_[t];
    for (std::size_t s = 0; s < of.size() && of[t] == kUnassigned && lacking.number != 0; ++s) {
      const auto g = static_cast<std::size_t>(of[s]);
      if (of[s] == kUnassigned || !isBeyond(boxOf(shown[g].edges), boxOf(tracks_[s].axes)) ||
          !widened(boxOf(shown[g].edges), kAround).contains(middleOf(lacking.axes))) {
        continue;
      }
      Group first;
      Group second;
      for (const std::uint32_t i : shown[g].points) {
        const bool nearer = off(points[i], lacking.axes) < off(points[i], tracks_[s].axes);
        (nearer ? second : first).push_back(i);
      }
      if (std::min(first.size(), second.size()) >= kLeastShare) {
        shown[g] = shownBy(points, std::move(first));
        of[t] = static_cast<int>(shown.size());
        shown.push_back(shownBy(points, std::move(second)));
      }
    }
  }
}

void ObjectTracks::show(Track& track, const std::vector<MergedPoint>& points, Shown& shown, StampNs stamp_ns) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    track.axes[axis].update(shown.edges[axis]);
  }
  note(track, points, shown, stamp_ns);
  track.history |= 1U;
  if (track.number == 0 && isBelieved(track)) {
    track.number = newNumber();
  }
  for (const std::uint32_t i : shown.points) {
    owned_.emplace_back(i, track.number);
  }
  shown.points.clear();
}

void ObjectTracks::note(Track& track, const std::vector<MergedPoint>& points, const Shown& shown, StampNs stamp_ns) {
  track.last_ns = stamp_ns;
  track.cameras |= shown.cameras;
  track.gone_sets = 0;
  track.covered_ns = -1;
  track.at_border = isAtBorder(shown.edges);
  track.hidden = false;
  track.may_be_there = true;
  const Eigen::Vector3f middle = middleOf(track.axes).cast<float>();
  const auto sample = [&](std::size_t most, std::vector<Eigen::Vector3f>& out) {
    out.clear();
    const std::size_t step = 1 + shown.points.size() / most;
    for (std::size_t i = 0; i < shown.points.size(); i += step) {
      out.push_back(pointOf(points[shown.points[i]]) - middle);
    }
  };
  sample(kMostPlaces, track.surface);
  const auto view = static_cast<double>(shown.points.size());
  track.fullest = std::max(view, kFades * track.fullest);
  if (view >= kFullView * track.fullest) {
    sample(kMostOfBody, track.body);
  }
}

ObjectTracks::Look ObjectTracks::look(const Track& track, const Axes& axes) const {
  const Eigen::Vector3f middle = middleOf(axes).cast<float>();
  std::vector<Eigen::Vector3f> inside;
  for (const Eigen::Vector3f& p : track.surface) {
    const Eigen::Vector3d place = (middle + p).cast<double>();
    if (params_.grid.indexOf(place.x(), place.y(), place.z()) >= 0) {
      inside.push_back(middle + p);
    }
  }
  if (2 * inside.size() < track.surface.size()) {
    return Look::kOutside;
  }
  const auto through = static_cast<std::size_t>(sightlines_.seenThrough(inside, track.cameras));
  return 2 * through > inside.size() ? Look::kFree : Look::kNotSeen;
}

void ObjectTracks::miss(Track& track, const Axes& before, StampNs stamp_ns) const {
  const Eigen::Vector3d middle = middleOf(track.axes);
  const bool covered = std::any_of(tracks_.begin(), tracks_.end(), [&](const Track& other) {
    return other.number != 0 && other.last_ns == stamp_ns && boxOf(other.axes).contains(middle);
  });
  track.covered_ns = !covered ? -1 : track.covered_ns < 0 ? stamp_ns : track.covered_ns;
  const Look place = look(track, track.axes);
  const bool still_there = place == Look::kFree && look(track, before) == Look::kNotSeen;
  const bool may_be_there = place == Look::kNotSeen || still_there;
  track.may_be_there = may_be_there;
  track.gone_sets = may_be_there ? 0 : track.gone_sets + 1;
  track.hidden = may_be_there || track.at_border;
  const bool stands =
      std::hypot(track.axes[0].velocity(), track.axes[1].velocity(), track.axes[2].velocity()) < kStands;
  if (still_there || (track.at_border && !may_be_there) || (may_be_there && stands)) {
    track.axes = before;
    std::for_each(track.axes.begin(), track.axes.end(), [](AxisFilter& axis) { axis.stand(); });
  }
}

bool ObjectTracks::isBelieved(const Track& track) const {
  const std::uint32_t window = (1U << static_cast<unsigned>(params_.unknown_window)) - 1U;
  return __builtin_popcount(track.history & window) >= params_.unknown_hits;
}

bool ObjectTracks::ends(const Track& track) const {
  if (track.number == 0) {
    const std::uint32_t window = (1U << static_cast<unsigned>(params_.unknown_window)) - 1U;
    return (track.history & window) == 0;
  }
  const bool gone = track.gone_sets >= kGoneSets && (!track.at_border || stamp_ns_ - track.last_ns >= kOutside);
  return gone || (track.covered_ns >= 0 && stamp_ns_ - track.covered_ns >= kCovered);
}

void ObjectTracks::bear(const std::vector<MergedPoint>& points, const Shown& shown, StampNs stamp_ns) {
  if (tracks_.size() >= kMostTracks) {
    const auto oldest = std::min_element(tracks_.begin(), tracks_.end(),
                                         [](const Track& a, const Track& b) { return a.last_ns < b.last_ns; });
    if (oldest->last_ns == stamp_ns) {
      return;
    }
    tracks_.erase(oldest);
  }
  const Axes axes{AxisFilter(shown.edges[0]), AxisFilter(shown.edges[1]), AxisFilter(shown.edges[2])};
  Track track{0, 1U, axes, stamp_ns, stamp_ns, 0, {}, {}, 0.0, true, 0, -1, false, false};
  note(track, points, shown, stamp_ns);
  tracks_.push_back(std::move(track));
}

void ObjectTracks::update(StampNs stamp_ns, const std::vector<MergedPoint>& points, const std::vector<char>& explained,
                          const std::vector<std::int32_t>& absent, const std::vector<Group>& groups) {
  const double dt = std::clamp(1e-9 * static_cast<double>(stamp_ns - stamp_ns_), 0.0, kLongestStep);
  stamp_ns_ = stamp_ns;
  sightlines_.take(points, absent, explained);
  std::vector<Axes> before;
  for (Track& track : tracks_) {
    before.push_back(track.axes);
    std::for_each(track.axes.begin(), track.axes.end(), [dt](AxisFilter& axis) { axis.predict(dt); });
  }
  std::vector<Shown> shown;
  std::transform(groups.begin(), groups.end(), std::back_inserter(shown),
                 [&](const Group& group) { return shownBy(points, group); });
  joinAtBorder(points, shown);
  const std::vector<int> of = bringTogether(points, shown);
  owned_.clear();
  for (std::size_t t = 0; t < of.size(); ++t) {
    tracks_[t].history <<= 1U;
    if (of[t] != kUnassigned) {
      show(tracks_[t], points, shown[static_cast<std::size_t>(of[t])], stamp_ns);
    }
  }
  for (std::size_t t = 0; t < of.size(); ++t) {
    if (of[t] == kUnassigned) {
      miss(tracks_[t], before[t], stamp_ns);
    }
  }
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(), [this](const Track& track) { return ends(track); }),
                tracks_.end());
  for (const Shown& left : shown) {
    if (!left.points.empty()) {
      bear(points, left, stamp_ns);
    }
  }
  std::sort(owned_.begin(), owned_.end());
  writeBelieved();
}

bool ObjectTracks::isMostly(const Track& track, const std::function<bool(const Eigen::Vector3f&)>& known) {
  const Eigen::Vector3f middle = middleOf(track.axes).cast<float>();
  const auto yes = std::count_if(track.surface.begin(), track.surface.end(),
                                 [&](const Eigen::Vector3f& p) { return known(middle + p); });
  return 2 * static_cast<std::size_t>(yes) > track.surface.size();
}

void ObjectTracks::dissolve(const std::function<bool(const Eigen::Vector3f&)>& explained) {
  const auto is_explained = [&](const Track& track) { return (track.history & 1U) == 0 && isMostly(track, explained); };
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(), is_explained), tracks_.end());
}

void ObjectTracks::forget(const std::function<bool(const Eigen::Vector3f&)>& known) {
  tracks_.erase(
      std::remove_if(tracks_.begin(), tracks_.end(), [&](const Track& track) { return isMostly(track, known); }),
      tracks_.end());
  writeBelieved();
}

std::vector<ObjectTracks::Place> ObjectTracks::placesBut(const std::set<int>& numbers,
                                                         const std::vector<MergedPoint>& points) const {
  std::vector<Place> places;
  for (const Track& track : tracks_) {
    if (track.number == 0 || !track.may_be_there || numbers.count(track.number) > 0) {
      continue;
    }
    Place place{track.number, {}, {}};
    for (const auto& [point, number] : owned_) {
      if (number == track.number) {
        place.source.push_back(point);
        place.points.push_back(pointOf(points[point]));
      }
    }
    if (place.source.empty()) {
      const Eigen::Vector3f middle = middleOf(track.axes).cast<float>();
      std::transform(track.body.begin(), track.body.end(), std::back_inserter(place.points),
                     [&](const Eigen::Vector3f& p) { return middle + p; });
    }
    places.push_back(std::move(place));
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.number < b.number; });
  return places;
}

int ObjectTracks::numberOf(const Group& points) const {
  std::map<int, std::size_t> votes;
  for (const std::uint32_t i : points) {
    const auto owned = std::lower_bound(owned_.begin(), owned_.end(), std::make_pair(i, 0));
    if (owned != owned_.end() && owned->first == i && owned->second != 0) {
      ++votes[owned->second];
    }
  }
  const auto most =
      std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == votes.end() ? 0 : most->first;
}

void ObjectTracks::writeBelieved() {
  believed_.clear();
  for (const Track& track : tracks_) {
    if (track.number == 0) {
      continue;
    }
    TrackedObject out;
    out.number = track.number;
    out.position = middleOf(track.axes);
    out.extent = boxOf(track.axes).sizes();
    for (int axis = 0; axis < 3; ++axis) {
      const AxisFilter& filter = track.axes[static_cast<std::size_t>(axis)];
      const Eigen::Matrix2d both = filter.covariance();
      out.velocity[axis] = filter.velocity();
      out.covariance(axis, axis) = both(0, 0);
      out.covariance(axis, axis + 3) = out.covariance(axis + 3, axis) = both(0, 1);
      out.covariance(axis + 3, axis + 3) = both(1, 1);
    }
    out.first_seen_ns = track.first_ns;
    out.last_seen_ns = track.last_ns;
    out.hidden = track.hidden;
    believed_.push_back(out);
  }
  std::sort(believed_.begin(), believed_.end(),
            [](const TrackedObject& a, const TrackedObject& b) { return a.number < b.number; });
}

void ObjectTracks::reset() {
  tracks_.clear();
  believed_.clear();
  owned_.clear();
}

}  // namespace yarm::perception
