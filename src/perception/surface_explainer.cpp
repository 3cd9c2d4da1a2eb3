#include "surface_explainer.hpp"

#include <algorithm>

namespace yarm::perception {

namespace {

constexpr float kSnap = 0.005F;      // how far off a known surface an explained point is left, metres
constexpr float kRiseSigmas = 1.5F;  // points this far above a surface near a loose thing's seed are the loose thing's
constexpr float kRise = 0.012F;      // and at least this far, metres

}  // namespace

void SurfaceExplainer::explain(PresentSet& set) {
  buildModel(set);
  explainByShapes(set);
  explainByLearned(set);
}

void SurfaceExplainer::buildModel(const PresentSet& set) {
  model_.clear();
  for (int i = 0; i < set.objectCount(); ++i) {
    for (const Solid& solid : set.object(i).solids()) {
      const auto T = set.object(i).isTarget() ? std::nullopt : set.object(i).poseOf(solid.frame);
      if (T) {
        model_.add(i, solid, *T * solid.T_frame_solid);
      }
    }
  }
  model_.index();
}

void SurfaceExplainer::explainByShapes(PresentSet& set) {
  loose_.clear();
  for (int i = 0; i < set.objectCount(); ++i) {
    if (set.object(i).seed().object == ObjectKind::kDebris && !set.object(i).hasShape()) {
      loose_.push_back(i);
    }
  }
  set.owner.assign(set.points->size(), kNobody);
  set.placed.resize(set.points->size());
  const std::vector<Explanation>& explained = model_.explain(*set.points);
  for (std::size_t i = 0; i < set.points->size(); ++i) {
    const Explanation& why = explained[i];
    set.placed[i] = set.seenAt(i);
    if (why.piece < 0) {
      continue;
    }
    set.owner[i] = why.object;
    const int loose = looseThingAt(set, i, why);
    if (loose != kNobody) {
      set.owner[i] = loose;
      continue;
    }
    set.placed[i] -= why.normal * (why.distance - std::clamp(why.distance, -kSnap, kSnap));
  }
}

int SurfaceExplainer::looseThingAt(const PresentSet& set, std::size_t point, const Explanation& why) const {
  int best = kNobody;
  float best_distance = kDebrisReach;
  if (loose_.empty() || why.distance < kRise) {
    return best;
  }
  for (const int i : loose_) {
    const Seed& seed = set.object(i).seed();
    const float d = (seed.T_world_seed.translation().cast<float>() - set.seenAt(point)).norm();
    if (d < best_distance && set.object(why.object).seed().is_static &&
        model_.sigmasAbove((*set.points)[point], why) > kRiseSigmas) {
      best = i;
      best_distance = d;
    }
  }
  return best;
}

void SurfaceExplainer::explainByLearned(PresentSet& set) const {
  std::vector<int> learners;
  for (int i = 0; i < set.objectCount(); ++i) {
    if (set.object(i).hasLearned()) {
      learners.push_back(i);
    }
  }
  const auto spacing = static_cast<float>(params_.cloud_spacing);
  for (std::size_t i = 0; i < set.points->size() && !learners.empty(); ++i) {
    if (set.owner[i] != kNobody) {
      continue;
    }
    float best = spacing + std::min(2.F * (*set.points)[i].sigma, spacing);
    for (const int l : learners) {
      const float d = set.object(l).learnedDistance(set.seenAt(i));
      if (d < best) {
        best = d;
        set.owner[i] = l;
      }
    }
  }
}

}  // namespace yarm::perception
