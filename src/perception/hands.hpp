// What hangs on the robots' hands.
#pragma once

#include "object_memory.hpp"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace yarm::perception {

/// Remembers which piece of debris each robot's hand holds. A hand says only that it holds something; what is told by
/// where things are: a cup at the robot's end effector comes straight down on what it takes.
class Hands {
 public:
  /// A piece on a hand: indices among the objects of the set.
  struct Load {
    int robot;
    int piece;
    Eigen::Isometry3d T_tip_piece;  ///< the piece's seed in the frame of the robot's
  };

  /// What is held in a set. `grasping`: robots whose hand says that it holds something. A piece is carried from the set
  /// on in which its robot says so, and no longer when the robot says no more, or the piece is no longer where it was
  /// taken. `timely`: the objects' poses are of the set's own time, `stamp_ns`; where they are not, a robot that moves
  /// seems to have left its piece behind, which is then believed only after a second. O(hands x debris).
  const std::vector<Load>& update(const std::vector<ObjectMemory*>& objects, const std::set<std::string>& grasping,
                                  StampNs stamp_ns, bool timely);
  /// Forgets what is held.
  void reset() { taken_.clear(); }

 private:
  struct Taken {
    std::string piece;
    Eigen::Vector2d aside;  // of the piece's seed from the tip when it was taken, metres, tip's frame
    StampNs there_ns;       // of the newest set in which it was where it was taken
  };

  /// Keeps those of the pieces taken before that are still where they were taken.
  void keep(const std::vector<ObjectMemory*>& objects, const std::set<std::string>& grasping, StampNs stamp_ns,
            bool timely);
  /// A robot that says that it holds something takes the first piece under its tip that no other hand holds.
  void take(const std::vector<ObjectMemory*>& objects, const ObjectMemory& robot, StampNs stamp_ns);
  [[nodiscard]] bool isTaken(const std::string& piece) const;

  std::map<std::string, Taken> taken_;  // by robot
  std::vector<Load> loads_;
};

}  // namespace yarm::perception
