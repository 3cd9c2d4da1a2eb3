#include "association_score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace yarm::test {

namespace {

constexpr double kContact = 0.05;  // bodies nearer than this are in contact, metres
constexpr float kVoxel = 0.12F;    // a cloud of centroids speaks for points this near, metres

/// Pairs that always rest on each other are not in contact for the score.
bool restsOn(const Body& a, const Body& b) {
  const auto pair = [&](pc::ObjectKind x, pc::ObjectKind y) {
    return (a.kind == x && b.kind == y) || (a.kind == y && b.kind == x);
  };
  return pair(pc::ObjectKind::kDebris, pc::ObjectKind::kObstacle) ||
         pair(pc::ObjectKind::kObstacle, pc::ObjectKind::kObstacle) ||
         (pair(pc::ObjectKind::kManipulator, pc::ObjectKind::kObstacle) && (a.name == "stand" || b.name == "stand"));
}

bool inContact(const Scene& scene, const Body& body) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const Body& other) {
    return other.name != body.name && !restsOn(body, other) &&
           std::min(clearance(scene, body, other), clearance(scene, other, body)) < kContact;
  });
}

std::vector<double> creditsBySource(const std::vector<int>& object_body, const ScoredSet& set) {
  std::vector<double> result(set.truth.size(), 0.0);
  for (std::size_t o = 0; o < set.result->objects.size(); ++o) {
    for (const std::uint32_t i : set.result->objects[o].source) {
      result[i] = object_body[o] == set.truth[i] ? 1.0 : 0.0;
    }
  }
  return result;
}

/// For clouds that are not points of this set: a point goes to whose cloud is nearest, shared when several are.
std::vector<double> creditsByDistance(const std::vector<int>& object_body, const ScoredSet& set) {
  std::vector<double> result(set.truth.size(), 0.0);
  const std::size_t n = set.result->objects.size();
  std::vector<float> distance(n);
  for (std::size_t i = 0; i < set.truth.size(); ++i) {
    const Eigen::Vector3f p = set.merged->centroids[static_cast<std::size_t>(set.merged->voxel_of_point[i])];
    for (std::size_t o = 0; o < n; ++o) {
      distance[o] = std::numeric_limits<float>::infinity();
      for (const Eigen::Vector3f& q : set.result->objects[o].points) {
        distance[o] = std::min(distance[o], (p - q).squaredNorm());
      }
    }
    const float least = *std::min_element(distance.begin(), distance.end());
    int winners = 0;
    bool right = false;
    for (std::size_t o = 0; o < n && least < kVoxel * kVoxel; ++o) {
      if (distance[o] <= least + 1e-8F) {
        ++winners;
        right = right || object_body[o] == set.truth[i];
      }
    }
    result[i] = right ? 1.0 / winners : 0.0;
  }
  return result;
}

}  // namespace

double Score::mean(const std::map<std::string, Mean>& by_object) {
  Mean total;
  for (const auto& [name, mean] : by_object) {
    total.add(mean.value());
  }
  return total.value();
}

std::vector<double> credits(const Scene& scene, const ScoredSet& set) {
  std::vector<int> object_body;
  bool has_source = false;
  for (const pc::AssociatedObject& o : set.result->objects) {
    object_body.push_back(scene.indexOf(o.name));
    has_source = has_source || !o.source.empty();
  }
  return has_source ? creditsBySource(object_body, set) : creditsByDistance(object_body, set);
}

AssociationRun::AssociationRun(const std::string& associator, std::uint64_t seed, const Errors& errors)
    : factory_(seed),
      backend_(pc::makeBackend("fused", {}, {})),
      associator_(pc::makeAssociator(associator, {})),
      builder_(pc::GridSpec{}),
      errors_(errors),
      random_(seed) {
  factory_.spoil(errors.cameras);
}

Errors Errors::ofPoses(double metres) {
  Errors errors;
  errors.pose_m = metres;
  errors.turn_rad = 0.5 * metres;
  return errors;
}

void AssociationRun::blur(Scene& told) {
  std::normal_distribution<double> error(0.0, 1.0);
  for (const Body& body : told.bodies) {
    if (body.is_static) {
      continue;
    }
    const Eigen::Isometry3d T_world_seed = told.poses.at(body.seed_frame);
    const double x_m = errors_.pose_m * error(random_);
    const double y_m = errors_.pose_m * error(random_);
    Eigen::Isometry3d off = pose(x_m, y_m, 0.0, errors_.turn_rad * error(random_));
    off.translation().z() = errors_.pose_m * error(random_);
    const Eigen::Isometry3d change = T_world_seed * off * T_world_seed.inverse();
    for (const std::string& frame : body.link_frames) {
      told.poses[frame] = change * told.poses[frame];
    }
  }
}

void AssociationRun::enlarge(Scene& told) const {
  for (Body& body : told.bodies) {
    for (pc::Solid& solid : body.solids) {
      solid.size *= body.is_static ? 1.0 : 1.0 + errors_.shape;
    }
  }
}

void AssociationRun::hold(Scene& told) {
  std::normal_distribution<double> jitter(0.0, errors_.jitter_m);
  const pc::LinkPoses now = told.poses;
  for (const Body& body : told.bodies) {
    const double lag_m = std::max(0.0, errors_.lag_m + (errors_.jitter_m > 0.0 ? jitter(random_) : 0.0));
    const auto last = before_.find(body.seed_frame);
    if (body.is_static || last == before_.end()) {
      continue;
    }
    const double way_m = (now.at(body.seed_frame).translation() - last->second.translation()).norm();
    const double share = way_m > 0.0 ? std::min(1.0, lag_m / way_m) : 0.0;
    for (const std::string& frame : body.link_frames) {
      const Eigen::Isometry3d& a = now.at(frame);
      const Eigen::Isometry3d& b = before_.at(frame);
      Eigen::Isometry3d& between = told.poses[frame];
      between.translation() = a.translation() + share * (b.translation() - a.translation());
      between.linear() = Eigen::Quaterniond(a.linear()).slerp(share, Eigen::Quaterniond(b.linear())).toRotationMatrix();
    }
  }
  before_ = now;
}

ScoredSet AssociationRun::step(const Scene& scene, bool calibrating) {
  stamp_ += 33333333;
  const std::vector<Render>& renders = factory_.render(scene);
  backend_->merge(factory_.clouds(stamp_), set_);
  backend_->cluster(set_);
  Scene told = scene;
  if (errors_.lag_m > 0.0 || errors_.jitter_m > 0.0) {
    hold(told);
  }
  if (errors_.pose_m > 0.0 || errors_.turn_rad > 0.0) {
    blur(told);
  }
  if (errors_.shape > 0.0) {
    enlarge(told);
  }
  const auto seeds = told.seeds(stamp_);
  const auto knowledge = told.knowledge();
  ScoredSet out;
  out.merged = &set_;
  out.renders = &renders;
  out.truth = factory_.truthOf(set_);
  out.result = &associator_->associate({&set_, &seeds, &knowledge, &told.poses, calibrating});
  out.grid = &builder_.build(*out.result);
  out.calibrating = calibrating;
  return out;
}

Score AssociationRun::run(const Sequence& sequence, const std::function<void(const Scene&, const ScoredSet&)>& look) {
  Score score;
  Scene scene = sequence.scene;
  std::map<std::string, int> gap;
  int phantom_run = 0;
  for (int k = -kCalibrationSets; k < sequence.sets; ++k) {
    if (k >= 0) {
      sequence.at(scene, k);
    }
    ScoredSet set = step(scene, k < 0);
    set.k = k;
    if (look) {
      look(scene, set);
    }
    if (k < 0) {
      continue;
    }
    const std::vector<double> credit = credits(scene, set);
    bool stranger_there = false;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      const Body& body = scene.bodies[b];
      stranger_there = stranger_there || !body.registered;
      Mean share;
      for (std::size_t i = 0; i < credit.size(); ++i) {
        if (set.truth[i] == static_cast<int>(b)) {
          share.add(credit[i]);
        }
      }
      if (!body.registered || share.count == 0) {
        continue;
      }
      (inContact(scene, body) ? score.contact : score.apart)[sequence.name + "/" + body.name].add(share.value());
      const auto at = std::find_if(set.result->objects.begin(), set.result->objects.end(),
                                   [&](const pc::AssociatedObject& o) { return o.name == body.name; });
      const bool mapped = at != set.result->objects.end() &&
                          !set.grid->object_cells[static_cast<std::size_t>(at - set.result->objects.begin())].empty();
      gap[body.name] = mapped ? 0 : gap[body.name] + 1;
      score.longest_gap = std::max(score.longest_gap, gap[body.name]);
    }
    const bool unknown = std::any_of(set.result->objects.begin(), set.result->objects.end(),
                                     [](const pc::AssociatedObject& o) { return o.is_unknown; });
    phantom_run = unknown && !stranger_there ? phantom_run + 1 : 0;
    score.phantom_sets += phantom_run > 0 ? 1 : 0;
    score.longest_phantom = std::max(score.longest_phantom, phantom_run);
  }
  return score;
}

namespace {

/// The course with the shapes of some bodies unknown.
Sequence without(Sequence sequence, const std::function<bool(const Body&)>& unknown) {
  const auto forget = [unknown](Scene& scene) {
    for (Body& body : scene.bodies) {
      body.shape_known = !unknown(body);
    }
  };
  forget(sequence.scene);
  sequence.at = [inner = sequence.at, forget](Scene& scene, int k) {
    inner(scene, k);
    forget(scene);
  };
  return sequence;
}

}  // namespace

Sequence withoutShapes(Sequence sequence) {
  return without(std::move(sequence), [](const Body& body) { return !body.is_static; });
}

Sequence withoutRobotShapes(Sequence sequence) {
  return without(std::move(sequence), [](const Body& body) { return body.kind == pc::ObjectKind::kMobile; });
}

}  // namespace yarm::test
