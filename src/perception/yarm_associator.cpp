#include "associators.hpp"
#include "attachments.hpp"
#include "hands.hpp"
#include "object_memory.hpp"
#include "present_set.hpp"
#include "remainder.hpp"
#include "stray_debris.hpp"
#include "surface_explainer.hpp"
#include "yarm/perception/piece.hpp"

#include <unordered_map>

namespace yarm::perception {

namespace {

/// Known shapes and learnt surfaces first, then connectivity; the parts do the work, this keeps the objects' memory and
/// writes the result.
class YarmAssociator : public Associator {
 public:
  explicit YarmAssociator(const AssociationParams& params)
      : params_(params), surfaces_(params), remainder_(params), strays_(params) {}

  const AssociatedSet& associate(const AssociationInput& input) override {
    takeSet(input);
    takeObjects(input);
    surfaces_.explain(set_);
    remainder_.share(set_, surfaces_.model());
    strays_.update(set_, surfaces_.model());
    if (strays_.foundAny()) {
      remainder_.forget([this](const Eigen::Vector3f& p) { return strays_.foundAt(p); });
    }
    if (set_.calibrating) {
      learn();
    }
    static const std::set<std::string> kNobodyGrasps;
    writeResult(input.set->stamp_ns);
    const std::vector<Hands::Load>& loads = hands_.update(
        set_.objects, input.grasping != nullptr ? *input.grasping : kNobodyGrasps, input.set->stamp_ns, input.timely);
    giveLoads(loads);
    strays_.carry(set_, loads);
    return result_;
  }

  [[nodiscard]] const std::vector<TrackedObject>& tracks() const override { return remainder_.tracks().believed(); }

  void reset() override {
    memory_.clear();
    attachments_.reset();
    hands_.reset();
    remainder_.reset();
    strays_.reset();
    result_ = {};
  }

 private:
  [[nodiscard]] ObjectMemory& object(int i) const { return set_.object(i); }

  void takeSet(const AssociationInput& input) {
    ++set_.number;
    set_.points = &input.set->points;
    set_.absent = &input.set->absent;
    set_.stamp_ns = input.set->stamp_ns;
    set_.calibrating = input.calibrating;
  }

  /// Brings the memory up to the seeds present now: what is no longer registered is forgotten.
  void takeObjects(const AssociationInput& input) {
    std::unordered_map<std::string, std::unique_ptr<ObjectMemory>> kept;
    set_.objects.clear();
    set_.robots.clear();
    set_.solid.clear();
    for (const Seed& seed : *input.seeds) {
      auto old = memory_.find(seed.name);
      auto& slot = kept[seed.name];
      if (slot == nullptr) {
        slot = old != memory_.end() ? std::move(old->second) : std::make_unique<ObjectMemory>();
      }
      const auto known = input.knowledge->find(seed.name);
      slot->refresh(seed, known != input.knowledge->end() ? &known->second : nullptr, *input.links);
      set_.objects.push_back(slot.get());
      set_.robots.push_back(slot->isRobot() ? 1 : 0);
      set_.solid.push_back(slot->isTarget() ? 0 : 1);
    }
    memory_ = std::move(kept);
    strays_.join(set_, *input.links);
  }

  /// In calibration: what an object was given beyond its known shape becomes its learnt surface.
  void learn() {
    for (const std::uint32_t i : remainder_.rest()) {
      if (set_.owner[i] != kNobody) {
        object(set_.owner[i]).learn(set_.seenAt(i), set_.number, params_);
      }
    }
    for (std::size_t i = 0; i < set_.points->size(); ++i) {
      if (set_.owner[i] != kNobody && !object(set_.owner[i]).hasShape()) {
        object(set_.owner[i]).learn(set_.placed[i], set_.number, params_);
      }
    }
  }

  void writeResult(StampNs stamp_ns) {
    result_.stamp_ns = stamp_ns;
    result_.objects.resize(set_.objects.size());
    for (int i = 0; i < set_.objectCount(); ++i) {
      startObject(i, result_.objects[static_cast<std::size_t>(i)]);
    }
    for (std::size_t i = 0; i < set_.points->size(); ++i) {
      if (set_.owner[i] != kNobody) {
        AssociatedObject& out = result_.objects[static_cast<std::size_t>(set_.owner[i])];
        out.points.push_back(set_.placed[i]);
        out.source.push_back(static_cast<std::uint32_t>(i));
      }
    }
    for (int i = 0; i < set_.objectCount(); ++i) {
      AssociatedObject& out = result_.objects[static_cast<std::size_t>(i)];
      out.piece = viewOf(i, out);
      fillHidden(i, out);
    }
    fillInsides();
    if (set_.calibrating) {
      attachments_.learn(result_.objects, params_.grid);
    }
    for (AssociatedObject& o : result_.objects) {
      o.attached_to = attachments_.of(o.name);
    }
    writeUnknown(stamp_ns);
  }

  /// What is seen of a piece of debris in the set; empty for other objects, and when too little is.
  [[nodiscard]] std::optional<PieceView> viewOf(int i, const AssociatedObject& out) const {
    std::optional<PieceView> view = strays_.viewOf(i);
    if (!view && out.object == ObjectKind::kDebris) {
      view = pieceOf(seenOf(out));
    } else if (view) {
      view->points = out.source.size();
    }
    if (!view || view->points == 0) {
      return std::nullopt;
    }
    view->cameras = camerasOf(out);
    return view;
  }

  void startObject(int i, AssociatedObject& out) {
    const Seed& seed = object(i).seed();
    out.name = seed.name;
    out.object = seed.object;
    out.is_static = seed.is_static;
    out.is_unknown = false;
    out.T_world_seed = seed.T_world_seed;
    out.stamp_ns = seed.stamp_ns;
    out.points.clear();
    out.source.clear();
    out.hidden.clear();
    out.carried.reset();
  }

  /// What hangs on a hand is the robot's: its points, seen and hidden.
  void giveLoads(const std::vector<Hands::Load>& loads) {
    for (const Hands::Load& load : loads) {
      AssociatedObject& robot = result_.objects[static_cast<std::size_t>(load.robot)];
      AssociatedObject& piece = result_.objects[static_cast<std::size_t>(load.piece)];
      robot.points.insert(robot.points.end(), piece.points.begin(), piece.points.end());
      robot.source.insert(robot.source.end(), piece.source.begin(), piece.source.end());
      robot.hidden.insert(robot.hidden.end(), piece.hidden.begin(), piece.hidden.end());
      piece.points.clear();
      piece.source.clear();
      piece.hidden.clear();
      piece.piece = strays_.viewOf(load.piece);
      if (piece.piece) {
        piece.piece->points = 1;  // its place is known, by the hand
      }
      piece.carried = CarriedPiece{robot.name, load.T_tip_piece};
    }
  }

  /// The points of an object where the cameras saw them, not laid onto its known surface.
  [[nodiscard]] std::vector<Eigen::Vector3f> seenOf(const AssociatedObject& object) const {
    std::vector<Eigen::Vector3f> seen;
    seen.reserve(object.source.size());
    for (const std::uint32_t i : object.source) {
      seen.push_back(set_.seenAt(i));
    }
    return seen;
  }

  /// The cameras that see points of an object, one bit each.
  [[nodiscard]] std::uint32_t camerasOf(const AssociatedObject& object) const {
    std::uint32_t cameras = 0;
    for (const std::uint32_t i : object.source) {
      cameras |= 1U << static_cast<std::uint32_t>((*set_.points)[i].camera);
    }
    return cameras;
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
    const SceneModel& model = surfaces_.model();
    for (int piece = 0; piece < model.pieces(); ++piece) {
      model.cellsInside(piece, result_.objects[static_cast<std::size_t>(model.objectOf(piece))].hidden);
    }
  }

  /// What nobody registered: what shows, and what was seen and is hidden now.
  void writeUnknown(StampNs stamp_ns) {
    const ObjectTracks& tracks = remainder_.tracks();
    std::set<int> written;
    for (const UnknownThing* thing : remainder_.unknown().believed()) {
      writeUnknown(stamp_ns, thing->number, thing->points, thing->source);
      written.insert({thing->number, tracks.numberOf(thing->source)});
    }
    for (const ObjectTracks::Place& place : tracks.placesBut(written, *set_.points)) {
      writeUnknown(stamp_ns, place.number, place.points, place.source);
    }
  }

  void writeUnknown(StampNs stamp_ns, int number, const std::vector<Eigen::Vector3f>& points,
                    const std::vector<std::uint32_t>& source) {
    AssociatedObject out;
    out.name = unknownName(number);
    out.is_unknown = true;
    out.stamp_ns = stamp_ns;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const Eigen::Vector3f& p : points) {
      sum += p;
    }
    out.T_world_seed.translation() = (sum / static_cast<float>(points.size())).cast<double>();
    (source.empty() ? out.hidden : out.points) = points;
    out.source = source;
    result_.objects.push_back(std::move(out));
  }

  AssociationParams params_;
  PresentSet set_;
  SurfaceExplainer surfaces_;
  Remainder remainder_;
  StrayDebris strays_;
  Attachments attachments_;
  Hands hands_;
  std::unordered_map<std::string, std::unique_ptr<ObjectMemory>> memory_;
  AssociatedSet result_;
};

}  // namespace

std::unique_ptr<Associator> makeYarmAssociator(const AssociationParams& params) {
  return std::make_unique<YarmAssociator>(params);
}

}  // namespace yarm::perception
