// Identity and motion of what nobody registered, over all sets in which it shows and those in which it is hidden.
#pragma once

#include "yarm/perception/association.hpp"

#include "axis_filter.hpp"
#include "sightlines.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <set>
#include <utility>
#include <vector>

namespace yarm::perception {

/// Follows the groups of points of which nothing registered is the owner. A track is believed as an unknown thing is
/// (`unknown_hits` of `unknown_window` sets). A believed one ends only where it is seen not to be: two sets in a row
/// look through most of its place, or something registered stands there; one that was at the border of the volume when
/// it last showed may be outside and is kept for a second besides. One that stays within another track's box for 0.7 s
/// was that one. One instance an association, not thread safe.
class ObjectTracks {
 public:
  using Group = std::vector<std::uint32_t>;

  explicit ObjectTracks(const AssociationParams& params) : params_(params) {}

  /// Takes a set: its capture time, its points, which of them a registered body explains, the cameras without a view in
  /// it, and the groups of unexplained points (indices into `points`). Groups and tracks are brought together by exact
  /// assignment.
  void update(StampNs stamp_ns, const std::vector<MergedPoint>& points, const std::vector<char>& explained,
              const std::vector<std::int32_t>& absent, const std::vector<Group>& groups);
  /// Ends those that did not show in the last set and of which more than half is `explained` by something registered.
  void dissolve(const std::function<bool(const Eigen::Vector3f&)>& explained);
  /// Ends those of which more than half is `known` now, also those that showed.
  void forget(const std::function<bool(const Eigen::Vector3f&)>& known);
  /// The believed ones after the last set, in the order of their numbers.
  [[nodiscard]] const std::vector<TrackedObject>& believed() const { return believed_; }
  /// A believed track that the map must show: points where it is, metres, world.
  struct Place {
    int number;
    std::vector<std::uint32_t> source;    ///< its points of the last set; none while it is hidden
    std::vector<Eigen::Vector3f> points;  ///< those, or its fullest view where its motion has led it, or it stands
  };
  /// The believed tracks that show, or do not and may be where they are, but for those numbered.
  [[nodiscard]] std::vector<Place> placesBut(const std::set<int>& numbers,
                                             const std::vector<MergedPoint>& points) const;
  /// Number of the believed track to which most of these points of the last set belong; 0 = none.
  [[nodiscard]] int numberOf(const Group& points) const;
  /// A number that nothing has had yet.
  int newNumber() { return next_number_++; }
  void reset();

 private:
  /// What a set shows of a thing.
  struct Shown {
    Group points;
    std::array<SeenEdges, 3> edges;
    std::uint32_t cameras{0};  ///< that see points of it, a bit each
  };
  using Axes = std::array<AxisFilter, 3>;
  enum class Look { kFree, kNotSeen, kOutside };
  struct Track {
    int number{0};             ///< 0: not believed yet
    std::uint32_t history{1};  ///< bit i = it showed i sets ago
    Axes axes;
    StampNs first_ns{0};
    StampNs last_ns{0};
    std::uint32_t cameras{0};              ///< that have ever seen it, a bit each
    std::vector<Eigen::Vector3f> surface;  ///< some of its points when it last showed, off its middle, metres
    std::vector<Eigen::Vector3f> body;     ///< the points of its last full view, off its middle, metres
    double fullest{0.0};                   ///< points of its fullest view, those longer ago less
    bool may_be_there{true};               ///< it shows, or its place is not seen to be free
    int gone_sets{0};                      ///< sets in a row that have looked through its place
    StampNs covered_ns{-1};                ///< since when it is within another one's box; -1: it is not
    bool at_border{false};                 ///< when it last showed it was cut by the border of the volume, in x or y
    bool hidden{false};
  };

  [[nodiscard]] Shown shownBy(const std::vector<MergedPoint>& points, Group group) const;
  /// Joins the first specks that a body shows at the border of the volume, one over the other.
  void joinAtBorder(const std::vector<MergedPoint>& points, std::vector<Shown>& shown) const;
  /// Group of each track, kUnassigned where it has none; those that are parts of a thing, or several things at once,
  /// are put right in `shown` (a group that has become another's is emptied).
  [[nodiscard]] std::vector<int> bringTogether(const std::vector<MergedPoint>& points, std::vector<Shown>& shown) const;
  void joinParts(const std::vector<MergedPoint>& points, std::vector<Shown>& shown, const std::vector<int>& of) const;
  void shareJoint(const std::vector<MergedPoint>& points, std::vector<Shown>& shown, std::vector<int>& of) const;
  [[nodiscard]] double cost(const Track& track, const Shown& shown) const;
  /// A track that shows: its group is its own, and emptied.
  void show(Track& track, const std::vector<MergedPoint>& points, Shown& shown, StampNs stamp_ns);
  /// Notes when, by whom and where a track was seen.
  static void note(Track& track, const std::vector<MergedPoint>& points, const Shown& shown, StampNs stamp_ns);
  /// A track that does not show; `before` is where it was in the set before.
  void miss(Track& track, const Axes& before, StampNs stamp_ns) const;
  /// What the last set says of most of a track's place, were it there.
  [[nodiscard]] Look look(const Track& track, const Axes& axes) const;
  [[nodiscard]] bool ends(const Track& track) const;
  [[nodiscard]] static bool isMostly(const Track& track, const std::function<bool(const Eigen::Vector3f&)>& known);
  [[nodiscard]] bool isBelieved(const Track& track) const;
  void bear(const std::vector<MergedPoint>& points, const Shown& shown, StampNs stamp_ns);
  void writeBelieved();

  AssociationParams params_;
  Sightlines sightlines_;
  std::vector<Track> tracks_;
  std::vector<TrackedObject> believed_;
  std::vector<std::pair<std::uint32_t, int>> owned_;  ///< points of the last set and their track's number
  StampNs stamp_ns_{0};
  int next_number_{1};
};

}  // namespace yarm::perception
