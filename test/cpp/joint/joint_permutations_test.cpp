// The group of permutations against all products made one by one.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include "../../../src/joint/permutations.hpp"

namespace {

using yarm::joint::Permutation;
using yarm::joint::PermutationGroup;

std::set<Permutation> products(const std::vector<Permutation>& generators, std::size_t n) {
  Permutation identity(n);
  for (std::size_t p = 0; p < n; ++p) {
    identity[p] = static_cast<std::uint8_t>(p);
  }
  std::set<Permutation> all{identity};
  std::vector<Permutation> waiting{identity};
  while (!waiting.empty()) {
    const Permutation one = waiting.back();
    waiting.pop_back();
    for (const Permutation& generator : generators) {
      Permutation both(n);
      for (std::size_t p = 0; p < n; ++p) {
        both[p] = generator[one[p]];
      }
      if (all.insert(both).second) {
        waiting.push_back(both);
      }
    }
  }
  return all;
}

// Some points exchanged: cycles of random length.
Permutation drawn(std::mt19937* chance, std::size_t n) {
  Permutation permutation(n);
  std::vector<std::uint8_t> points(n);
  for (std::size_t p = 0; p < n; ++p) {
    permutation[p] = points[p] = static_cast<std::uint8_t>(p);
  }
  std::shuffle(points.begin(), points.end(), *chance);
  const std::size_t length = 2 + (*chance)() % (n - 1);
  for (std::size_t k = 0; k < length; ++k) {
    permutation[points[k]] = points[(k + 1) % length];
  }
  return permutation;
}

TEST(Permutations, TakeTheFirstPointsWhereSomeProductDoes) {
  std::mt19937 chance(5);
  std::size_t proper = 0;
  for (int round = 0; round < 60; ++round) {
    const std::size_t n = 2 + chance() % 5;
    std::vector<std::uint8_t> base(n);
    for (std::size_t p = 0; p < n; ++p) {
      base[p] = static_cast<std::uint8_t>(p);
    }
    std::shuffle(base.begin(), base.end(), chance);
    PermutationGroup group(base);
    std::vector<Permutation> generators;
    for (std::size_t k = 0; k < 1 + chance() % 2; ++k) {
      generators.push_back(drawn(&chance, n));
      const bool known = products({generators.begin(), generators.end() - 1}, n).count(generators.back()) > 0;
      EXPECT_EQ(group.add(generators.back()), !known);
    }
    const std::set<Permutation> all = products(generators, n);
    Permutation images(n);
    for (std::size_t p = 0; p < n; ++p) {
      images[p] = static_cast<std::uint8_t>(p);
    }
    std::size_t whole = 0;
    do {
      const std::size_t count = 1 + chance() % n;
      const std::vector<std::uint8_t> some(images.begin(), images.begin() + static_cast<std::ptrdiff_t>(count));
      const bool taken = std::any_of(all.begin(), all.end(), [&](const Permutation& one) {
        return std::equal(some.begin(), some.end(), base.begin(),
                          [&one](std::uint8_t image, std::uint8_t point) { return one[point] == image; });
      });
      EXPECT_EQ(group.takes(some), taken) << "round " << round << ", " << count << " of " << n << " points";
      ++whole;
    } while (std::next_permutation(images.begin(), images.end()));
    proper += all.size() < whole ? 1 : 0;
  }
  EXPECT_GT(proper, 20U);
}

TEST(Permutations, TheOddOnesAreNotAmongTheEven) {
  const std::size_t n = 15;
  std::vector<std::uint8_t> base(n);
  Permutation even(n), swapped(n);
  for (std::size_t p = 0; p < n; ++p) {
    base[p] = even[p] = swapped[p] = static_cast<std::uint8_t>(p);
  }
  PermutationGroup group(base);
  for (std::size_t p = 0; p + 2 < n; ++p) {
    Permutation three = even;
    three[p] = static_cast<std::uint8_t>(p + 1);
    three[p + 1] = static_cast<std::uint8_t>(p + 2);
    three[p + 2] = static_cast<std::uint8_t>(p);
    EXPECT_TRUE(group.add(three));
  }
  std::swap(swapped[3], swapped[11]);
  EXPECT_FALSE(group.takes(swapped));
  std::swap(swapped[0], swapped[1]);
  EXPECT_TRUE(group.takes(swapped));
}

}  // namespace
