#include "associators.hpp"
#include "euclidean.hpp"
#include "object_memory.hpp"
#include "scene_model.hpp"
#include "unknown_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace yarm::perception {

namespace {

constexpr int kNobody = -1;
constexpr float kSnap = 0.005F;        // how far off a known surface an explained point is left, metres
constexpr float kDebrisReach = 0.13F;  // a loose thing of unknown shape reaches this far from its seed, metres
constexpr float kRiseSigmas = 1.5F;    // points this far above a surface near such a seed are the loose thing's
constexpr float kRise = 0.012F;        // and at least this far, metres

constexpr float kFloorSigmas = 5.5F;  // what no body explains is the floor's up to this many sigmas of its noise

/// True for a point that the floor's noise may have lifted.
bool isFloorNoise(const MergedPoint& p) {
  return p.z < kFloorSigmas * p.sigma * std::abs(p.uz);
}

Eigen::Vector3f positionOf(const MergedPoint& p) {
  return {p.x, p.y, p.z};
}

class YarmAssociator : public Associator {
 public:
  explicit YarmAssociator(const AssociationParams& params)
      : params_(params),
        model_(params),
        components_(lowOf(params.grid), highOf(params.grid), reach()),
        unknown_(params) {}

  const AssociatedSet& associate(const AssociationInput& input) override {
    ++set_number_;
    points_ = &input.set->points;
    calibrating_ = input.calibrating;
    takeObjects(input);
    buildModel();
    explainByShapes();
    explainByLearned();
    shareRemainder();
    writeResult(input.set->stamp_ns);
    return result_;
  }

  void reset() override {
    memory_.clear();
    attached_.clear();
    unknown_.reset();
    result_ = {};
  }

 private:
  static Eigen::Vector3f lowOf(const GridSpec& g) {
    return Eigen::Vector3d(g.min[0], g.min[1], g.min[2]).cast<float>();
  }
  static Eigen::Vector3f highOf(const GridSpec& g) {
    return Eigen::Vector3d(g.max[0], g.max[1], g.max[2]).cast<float>();
  }
  [[nodiscard]] float reach() const { return static_cast<float>(params_.search_radius); }
  [[nodiscard]] int objectCount() const { return static_cast<int>(objects_.size()); }
  [[nodiscard]] ObjectMemory& object(int i) { return *objects_[static_cast<std::size_t>(i)]; }

  /// Brings the memory up to the seeds present now: what is no longer registered is forgotten.
  void takeObjects(const AssociationInput& input) {
    std::unordered_map<std::string, std::unique_ptr<ObjectMemory>> kept;
    objects_.clear();
    for (const Seed& seed : *input.seeds) {
      auto old = memory_.find(seed.name);
      auto& slot = kept[seed.name];
      if (slot == nullptr) {
        slot = old != memory_.end() ? std::move(old->second) : std::make_unique<ObjectMemory>();
      }
      const auto known = input.knowledge->find(seed.name);
      slot->refresh(seed, known != input.knowledge->end() ? &known->second : nullptr, *input.links);
      objects_.push_back(slot.get());
    }
    memory_ = std::move(kept);
  }

  void buildModel() {
    model_.clear();
    robots_.assign(objects_.size(), 0);
    registered_.assign(objects_.size(), 0);
    for (int i = 0; i < objectCount(); ++i) {
      robots_[static_cast<std::size_t>(i)] = object(i).isRobot() ? 1 : 0;
      registered_[static_cast<std::size_t>(i)] = object(i).isTarget() ? 0 : 1;
      for (const Solid& solid : object(i).solids()) {
        Eigen::Isometry3d T;
        if (!object(i).isTarget() && object(i).poseOf(solid.frame, T)) {
          model_.add(i, solid, T * solid.T_frame_solid);
        }
      }
    }
    model_.index();
  }

  /// Known surfaces explain their points; what rises above a static one near a loose thing of unknown shape is that
  /// thing's.
  void explainByShapes() {
    loose_.clear();
    for (int i = 0; i < objectCount(); ++i) {
      if (object(i).seed().object == ObjectKind::kDebris && !object(i).hasShape()) {
        loose_.push_back(i);
      }
    }
    owner_.assign(points_->size(), kNobody);
    placed_.resize(points_->size());
    model_.explain(*points_, explained_);
    for (std::size_t i = 0; i < points_->size(); ++i) {
      const MergedPoint& point = (*points_)[i];
      const Explanation& why = explained_[i];
      placed_[i] = positionOf(point);
      if (why.piece < 0) {
        continue;
      }
      owner_[i] = why.object;
      const int loose = looseThingAt(point, why);
      if (loose != kNobody) {
        owner_[i] = loose;
        continue;
      }
      placed_[i] -= why.normal * (why.distance - std::clamp(why.distance, -kSnap, kSnap));
    }
  }

  [[nodiscard]] int looseThingAt(const MergedPoint& point, const Explanation& why) {
    int best = kNobody;
    float best_distance = kDebrisReach;
    if (loose_.empty() || why.distance < kRise) {
      return best;
    }
    for (const int i : loose_) {
      const Seed& seed = object(i).seed();
      const float d = (seed.T_world_seed.translation().cast<float>() - positionOf(point)).norm();
      if (d < best_distance && object(why.object).seed().is_static && model_.sigmasAbove(point, why) > kRiseSigmas) {
        best = i;
        best_distance = d;
      }
    }
    return best;
  }

  /// Surfaces learnt in calibration explain what no known shape does.
  void explainByLearned() {
    std::vector<int> learners;
    for (int i = 0; i < objectCount(); ++i) {
      if (object(i).hasLearned()) {
        learners.push_back(i);
      }
    }
    for (std::size_t i = 0; i < points_->size() && !learners.empty(); ++i) {
      if (owner_[i] != kNobody) {
        continue;
      }
      const MergedPoint& point = (*points_)[i];
      const auto spacing = static_cast<float>(params_.cloud_spacing);
      float best = spacing + std::min(2.F * point.sigma, spacing);
      for (const int l : learners) {
        const float d = object(l).learnedDistance(positionOf(point));
        if (d < best) {
          best = d;
          owner_[i] = l;
        }
      }
    }
  }

  /// What no surface explains is shared out by connected groups.
  void shareRemainder() {
    rest_.clear();
    rest_points_.clear();
    for (std::size_t i = 0; i < points_->size(); ++i) {
      if (owner_[i] == kNobody && !isFloorNoise((*points_)[i])) {
        rest_.push_back(static_cast<std::uint32_t>(i));
        rest_points_.push_back(positionOf((*points_)[i]));
      }
    }
    std::vector<std::vector<std::uint32_t>> groups(
        static_cast<std::size_t>(components_.label(rest_points_, rest_labels_)));
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      groups[static_cast<std::size_t>(rest_labels_[i])].push_back(rest_[i]);
    }
    std::vector<std::vector<std::uint32_t>> strangers;
    for (const auto& group : groups) {
      shareGroup(group, strangers);
    }
    unknown_.update(*points_, strangers);
    if (calibrating_) {
      learn();
    }
  }

  /// Objects without a known shape that a group of points belongs to, then robots nearby, then nobody.
  void shareGroup(const std::vector<std::uint32_t>& group, std::vector<std::vector<std::uint32_t>>& strangers) {
    const std::vector<int> claimants = shapelessNear(group);
    if (!claimants.empty()) {
      for (const std::uint32_t i : group) {
        owner_[i] = nearestOf(claimants, placed_[i]);
      }
    }
    std::vector<std::uint32_t> left;
    const std::vector<char>& hosts = calibrating_ ? registered_ : robots_;
    for (const std::uint32_t i : group) {
      if (owner_[i] != kNobody) {
        continue;
      }
      const bool stranger = unknown_.covers(placed_[i], reach() / 2);
      owner_[i] = stranger ? kNobody : hostOf(placed_[i], hosts);
      if (owner_[i] == kNobody) {
        left.push_back(i);
      }
    }
    if (static_cast<int>(left.size()) >= params_.unknown_min_points) {
      strangers.push_back(left);
    }
  }

  /// The object (of those marked) whose body comes within reach of a point.
  [[nodiscard]] int hostOf(const Eigen::Vector3f& point, const std::vector<char>& hosts) {
    const Explanation near = model_.nearest(point, hosts, reach());
    int best = near.object;
    float best_distance = near.distance;
    for (int i = 0; i < objectCount(); ++i) {
      if (hosts[static_cast<std::size_t>(i)] != 0 && !object(i).hasShape()) {
        const float d = distanceTo(i, point);
        if (d < best_distance) {
          best = i;
          best_distance = d;
        }
      }
    }
    return best;
  }

  /// Distance of a point to what stands for an object without a known shape: its last good view, its seed.
  [[nodiscard]] float distanceTo(int i, const Eigen::Vector3f& point) {
    const float seed = (object(i).seed().T_world_seed.translation().cast<float>() - point).norm();
    return std::min({seed, object(i).recentDistance(point), object(i).learnedDistance(point)});
  }

  [[nodiscard]] std::vector<int> shapelessNear(const std::vector<std::uint32_t>& group) {
    std::vector<int> result;
    for (int i = 0; i < objectCount(); ++i) {
      if (object(i).hasShape() || object(i).isTarget() ||
          (!calibrating_ && object(i).seed().is_static && object(i).hasLearned())) {
        continue;
      }
      const bool hit =
          std::any_of(group.begin(), group.end(), [&](std::uint32_t p) { return distanceTo(i, placed_[p]) < reach(); });
      if (hit) {
        result.push_back(i);
      }
    }
    return result;
  }

  [[nodiscard]] int nearestOf(const std::vector<int>& candidates, const Eigen::Vector3f& point) {
    int best = kNobody;
    float best_distance = std::numeric_limits<float>::infinity();
    for (const int i : candidates) {
      const float d = distanceTo(i, point);
      const bool loose = object(i).seed().object == ObjectKind::kDebris;
      if (d < best_distance && !(loose && d > kDebrisReach)) {
        best = i;
        best_distance = d;
      }
    }
    return best;
  }

  /// In calibration: what an object was given beyond its known shape becomes its learnt surface.
  void learn() {
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      const int owner = owner_[rest_[i]];
      if (owner != kNobody) {
        object(owner).learn(rest_points_[i], set_number_, params_);
      }
    }
    for (std::size_t i = 0; i < points_->size(); ++i) {
      if (owner_[i] != kNobody && !object(owner_[i]).hasShape()) {
        object(owner_[i]).learn(placed_[i], set_number_, params_);
      }
    }
  }

  void writeResult(StampNs stamp_ns) {
    result_.stamp_ns = stamp_ns;
    result_.objects.resize(objects_.size());
    for (int i = 0; i < objectCount(); ++i) {
      startObject(i, result_.objects[static_cast<std::size_t>(i)]);
    }
    for (std::size_t i = 0; i < points_->size(); ++i) {
      if (owner_[i] != kNobody) {
        AssociatedObject& out = result_.objects[static_cast<std::size_t>(owner_[i])];
        out.points.push_back(placed_[i]);
        out.source.push_back(static_cast<std::uint32_t>(i));
      }
    }
    for (int i = 0; i < objectCount(); ++i) {
      fillHidden(i, result_.objects[static_cast<std::size_t>(i)]);
    }
    fillInsides();
    if (calibrating_) {
      attach();
    }
    for (AssociatedObject& o : result_.objects) {
      o.attached_to = attached_[o.name];
    }
    writeUnknown(stamp_ns);
  }

  void startObject(int i, AssociatedObject& out) {
    const Seed& seed = object(i).seed();
    out.name = seed.name;
    out.object = seed.object;
    out.is_static = seed.is_static;
    out.T_world_seed = seed.T_world_seed;
    out.stamp_ns = seed.stamp_ns;
    out.points.clear();
    out.source.clear();
    out.hidden.clear();
  }

  void fillHidden(int i, AssociatedObject& out) {
    if (object(i).isTarget()) {
      return;
    }
    object(i).appendSurfaces(out.hidden);
    object(i).appendLearned(out.hidden);
    if (!object(i).hasShape() && !object(i).isArticulated()) {
      object(i).carryRecent(out.points, out.hidden);
    }
  }

  void fillInsides() {
    for (int piece = 0; piece < model_.pieces(); ++piece) {
      model_.cellsInside(piece, result_.objects[static_cast<std::size_t>(model_.objectOf(piece))].hidden);
    }
  }

  void writeUnknown(StampNs stamp_ns) {
    for (const UnknownThing* thing : unknown_.believed()) {
      AssociatedObject out;
      out.name = "unknown_" + std::to_string(thing->number);
      out.stamp_ns = stamp_ns;
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (const Eigen::Vector3f& p : thing->points) {
        sum += p;
      }
      out.T_world_seed.translation() = (sum / static_cast<float>(thing->points.size())).cast<double>();
      (thing->source.empty() ? out.hidden : out.points) = thing->points;
      out.source = thing->source;
      result_.objects.push_back(std::move(out));
    }
  }

  /// In calibration: what shares cells is bolted together or rests on one another. Mobile robots stand apart by then.
  void attach() {
    std::vector<std::vector<int>> cells(objects_.size());
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const AssociatedObject& o = result_.objects[i];
      for (const auto* cloud : {&o.points, &o.hidden}) {
        for (const Eigen::Vector3f& p : *cloud) {
          cells[i].push_back(params_.grid.indexOf(p.x(), p.y(), p.z()));
        }
      }
      std::sort(cells[i].begin(), cells[i].end());
      cells[i].erase(std::unique(cells[i].begin(), cells[i].end()), cells[i].end());
      cells[i].erase(cells[i].begin(), std::upper_bound(cells[i].begin(), cells[i].end(), -1));
    }
    for (std::size_t a = 0; a < objects_.size(); ++a) {
      for (std::size_t b = 0; b < objects_.size(); ++b) {
        const AssociatedObject& moving = result_.objects[a];
        if (moving.is_static || moving.object == ObjectKind::kMobile || !result_.objects[b].is_static) {
          continue;
        }
        std::vector<int> common;
        std::set_intersection(cells[a].begin(), cells[a].end(), cells[b].begin(), cells[b].end(),
                              std::back_inserter(common));
        auto& list = attached_[moving.name];
        if (!common.empty() && std::find(list.begin(), list.end(), result_.objects[b].name) == list.end()) {
          list.push_back(result_.objects[b].name);
        }
      }
    }
  }

  AssociationParams params_;
  SceneModel model_;
  EuclideanClusters components_;
  UnknownTracker unknown_;
  std::unordered_map<std::string, std::unique_ptr<ObjectMemory>> memory_;
  std::unordered_map<std::string, std::vector<std::string>> attached_;
  std::vector<ObjectMemory*> objects_;  // in the order of the seeds
  std::vector<char> robots_;
  std::vector<char> registered_;
  std::vector<int> loose_;  // debris of unknown shape
  const std::vector<MergedPoint>* points_{nullptr};
  bool calibrating_{false};
  std::int64_t set_number_{0};
  std::vector<Explanation> explained_;
  std::vector<int> owner_;               // object of each point
  std::vector<Eigen::Vector3f> placed_;  // each point with its noise off a known surface taken away
  std::vector<std::uint32_t> rest_;      // points no surface explains
  std::vector<Eigen::Vector3f> rest_points_;
  std::vector<std::int32_t> rest_labels_;
  AssociatedSet result_;
};

}  // namespace

std::unique_ptr<Associator> makeYarmAssociator(const AssociationParams& params) {
  return std::make_unique<YarmAssociator>(params);
}

}  // namespace yarm::perception
