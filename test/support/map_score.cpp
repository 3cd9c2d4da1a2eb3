#include "association_score.hpp"

#include "yarm/perception/solids.hpp"

#include <cmath>

namespace yarm::test {

namespace {

constexpr int kRays = 3;

/// Cells that enough noise-free rays of the set end in.
std::vector<int> visibleCells(const ScoredSet& set, const CameraModel& model) {
  const pc::GridSpec& grid = set.grid->spec;
  std::vector<int> hits(grid.count(), 0);
  const float focal = 0.5F * static_cast<float>(model.width) / static_cast<float>(std::tan(0.5 * model.fov_rad));
  for (const Render& r : *set.renders) {
    for (std::size_t i = 0; i < r.truth.size(); ++i) {
      const float z = r.exact_depth[i];
      if (r.truth[i] < 0 || z < model.near_m || z > model.far_m) {
        continue;
      }
      const auto u = static_cast<float>(i % static_cast<std::size_t>(model.width));
      const auto v = static_cast<float>(i / static_cast<std::size_t>(model.width));
      const Eigen::Vector3f p((u + 0.5F - 0.5F * static_cast<float>(model.width)) / focal * z,
                              (v + 0.5F - 0.5F * static_cast<float>(model.height)) / focal * z, z);
      const Eigen::Vector3f w = r.T_world_camera * p;
      const int cell = grid.indexOf(w.x(), w.y(), w.z());
      if (cell >= 0) {
        ++hits[static_cast<std::size_t>(cell)];
      }
    }
  }
  std::vector<int> cells;
  for (std::size_t c = 0; c < hits.size(); ++c) {
    if (hits[c] >= kRays) {
      cells.push_back(static_cast<int>(c));
    }
  }
  return cells;
}

bool marked(const pc::OccupancyGrid& grid, const pc::Cell& c) {
  const auto& n = grid.spec.size;
  const bool inside = c.x >= 0 && c.x < n[0] && c.y >= 0 && c.y < n[1] && c.z >= 0 && c.z < n[2];
  return inside && grid.cells[static_cast<std::size_t>(grid.spec.indexOf(c))] > 0;
}

bool markedOrBeside(const pc::OccupancyGrid& grid, const pc::Cell& c) {
  return marked(grid, c) || marked(grid, {c.x - 1, c.y, c.z}) || marked(grid, {c.x + 1, c.y, c.z}) ||
         marked(grid, {c.x, c.y - 1, c.z}) || marked(grid, {c.x, c.y + 1, c.z}) || marked(grid, {c.x, c.y, c.z - 1}) ||
         marked(grid, {c.x, c.y, c.z + 1});
}

/// Whether some body reaches into a cell or one of the 26 around it.
bool bodyNear(const Scene& scene, const pc::GridSpec& grid, const pc::Cell& cell) {
  const Eigen::Vector3d centre = grid.centre(cell);
  for (const Body& body : scene.bodies) {
    for (const pc::Solid& solid : body.solids) {
      const Eigen::Isometry3d T = (scene.poses.at(solid.frame) * solid.T_frame_solid).inverse();
      for (int i = 0; i < 13 * 13 * 13; ++i) {
        const Eigen::Vector3d step((i % 13 - 6) / 6.0, (i / 13 % 13 - 6) / 6.0, (i / 169 - 6) / 6.0);
        const Eigen::Vector3d p = centre + 1.5 * step.cwiseProduct(Eigen::Vector3d(
                                                     grid.resolution(0), grid.resolution(1), grid.resolution(2)));
        const Eigen::Vector3f local = (T * p).cast<float>();
        const float d = pc::surfaceDistance(solid.shape, solid.size.cast<float>(), local).distance;
        if (d <= 0.013F) {
          return true;
        }
        if (i == 0 && d > 0.6F) {
          break;
        }
      }
    }
  }
  return false;
}

}  // namespace

MapScore scoreMap(const Scene& scene, const ScoredSet& set) {
  MapScore score;
  const pc::OccupancyGrid& grid = *set.grid;
  for (const int cell : visibleCells(set, {})) {
    ++score.visible_cells;
    score.missed += markedOrBeside(grid, grid.spec.cellOf(cell)) ? 0 : 1;
  }
  for (std::size_t c = 0; c < grid.cells.size(); ++c) {
    if (grid.cells[c] > 0) {
      ++score.marked_cells;
      score.phantom += bodyNear(scene, grid.spec, grid.spec.cellOf(static_cast<int>(c))) ? 0 : 1;
    }
  }
  return score;
}

}  // namespace yarm::test
