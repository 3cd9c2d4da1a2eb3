#include "permutations.hpp"

#include <utility>

namespace yarm::joint {
namespace {

// First the one, then the other.
Permutation product(const Permutation& one, const Permutation& other) {
  Permutation both(one.size());
  for (std::size_t p = 0; p < one.size(); ++p) {
    both[p] = other[one[p]];
  }
  return both;
}

Permutation inverse(const Permutation& permutation) {
  Permutation back(permutation.size());
  for (std::size_t p = 0; p < permutation.size(); ++p) {
    back[permutation[p]] = static_cast<std::uint8_t>(p);
  }
  return back;
}

}  // namespace

PermutationGroup::PermutationGroup(std::vector<std::uint8_t> base) : base_(std::move(base)), levels_(base_.size()) {
  Permutation identity(base_.size());
  for (std::size_t p = 0; p < identity.size(); ++p) {
    identity[p] = static_cast<std::uint8_t>(p);
  }
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    levels_[k].to.resize(base_.size());
    levels_[k].to[base_[k]] = identity;
  }
}

bool PermutationGroup::add(const Permutation& permutation) {
  Permutation left = permutation;
  if (sift(&left, 0) == levels_.size()) {
    return false;
  }
  generate(0, permutation);
  return true;
}

bool PermutationGroup::takes(const std::vector<std::uint8_t>& images) const {
  std::vector<std::uint8_t> left = images;
  for (std::size_t k = 0; k < left.size(); ++k) {
    const Permutation& to = levels_[k].to[left[k]];
    if (to.empty()) {
      return false;
    }
    const Permutation back = inverse(to);
    for (std::size_t later = k; later < left.size(); ++later) {
      left[later] = back[left[later]];
    }
  }
  return true;
}

std::size_t PermutationGroup::sift(Permutation* permutation, std::size_t level) const {
  for (; level < levels_.size(); ++level) {
    const Permutation& to = levels_[level].to[(*permutation)[base_[level]]];
    if (to.empty()) {
      return level;
    }
    *permutation = product(*permutation, inverse(to));
  }
  return level;
}

// A permutation that holds the base points before a level becomes a generator there.
void PermutationGroup::generate(std::size_t level, const Permutation& permutation) {
  levels_[level].generators.push_back(permutation);
  for (std::size_t image = 0; image < base_.size(); ++image) {
    if (!levels_[level].to[image].empty()) {
      offer(level, product(levels_[level].to[image], permutation));
    }
  }
}

// A product of generators of a level: it reaches a new image of the base point, or what is left of it goes one further.
void PermutationGroup::offer(std::size_t level, const Permutation& permutation) {
  std::vector<Permutation> waiting{permutation};
  while (!waiting.empty()) {
    const Permutation next = std::move(waiting.back());
    waiting.pop_back();
    Permutation& to = levels_[level].to[next[base_[level]]];
    if (to.empty()) {
      to = next;
      for (const Permutation& generator : levels_[level].generators) {
        waiting.push_back(product(next, generator));
      }
      continue;
    }
    Permutation left = product(next, inverse(to));
    Permutation rest = left;
    if (sift(&rest, level + 1) < levels_.size()) {
      generate(level + 1, left);
    }
  }
}

}  // namespace yarm::joint
