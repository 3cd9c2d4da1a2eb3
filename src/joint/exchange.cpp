#include "exchange.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace yarm::joint {
namespace {

constexpr std::size_t kFirstTable = 1 << 10;
// Robots at most: beyond, the patterns are too many anyway.
constexpr std::size_t kMost = 24;

// Robots with a goal, then the others.
std::vector<std::uint8_t> baseOf(const Fleet& fleet) {
  std::vector<std::uint8_t> base(fleet.size());
  std::iota(base.begin(), base.end(), std::uint8_t{0});
  std::stable_partition(base.begin(), base.end(), [&fleet](std::uint8_t i) { return fleet.hasGoal(i); });
  return base;
}

}  // namespace

bool Exchange::fits(const Fleet& fleet) {
  if (fleet.hasNear() || fleet.size() > kMost) {
    return false;
  }
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (fleet.alike(i, j)) {
        return true;
      }
    }
  }
  return false;
}

Exchange::Exchange(const Fleet& fleet, std::int64_t memory_bytes)
    : fleet_(fleet), memory_bytes_(memory_bytes), table_(kFirstTable, -1), group_(baseOf(fleet)) {
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    std::size_t like = 0;
    while (!fleet.alike(i, like)) {
      ++like;
    }
    kind_.push_back(static_cast<std::int32_t>(like));
    if (fleet.hasGoal(i)) {
      wanting_.push_back(static_cast<std::uint8_t>(i));
    }
  }
  Pattern start{fleet.starts(), Permutation(fleet.size())};
  std::iota(start.robots.begin(), start.robots.end(), std::uint8_t{0});
  std::stable_sort(start.robots.begin(), start.robots.end(),
                   [this](std::uint8_t a, std::uint8_t b) { return kind_[a] < kind_[b]; });
  for (std::size_t slot = 0; slot < fleet.size(); ++slot) {
    start.places[slot] = fleet.start(start.robots[slot]);
    const bool begins = slot == 0 || kind_[start.robots[slot]] != kind_[start.robots[slot - 1]];
    first_.push_back(begins ? static_cast<std::int32_t>(slot) : first_.back());
  }
  sort(&start);
  add(start, hashOf(start.places));
  arrive(start);
}

Outcome Exchange::advance(std::int64_t work) {
  const std::int64_t until = work_ + work;
  while (work_ < until) {
    if (next_ == count_) {
      return verdict();
    }
    if (bytes() > memory_bytes_) {
      return Outcome::kFull;
    }
    expand(static_cast<std::int32_t>(next_++));
  }
  return Outcome::kOpen;
}

// Slots of one kind stay together; robots of one are put in the order of their places.
void Exchange::sort(Pattern* pattern) const {
  Places& places = pattern->places;
  Permutation& robots = pattern->robots;
  for (std::size_t slot = 1; slot < places.size(); ++slot) {
    for (std::size_t k = slot; k > static_cast<std::size_t>(first_[slot]) && places[k] < places[k - 1]; --k) {
      std::swap(places[k], places[k - 1]);
      std::swap(robots[k], robots[k - 1]);
    }
  }
}

void Exchange::expand(std::int32_t number) {
  const std::size_t n = fleet_.size();
  Pattern here{Places(n), Permutation(n)};
  const std::size_t from = static_cast<std::size_t>(number) * n;
  std::copy_n(places_.begin() + static_cast<std::ptrdiff_t>(from), n, here.places.begin());
  std::copy_n(robots_.begin() + static_cast<std::ptrdiff_t>(from), n, here.robots.begin());
  Places at(n);
  for (std::size_t slot = 0; slot < n; ++slot) {
    at[here.robots[slot]] = here.places[slot];
  }
  for (std::size_t slot = 0; slot < n; ++slot) {
    const std::size_t i = here.robots[slot];
    const RobotGraph& graph = fleet_.graph(i);
    for (const Edge* edge = graph.begin(at[i]); edge != graph.end(at[i]); ++edge) {
      work_ += static_cast<std::int64_t>(n);
      if (!fleet_.isFree(i, at[i], *edge, at)) {
        continue;
      }
      Pattern after = here;
      after.places[slot] = edge->to;
      sort(&after);
      work_ += static_cast<std::int64_t>(n);
      const std::uint64_t hash = hashOf(after.places);
      const std::int32_t known = find(after.places, hash);
      if (known < 0) {
        add(after, hash);
        arrive(after);
      } else {
        close(after, known);
      }
    }
  }
}

// A loop from where all start by way of the pattern and back along the tree.
void Exchange::close(const Pattern& pattern, std::int32_t known) {
  const std::size_t n = fleet_.size();
  const std::uint8_t* before = robots_.data() + static_cast<std::size_t>(known) * n;
  if (std::equal(pattern.robots.begin(), pattern.robots.end(), before)) {
    return;
  }
  Permutation exchange(n);
  for (std::size_t slot = 0; slot < n; ++slot) {
    exchange[before[slot]] = pattern.robots[slot];
  }
  work_ += static_cast<std::int64_t>(n * n);
  group_.add(exchange);
}

// Keeps who must have taken whose place if the pattern holds all goals.
void Exchange::arrive(const Pattern& pattern) {
  std::vector<std::uint8_t> ends;
  for (const std::uint8_t i : wanting_) {
    const std::vector<Place>& goals = fleet_.goals(i);
    std::size_t slot = 0;
    while (slot < pattern.places.size() &&
           (kind_[pattern.robots[slot]] != kind_[i] ||
            std::find(goals.begin(), goals.end(), pattern.places[slot]) == goals.end())) {
      ++slot;
    }
    if (slot == pattern.places.size()) {
      return;
    }
    ends.push_back(pattern.robots[slot]);
  }
  ends_.insert(std::move(ends));
}

Outcome Exchange::verdict() const {
  const bool possible = std::any_of(ends_.begin(), ends_.end(),
                                    [this](const std::vector<std::uint8_t>& ends) { return group_.takes(ends); });
  return possible ? Outcome::kFull : Outcome::kExhausted;
}

std::int32_t Exchange::find(const Places& places, std::uint64_t hash) const {
  const std::size_t mask = table_.size() - 1;
  for (std::size_t entry = hash & mask; table_[entry] >= 0; entry = (entry + 1) & mask) {
    const Place* known = places_.data() + static_cast<std::size_t>(table_[entry]) * places.size();
    if (std::equal(places.begin(), places.end(), known)) {
      return table_[entry];
    }
  }
  return -1;
}

void Exchange::add(const Pattern& pattern, std::uint64_t hash) {
  if (2 * (count_ + 1) >= table_.size()) {
    grow();
  }
  const std::size_t mask = table_.size() - 1;
  std::size_t entry = hash & mask;
  while (table_[entry] >= 0) {
    entry = (entry + 1) & mask;
  }
  table_[entry] = static_cast<std::int32_t>(count_++);
  places_.insert(places_.end(), pattern.places.begin(), pattern.places.end());
  robots_.insert(robots_.end(), pattern.robots.begin(), pattern.robots.end());
}

void Exchange::grow() {
  const std::size_t n = fleet_.size(), mask = 2 * table_.size() - 1;
  table_.assign(2 * table_.size(), -1);
  for (std::size_t number = 0; number < count_; ++number) {
    const auto begin = places_.begin() + static_cast<std::ptrdiff_t>(number * n);
    std::size_t entry = hashOf(Places(begin, begin + static_cast<std::ptrdiff_t>(n))) & mask;
    while (table_[entry] >= 0) {
      entry = (entry + 1) & mask;
    }
    table_[entry] = static_cast<std::int32_t>(number);
  }
}

std::int64_t Exchange::bytes() const {
  const std::size_t end = 4 * sizeof(void*) + sizeof(std::vector<std::uint8_t>) + wanting_.size();
  return static_cast<std::int64_t>(places_.size() * sizeof(Place) + robots_.size() +
                                   table_.size() * sizeof(std::int32_t) + ends_.size() * end);
}

}  // namespace yarm::joint
