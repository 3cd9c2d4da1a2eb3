#include "masks.hpp"

#include <utility>

namespace yarm::joint {
namespace {

constexpr std::size_t kBits = 64;

std::size_t wordsOf(const RobotGraph& graph) {
  return (graph.edges() + kBits - 1) / kBits;
}

}  // namespace

Masks::Masks(const Fleet& fleet) : fleet_(fleet), masks_(fleet.size() * fleet.size()) {
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    std::size_t like = 0;
    while (!fleet.alike(i, like)) {
      ++like;
    }
    kind_.push_back(like);
  }
}

std::int64_t Masks::bytes(const Fleet& fleet) {
  std::int64_t sum = fleet.hasNear() ? kTooMany : 0;
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    for (std::size_t j = 0; j < fleet.size(); ++j) {
      sum += static_cast<std::int64_t>(wordsOf(fleet.graph(i)) * sizeof(std::uint64_t)) * fleet.graph(j).size();
    }
  }
  return sum;
}

const std::vector<std::uint64_t>& Masks::blocked(std::size_t i, const Places& places) {
  sum_.assign(wordsOf(fleet_.graph(i)), 0);
  for (std::size_t j = 0; j < places.size(); ++j) {
    if (j != i) {
      const std::vector<std::uint64_t>& own = mask(i, j, places[j]);
      for (std::size_t w = 0; w < sum_.size(); ++w) {
        sum_[w] |= own[w];
      }
    }
  }
  work_ += static_cast<std::int64_t>(sum_.size() * places.size() / 8 + places.size());
  return sum_;
}

std::int64_t Masks::work() {
  return std::exchange(work_, 0);
}

const std::vector<std::uint64_t>& Masks::mask(std::size_t i, std::size_t j, Place place) {
  std::vector<std::vector<std::uint64_t>>& own = masks_[kind_[i] * fleet_.size() + kind_[j]];
  own.resize(static_cast<std::size_t>(fleet_.graph(j).size()));
  std::vector<std::uint64_t>& bits = own[place];
  if (bits.empty()) {
    const RobotGraph& graph = fleet_.graph(i);
    bits.assign(wordsOf(graph) + 1, 0);
    work_ += static_cast<std::int64_t>(graph.edges());
    for (Place from = 0; from < graph.size(); ++from) {
      for (const Edge* edge = graph.begin(from); edge != graph.end(from); ++edge) {
        if (!fleet_.clearOf(i, from, *edge, j, place)) {
          const std::size_t number = graph.numberOf(edge);
          bits[number / kBits] |= std::uint64_t{1} << number % kBits;
        }
      }
    }
  }
  return bits;
}

}  // namespace yarm::joint
