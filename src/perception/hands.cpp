#include "hands.hpp"

#include "present_set.hpp"

#include "yarm/perception/solids.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

namespace yarm::perception {

namespace {

constexpr float kHandReach = 0.30F;  // a cup goes no farther down from the end effector than this, metres
constexpr float kCupAside = 0.02F;   // a cup holds a piece whose edge is no farther from its middle than this, metres
constexpr StampNs kDoubtNs =
    1'000'000'000;                 // so long a piece is kept that only poses of different times show elsewhere
constexpr double kSlipped = 0.02;  // a piece that has moved so far across the cup is no longer held, metres
constexpr float kNowhere = std::numeric_limits<float>::infinity();

/// A solid enlarged by what the cup may overlap its edge.
Eigen::Vector3f enlarged(const Solid& solid) {
  const bool box = solid.shape == Solid::Shape::kBox;
  const Eigen::Vector3f margin(2 * kCupAside, 2 * kCupAside, 0.0F);
  return solid.size.cast<float>() + (box ? margin : Eigen::Vector3f(kCupAside, 0.0F, 0.0F));
}

/// How far under the tip a hand that goes straight down meets a piece, metres; +inf when it misses.
float meets(const Eigen::Isometry3d& T_world_tip, const ObjectMemory& piece) {
  if (!piece.hasShape()) {
    const Eigen::Vector3d seed = T_world_tip.inverse() * piece.seed().T_world_seed.translation();
    return seed.z() < 0.0 && seed.head<2>().norm() < kDebrisReach ? static_cast<float>(-seed.z()) : kNowhere;
  }
  float least = kNowhere;
  for (const Solid& solid : piece.solids()) {
    if (const auto T_world_frame = piece.poseOf(solid.frame)) {
      const Eigen::Isometry3f T_solid_tip =
          ((*T_world_frame * solid.T_frame_solid).inverse() * T_world_tip).cast<float>();
      least = std::min(least, rayEntry(solid.shape, enlarged(solid), T_solid_tip.translation(),
                                       T_solid_tip.linear() * -Eigen::Vector3f::UnitZ()));
    }
  }
  return least;
}

int indexOf(const std::vector<ObjectMemory*>& objects, const std::string& name) {
  const auto named = [&](const ObjectMemory* object) { return object->seed().name == name; };
  const auto found = std::find_if(objects.begin(), objects.end(), named);
  return found != objects.end() ? static_cast<int>(found - objects.begin()) : -1;
}

Eigen::Isometry3d poseAtTip(const ObjectMemory& robot, const ObjectMemory& piece) {
  return robot.seed().T_world_seed.inverse() * piece.seed().T_world_seed;
}

}  // namespace

const std::vector<Hands::Load>& Hands::update(const std::vector<ObjectMemory*>& objects,
                                              const std::set<std::string>& grasping, StampNs stamp_ns, bool timely) {
  keep(objects, grasping, stamp_ns, timely);
  for (const std::string& name : grasping) {
    const int robot = indexOf(objects, name);
    if (robot >= 0 && taken_.count(name) == 0) {
      take(objects, *objects[static_cast<std::size_t>(robot)], stamp_ns);
    }
  }
  loads_.clear();
  for (const auto& [name, taken] : taken_) {
    const int robot = indexOf(objects, name);
    const int piece = indexOf(objects, taken.piece);
    loads_.push_back({robot, piece,
                      poseAtTip(*objects[static_cast<std::size_t>(robot)], *objects[static_cast<std::size_t>(piece)])});
  }
  return loads_;
}

void Hands::keep(const std::vector<ObjectMemory*>& objects, const std::set<std::string>& grasping, StampNs stamp_ns,
                 bool timely) {
  for (auto entry = taken_.begin(); entry != taken_.end();) {
    const int robot = grasping.count(entry->first) > 0 ? indexOf(objects, entry->first) : -1;
    const int piece = indexOf(objects, entry->second.piece);
    bool held = robot >= 0 && piece >= 0;
    if (held) {
      const ObjectMemory& hand = *objects[static_cast<std::size_t>(robot)];
      const ObjectMemory& load = *objects[static_cast<std::size_t>(piece)];
      const Eigen::Vector2d aside = poseAtTip(hand, load).translation().head<2>();
      const bool there =
          (aside - entry->second.aside).norm() <= kSlipped && meets(hand.seed().T_world_seed, load) <= kHandReach;
      StampNs& there_ns = entry->second.there_ns;
      there_ns = there ? stamp_ns : there_ns;
      held = there || (!timely && stamp_ns - there_ns <= kDoubtNs);
    }
    entry = held ? std::next(entry) : taken_.erase(entry);
  }
}

void Hands::take(const std::vector<ObjectMemory*>& objects, const ObjectMemory& robot, StampNs stamp_ns) {
  const ObjectMemory* nearest = nullptr;
  float least = kHandReach;
  for (const ObjectMemory* piece : objects) {
    if (piece->seed().object != ObjectKind::kDebris || isTaken(piece->seed().name)) {
      continue;
    }
    const float down = meets(robot.seed().T_world_seed, *piece);
    if (down <= least) {
      nearest = piece;
      least = down;
    }
  }
  if (nearest != nullptr) {
    taken_[robot.seed().name] = {nearest->seed().name, poseAtTip(robot, *nearest).translation().head<2>(), stamp_ns};
  }
}

bool Hands::isTaken(const std::string& piece) const {
  return std::any_of(taken_.begin(), taken_.end(), [&](const auto& entry) { return entry.second.piece == piece; });
}

}  // namespace yarm::perception
