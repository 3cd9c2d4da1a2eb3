// Debris that nobody registered: small things that have come to rest on a fixed body.
#pragma once

#include "footprint.hpp"
#include "hands.hpp"
#include "object_memory.hpp"
#include "present_set.hpp"
#include "rest_map.hpp"

#include "yarm/perception/piece.hpp"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace yarm::perception {

/// Finds and follows them. A thing becomes "debris_auto_<n>" when it has been at rest for `debris_rest` on the top of a
/// registered fixed body and no edge of it is longer than `debris_size`; in calibration nothing does. From then on it
/// is an object of the set, with the box in which it was seen as its known shape: it is carried by hands, and stays
/// where it is hidden. It ends when its place is seen to be empty; what has left a hand, or its place, and comes to
/// rest near by within some seconds is the same. One instance an association, not thread safe.
class StrayDebris {
 public:
  explicit StrayDebris(const AssociationParams& params);

  /// Adds the pieces to the objects of the set that begins, each where it is now: what hangs on a hand moves with it.
  void join(PresentSet& set, const LinkPoses& links);
  /// Takes the set whose points have owners; pieces that are found now are objects from the next set on.
  void update(const PresentSet& set, const SceneModel& model);
  /// Takes what hangs on hands after the set: indices of the objects as `join` made them.
  void carry(const PresentSet& set, const std::vector<Hands::Load>& loads);
  /// Where an object of the set as `join` made it is, and how large; empty for those that it did not add.
  [[nodiscard]] std::optional<PieceView> viewOf(int object) const;
  /// Whether a point lies in a piece that was found in the last set: what was followed there was that.
  [[nodiscard]] bool foundAt(const Eigen::Vector3f& point) const;
  [[nodiscard]] bool foundAny() const { return !found_.empty(); }
  void reset();

 private:
  /// The readings of one pixel over some sets.
  struct Pixel {
    Eigen::Vector3f sum{Eigen::Vector3f::Zero()};
    Eigen::Vector3f ray{Eigen::Vector3f::Zero()};  ///< of the last one, unit vector from the camera
    int readings{0};
  };
  /// Something that rises and may be debris.
  struct Candidate {
    Eigen::Vector2f anchor{0.F, 0.F};  ///< where it came to rest, metres, world
    Rise rise;                         ///< when it last showed
    StampNs since_ns{0};
    StampNs shown_ns{0};
    int sets{0};                            ///< since then
    int shown{0};                           ///< of those, in which it showed
    std::map<std::uint64_t, Pixel> pixels;  ///< on it and around it, since it has been at rest
  };
  /// How a piece hangs on a hand.
  struct Held {
    std::string robot;
    Eigen::Isometry3d T_tip_piece;
  };
  struct Piece {
    int number{0};
    ObjectMemory memory;
    KnownObject known;
    Seed seed;
    Footprint footprint;
    float ground{0.F};                            ///< under it, metres, world
    float height{0.F};                            ///< of its top over that, metres
    std::map<std::uint64_t, Eigen::Vector3f> on;  ///< the pixels that meet it, and where; none once it has been carried
    std::optional<Held> held;
    StampNs left_ns{-1};  ///< when it left a hand, or its place was seen to be empty first; -1: it has not
    int empty_sets{0};    ///< in a row in which its place was seen to be empty
    bool lost{false};     ///< no longer on the map, but may come to rest near by
  };

  void collect(const PresentSet& set);
  void follow(const PresentSet& set);
  [[nodiscard]] bool isDebris(const PresentSet& set, const Rise& rise) const;
  [[nodiscard]] bool isTaken(const PresentSet& set, const Rise& rise) const;
  /// What the pixels say of a thing's outline: where they meet it, and where their rays pass beside it lower than it
  /// is.
  struct Outline {
    std::vector<Eigen::Vector2f> on;
    std::vector<Eigen::Vector2f> beside;
    std::vector<float> rises;                         ///< of those on it, over the ground, metres
    std::map<std::uint64_t, Eigen::Vector3f> pixels;  ///< those on it: where they meet it, metres, world
  };
  [[nodiscard]] static Outline outlineOf(const Candidate& candidate);
  void believe(const Candidate& candidate, StampNs stamp_ns);
  [[nodiscard]] Piece* leftNear(const Eigen::Vector2f& place, StampNs stamp_ns);
  /// Whether the pixels that met each piece look through its place.
  void look(const PresentSet& set);
  void hang(Piece& piece, const PresentSet& set) const;
  static void put(Piece& piece, const Eigen::Vector3d& middle);

  AssociationParams params_;
  RestMap rest_;
  std::vector<Candidate> candidates_;
  std::vector<std::unique_ptr<Piece>> pieces_;
  std::vector<Piece*> joined_;  // as objects from first_ on
  int first_{0};
  std::vector<Eigen::AlignedBox3f> found_;
  int next_number_{1};
};

}  // namespace yarm::perception
