#include "attachments.hpp"

#include <algorithm>
#include <iterator>

namespace yarm::perception {

namespace {

/// Row-major cells of an object's points, ascending, each once.
std::vector<int> cellsOf(const AssociatedObject& object, const GridSpec& grid) {
  std::vector<int> cells;
  for (const auto* cloud : {&object.points, &object.hidden}) {
    for (const Eigen::Vector3f& p : *cloud) {
      cells.push_back(grid.indexOf(p.x(), p.y(), p.z()));
    }
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  cells.erase(cells.begin(), std::upper_bound(cells.begin(), cells.end(), -1));
  return cells;
}

bool shareCells(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> common;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
  return !common.empty();
}

}  // namespace

void Attachments::learn(const std::vector<AssociatedObject>& objects, const GridSpec& grid) {
  std::vector<std::vector<int>> cells;
  for (const AssociatedObject& object : objects) {
    cells.push_back(cellsOf(object, grid));
  }
  for (std::size_t a = 0; a < objects.size(); ++a) {
    const AssociatedObject& moving = objects[a];
    if (moving.is_static || moving.object == ObjectKind::kMobile) {
      continue;
    }
    std::vector<std::string>& list = attached_[moving.name];
    for (std::size_t b = 0; b < objects.size(); ++b) {
      const std::string& name = objects[b].name;
      if (objects[b].is_static && shareCells(cells[a], cells[b]) &&
          std::find(list.begin(), list.end(), name) == list.end()) {
        list.push_back(name);
      }
    }
  }
}

const std::vector<std::string>& Attachments::of(const std::string& name) const {
  static const std::vector<std::string> kNone;
  const auto found = attached_.find(name);
  return found != attached_.end() ? found->second : kNone;
}

}  // namespace yarm::perception
