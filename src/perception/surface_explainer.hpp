// Whose surface does a point lie on: known shapes first, then what was learnt in calibration.
#pragma once

#include "yarm/perception/association.hpp"

#include "present_set.hpp"
#include "scene_model.hpp"

#include <vector>

namespace yarm::perception {

/// Gives points to the objects on whose surfaces they lie. Keeps its buffers: one instance an association.
class SurfaceExplainer {
 public:
  explicit SurfaceExplainer(const AssociationParams& params) : params_(params), model_(params) {}

  /// Fills owner and placed of the points that a known or learnt surface explains; the others are kNobody's.
  void explain(PresentSet& set);
  /// The known solids at their poses in the set that was explained last.
  [[nodiscard]] const SceneModel& model() const { return model_; }

 private:
  void buildModel(const PresentSet& set);
  /// Known surfaces explain their points; what rises above a static one near a loose thing of unknown shape is that
  /// thing's.
  void explainByShapes(PresentSet& set);
  /// Surfaces learnt in calibration explain what no known shape does.
  void explainByLearned(PresentSet& set) const;
  [[nodiscard]] int looseThingAt(const PresentSet& set, std::size_t point, const Explanation& why) const;

  AssociationParams params_;
  SceneModel model_;
  std::vector<int> loose_;  // debris of unknown shape
};

}  // namespace yarm::perception
