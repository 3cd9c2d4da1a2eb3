#ifndef YARM_JOINT_PERMUTATIONS_HPP
#define YARM_JOINT_PERMUTATIONS_HPP

// A group of permutations, and whether one that moves some points to others is in it.

#include <cstdint>
#include <vector>

namespace yarm::joint {

/// point -> point, 0 to n - 1.
using Permutation = std::vector<std::uint8_t>;

/// All products of the permutations added: stabiliser chain by the method of Schreier and Sims (D. E. Knuth, "Efficient
/// representation of perm groups", Combinatorica 11, 1991).
class PermutationGroup {
 public:
  /// The group of the identity alone. base: the points in the order in which they are held fixed.
  explicit PermutationGroup(std::vector<std::uint8_t> base);

  /// Lets a permutation in, and all its products with the others; whether it is new.
  bool add(const Permutation& permutation);
  /// Whether some permutation takes the first `images.size()` points of the base to these images.
  bool takes(const std::vector<std::uint8_t>& images) const;

 private:
  struct Level {
    std::vector<Permutation> generators;
    std::vector<Permutation> to;  // by image of the base point; empty for none
  };

  // What is left of a permutation from a level on when it is divided by the chain; the level where that ends.
  std::size_t sift(Permutation* permutation, std::size_t level) const;
  void generate(std::size_t level, const Permutation& permutation);
  void offer(std::size_t level, const Permutation& permutation);

  std::vector<std::uint8_t> base_;
  std::vector<Level> levels_;
};

}  // namespace yarm::joint

#endif  // YARM_JOINT_PERMUTATIONS_HPP
