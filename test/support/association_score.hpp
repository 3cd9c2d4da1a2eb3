// Scores an association against the truth over sequences of synthetic sets.
#pragma once

#include "scene_factory.hpp"

#include "yarm/perception/merge.hpp"
#include "yarm/perception/occupancy.hpp"

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace yarm::test {

/// A scripted course of a scene: calibration first, then `sets` sets of which `at` brings the scene to set k (from 0).
struct Sequence {
  std::string name;
  Scene scene;
  int sets{0};
  std::function<void(Scene&, int)> at;
};

/// Mean of a quantity.
struct Mean {
  double sum{0.0};
  int count{0};
  void add(double value) {
    sum += value;
    ++count;
  }
  [[nodiscard]] double value() const { return count > 0 ? sum / count : 1.0; }
};

/// Share of points given to the right object, by object, for sets in which it is apart from or in contact with others.
struct Score {
  std::map<std::string, Mean> apart;
  std::map<std::string, Mean> contact;
  int longest_gap{0};      ///< most sets in a row in which a visible object had no cells
  int phantom_sets{0};     ///< sets with an unknown thing where nothing unregistered is
  int longest_phantom{0};  ///< most of them in a row

  [[nodiscard]] static double mean(const std::map<std::string, Mean>& by_object);
};

/// One set as an association saw it.
struct ScoredSet {
  const pc::MergedSet* merged{nullptr};
  std::vector<int> truth;  ///< body of each point
  const pc::AssociatedSet* result{nullptr};
  const pc::OccupancyGrid* grid{nullptr};
  const std::vector<Render>* renders{nullptr};
  bool calibrating{false};
  int k{0};  ///< set after calibration
};

/// What perception is told wrongly; nothing, unless said. Each is of moving bodies, or of the cameras.
struct Errors {
  double pose_m{0.0};    ///< standard deviation of a body's place along each axis, fresh for every set, metres
  double turn_rad{0.0};  ///< and of its heading
  double shape{0.0};     ///< known solids are larger by this share of their size
  double lag_m{0.0};     ///< told poses lag behind by this much of the way, metres: stamps that are late
  double jitter_m{0.0};  ///< and by a normal number of this deviation more
  CameraErrors cameras;

  /// Places off by so much, and headings by 0.5 rad for each metre of it.
  [[nodiscard]] static Errors ofPoses(double metres);
};

/// Feeds sequences through merge, association and grid, always the same way.
class AssociationRun {
 public:
  AssociationRun(const std::string& associator, std::uint64_t seed, const Errors& errors = {});

  /// Runs a sequence; `look` is called with every set.
  Score run(const Sequence& sequence, const std::function<void(const Scene&, const ScoredSet&)>& look = {});

  static constexpr int kCalibrationSets = 5;

 private:
  ScoredSet step(const Scene& scene, bool calibrating);
  void blur(Scene& told);
  void enlarge(Scene& told) const;
  void hold(Scene& told);

  SceneFactory factory_;
  std::unique_ptr<pc::MergeBackend> backend_;
  std::unique_ptr<pc::Associator> associator_;
  pc::OccupancyBuilder builder_;
  pc::MergedSet set_;
  pc::StampNs stamp_{0};
  Errors errors_;
  pc::LinkPoses before_;  // of the set before
  std::mt19937_64 random_;
};

/// Share (0 to 1) to which a point was given to the object `name`: 1 when it alone has it.
[[nodiscard]] std::vector<double> credits(const Scene& scene, const ScoredSet& set);

/// The map against the bodies themselves.
struct MapScore {
  int visible_cells{0};  ///< cells that three or more noise-free rays of the set end in
  int missed{0};         ///< of those, neither marked nor with a marked neighbour that shares a face
  int marked_cells{0};   ///< cells marked occupied
  int phantom{0};        ///< of those, with no body in the cell or one next to it (corners too)
};
[[nodiscard]] MapScore scoreMap(const Scene& scene, const ScoredSet& set);

/// The sequences everything is scored on.
[[nodiscard]] std::vector<Sequence> scoredSequences();

/// The same course with the shapes of the moving bodies unknown to the registry.
[[nodiscard]] Sequence withoutShapes(Sequence sequence);
/// And with those of the mobile robots alone unknown.
[[nodiscard]] Sequence withoutRobotShapes(Sequence sequence);

}  // namespace yarm::test
