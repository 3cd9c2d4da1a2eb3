#include "yarm/perception/occupancy.hpp"

#include <algorithm>

namespace yarm::perception {

namespace {

bool isRobot(const AssociatedObject& o) {
  return o.object == ObjectKind::kMobile || o.object == ObjectKind::kManipulator;
}

bool isAttached(const AssociatedObject& a, const AssociatedObject& b) {
  return std::find(a.attached_to.begin(), a.attached_to.end(), b.name) != a.attached_to.end();
}

/// How loosely an object stands in the cell: the looser one keeps a cell that two share in peace.
int looseness(const AssociatedObject& o) {
  if (o.object == ObjectKind::kDebris) {
    return 4;
  }
  if (o.is_unknown) {
    return 3;
  }
  if (!o.attached_to.empty()) {
    return 2;
  }
  return o.is_static ? 0 : 1;
}

}  // namespace

bool mayShareCells(const AssociatedObject& a, const AssociatedObject& b) {
  return (!isRobot(a) && !isRobot(b)) || isAttached(a, b) || isAttached(b, a);
}

std::vector<std::int32_t> UidRegistry::update(const std::vector<std::string>& names) {
  std::unordered_map<std::string, std::int32_t> kept;
  std::vector<std::int32_t> result;
  for (const std::string& name : names) {
    const auto old = uids_.find(name);
    result.push_back(kept.emplace(name, old != uids_.end() ? old->second : next_).first->second);
    next_ += result.back() == next_ ? 1 : 0;
  }
  uids_ = std::move(kept);
  return result;
}

OccupancyBuilder::OccupancyBuilder(const GridSpec& spec) : finder_(spec) {
  grid_.spec = spec;
  bits_.assign((spec.count() + 63) / 64, 0);
}

void OccupancyBuilder::mark(const std::vector<Eigen::Vector3f>& points) {
  for (const Eigen::Vector3f& p : points) {
    const int index = finder_.indexOf(p.x(), p.y(), p.z());
    if (index >= 0) {
      bits_[static_cast<std::size_t>(index) / 64] |= std::uint64_t{1} << (static_cast<unsigned>(index) % 64);
    }
  }
}

void OccupancyBuilder::collect(std::vector<std::int32_t>& cells) {
  cells.clear();
  for (std::size_t w = 0; w < bits_.size(); ++w) {
    for (std::uint64_t word = bits_[w]; word != 0; word &= word - 1) {
      const auto index = static_cast<std::int32_t>(w * 64) + __builtin_ctzll(word);
      cells.push_back(index);
      std::int8_t& owners = grid_.cells[static_cast<std::size_t>(index)];
      owners = static_cast<std::int8_t>(std::min<int>(owners + 1, 2));
    }
    bits_[w] = 0;
  }
}

void OccupancyBuilder::gatherShared() {
  shared_.clear();
  for (std::size_t o = 0; o < grid_.object_cells.size(); ++o) {
    for (const std::int32_t cell : grid_.object_cells[o]) {
      if (grid_.cells[static_cast<std::size_t>(cell)] > 1) {
        shared_.emplace_back(cell, static_cast<std::int32_t>(o));
      }
    }
  }
  std::sort(shared_.begin(), shared_.end());
}

void OccupancyBuilder::settle(const AssociatedSet& set) {
  gatherShared();
  for (std::size_t begin = 0; begin < shared_.size();) {
    std::size_t end = begin;
    std::size_t keeper = begin;
    bool peace = true;
    for (; end < shared_.size() && shared_[end].first == shared_[begin].first; ++end) {
      const AssociatedObject& object = set.objects[static_cast<std::size_t>(shared_[end].second)];
      for (std::size_t other = begin; other < end; ++other) {
        peace = peace && mayShareCells(set.objects[static_cast<std::size_t>(shared_[other].second)], object);
      }
      if (looseness(object) > looseness(set.objects[static_cast<std::size_t>(shared_[keeper].second)])) {
        keeper = end;
      }
    }
    if (peace) {
      give(begin, end, keeper);
    } else {
      grid_.collisions.push_back(shared_[begin].first);
    }
    begin = end;
  }
}

void OccupancyBuilder::give(std::size_t begin, std::size_t end, std::size_t keeper) {
  grid_.cells[static_cast<std::size_t>(shared_[begin].first)] = 1;
  for (std::size_t i = begin; i < end; ++i) {
    if (i != keeper) {
      auto& cells = grid_.object_cells[static_cast<std::size_t>(shared_[i].second)];
      cells.erase(std::lower_bound(cells.begin(), cells.end(), shared_[i].first));
    }
  }
}

const OccupancyGrid& OccupancyBuilder::build(const AssociatedSet& set) {
  grid_.cells.assign(grid_.spec.count(), 0);
  grid_.collisions.clear();
  grid_.object_cells.resize(set.objects.size());
  for (std::size_t o = 0; o < set.objects.size(); ++o) {
    mark(set.objects[o].points);
    mark(set.objects[o].hidden);
    collect(grid_.object_cells[o]);
  }
  settle(set);
  return grid_;
}

}  // namespace yarm::perception
