// Parameters of the perception nodes; config/<node>.yaml holds the same defaults (a test compares).
#pragma once

#include "yarm/perception/association.hpp"
#include "yarm/perception/camera_watch.hpp"
#include "yarm/perception/merge.hpp"
#include "yarm/perception/picture_watch.hpp"
#include "yarm/perception/view.hpp"
#include "yarm/perception/visibility.hpp"
#include "yarm/ros/names.hpp"
#include "yarm/ros/params.hpp"

#include <string>
#include <vector>

namespace yarm {

/// Lock-step: what is waited for at most, wall time, when the simulator stands still meanwhile.
inline constexpr double kSyncWaitS = 20.0;

namespace detail {
inline std::vector<std::string> cameraNames(std::string (*name)(int)) {
  return {name(1), name(2), name(3), name(4)};
}
}  // namespace detail

/// Parameters of node merge_clouds.
struct MergeCloudsParams {
  /// Name of the node.
  static constexpr char kNode[] = "merge_clouds";
  std::string backend = "fused";
  std::vector<std::string> camera_topics = detail::cameraNames(names::cameraPoints);
  std::vector<std::string> camera_frames = detail::cameraNames(names::cameraOpticalFrame);
  double camera_timeout = 0.2;
  double sync_tolerance = 0.01;
  double max_frequency = 60.0;
  double tf_wait = 0.05;
  bool sync = false;
  perception::MergeParams merge;
  perception::ViewParams view;
  perception::PictureWatchParams pictures;
  bool visibility = false;
  std::string grid_node = "cluster_assoc";
  double visibility_rate = 5.0;
  double age_rate = 2.0;
  perception::VisibilityParams views;
  double noise_base = merge.noise.base;
  double noise_slope = merge.noise.slope;
  double noise_offset = merge.noise.offset;

  /// Tells `visit` of each parameter: name, value, unit, what is allowed, meaning; docs/parameters.md is made of it.
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor& visit) {
    visit("backend", p.backend, "", Choices{{"fused", "pcl"}}, "one pass over the points, or PCL's filters in a chain");
    visit("camera_topics", p.camera_topics, "", Choices{}, "depth clouds to merge, one or more");
    visit("camera_frames", p.camera_frames, "", Choices{},
          "frame each cloud must be in, in the same order; [] for any");
    visit("camera_timeout", p.camera_timeout, "s", Range{0.02, 10.0},
          "wall time after which a set goes on without a camera");
    visit(
        "sync_tolerance", p.sync_tolerance, "s", Range{0.0, 1.0},
        "stamps this close belong to one set; cameras that are not synchronised are brought together by their period");
    visit("max_frequency", p.max_frequency, "Hz", Range{0.1, 1000.0},
          "sets closer in capture time than this are left out");
    visit("tf_wait", p.tf_wait, "s", Range{0.0, 5.0}, "wall time a cloud waits for its transform before it is dropped");
    visit("sync", p.sync, "", Choices{}, "lock-step: wait up to 20 s for what is missing, so that runs repeat exactly");
    describeBox(p, visit);
    visit("noise_base", p.noise_base, "m", Range{0.0, 0.1}, "depth noise sigma(z) = base + slope (z - offset)^2: base");
    visit("noise_slope", p.noise_slope, "1/m", Range{0.0, 0.1}, "its slope");
    visit("noise_offset", p.noise_offset, "m", Range{0.0, 5.0}, "its offset");
    visit("floor_sigmas", p.merge.floor_sigmas, "", Range{0.0, 20.0},
          "a point must lie above the floor by this many sigmas of its noise; 0 for the plain box");
    visit("absurd_limit", p.merge.absurd_limit, "m", Range{1.0, 10000.0},
          "a coordinate beyond this, or infinite, makes a point absurd: it is left out and counted");
    visit("absurd_share", p.merge.absurd_share, "", Range{0.0, 1.0},
          "with a larger share of absurd points the whole cloud is dropped");
    visit("min_view", p.view.min_view, "", Range{0.0, 1.0},
          "a camera with a smaller share of finite points than this is blind");
    visit("usual_view", p.view.usual_view, "", Range{0.0, 1.0},
          "and so is one with less than this part of the share it usually has");
    visit("least_cameras", p.view.least_cameras, "", Range{0.0, 1.0},
          "least share of the cameras that must see; with fewer nothing is published and the map grows stale");
    visit("frozen_after", p.pictures.frozen_after, "s", Range{0.0, 60.0},
          "a camera whose clouds are the same to the byte for so long, by their stamps, is frozen and left out; 0 for "
          "never: without noise every picture of a cell at rest is the same");
    visit("spot_after", p.pictures.spot_after, "s", Range{0.0, 3600.0},
          "a part of a camera's image that used to have readings and has had none for so long is named: dirt, or what "
          "swallows its light; 0 for never");
    visit("nearest", p.pictures.nearest, "m", Range{0.0, 5.0}, "a depth below this counts as no reading there");
    describeVisibility(p, visit);
  }

  perception::MergeParams mergeParams() const {
    perception::MergeParams params = merge;
    params.noise = {static_cast<float>(noise_base), static_cast<float>(noise_slope), static_cast<float>(noise_offset)};
    return params;
  }

 private:
  template <class Self, class Visitor>
  static void describeVisibility(Self& p, Visitor& visit) {
    visit("visibility", p.visibility, "", Choices{},
          "tell which cells the cameras see through and which are hidden: on the map, hidden_cells, coverage, "
          "diagnostics");
    visit("grid_node", p.grid_node, "", Choices{}, "node whose grid parameters hold for that");
    visit("visibility_rate", p.visibility_rate, "Hz", Range{0.1, 60.0}, "most hidden_cells in a second of wall time");
    visit("age_rate", p.age_rate, "Hz", Range{0.1, 60.0}, "most ages of the cells in a second of capture time");
    visit("visibility_sigmas", p.views.noise_sigmas, "", Range{0.0, 20.0},
          "a reading must lie beyond a cell by this many sigmas of its noise for the cell to be seen through");
    visit("camera_range", p.views.range, "m", Range{0.5, 100.0}, "greatest depth at which a camera measures");
    visit("unread_is_clear", p.views.unread_is_clear, "", Choices{},
          "a pixel without a reading has nothing in the camera's range; false: it says nothing");
  }

  template <class Self, class Visitor>
  static void describeBox(Self& p, Visitor& visit) {
    auto& m = p.merge;
    visit("voxel_size_x", m.voxel_size[0], "m", Range{0.001, 1.0}, "edge of a voxel along x");
    visit("voxel_size_y", m.voxel_size[1], "m", Range{0.001, 1.0}, "edge of a voxel along y");
    visit("voxel_size_z", m.voxel_size[2], "m", Range{0.001, 1.0}, "edge of a voxel along z");
    visit("x_min", m.box_min[0], "m", Range{-100.0, 100.0}, "lower limit of the points kept, world");
    visit("x_max", m.box_max[0], "m", Range{-100.0, 100.0}, "upper limit of the points kept, world");
    visit("y_min", m.box_min[1], "m", Range{-100.0, 100.0}, "lower limit of the points kept, world");
    visit("y_max", m.box_max[1], "m", Range{-100.0, 100.0}, "upper limit of the points kept, world");
    visit("z_min", m.box_min[2], "m", Range{-100.0, 100.0}, "lower limit of the points kept, world");
    visit("z_max", m.box_max[2], "m", Range{-100.0, 100.0}, "upper limit of the points kept, world");
  }
};

/// Parameters of node cluster_assoc.
struct ClusterAssocParams {
  /// Name of the node.
  static constexpr char kNode[] = "cluster_assoc";
  std::string backend = "fused";
  std::string association = "yarm";
  std::string merge_node = MergeCloudsParams::kNode;
  double seed_wait = 0.05;
  bool sync = false;
  perception::ClusterParams cluster;
  perception::AssociationParams assoc;
  perception::CameraWatchParams watch;

  /// Tells `visit` of each parameter: name, value, unit, what is allowed, meaning; docs/parameters.md is made of it.
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor& visit) {
    visit("backend", p.backend, "", Choices{{"fused", "pcl"}},
          "union-find over voxels, or PCL's EuclideanClusterExtraction");
    visit("association", p.association, "", Choices{{"yarm", "original"}},
          "the algorithm; original is there to compare with");
    visit("merge_node", p.merge_node, "", Choices{}, "node whose voxel and box parameters hold here too");
    visit("seed_wait", p.seed_wait, "s", Range{0.0, 5.0},
          "wall time a set waits for the seeds of its stamp, then takes the newest");
    visit("sync", p.sync, "", Choices{}, "lock-step: wait up to 20 s for what is missing, so that runs repeat exactly");
    visit("cluster_tolerance", p.cluster.tolerance, "m", Range{0.001, 1.0}, "voxels nearer than this are connected");
    visit("min_cluster_size", p.cluster.min_size, "voxels", Range{1, 1000000}, "smallest cluster");
    visit("max_cluster_size", p.cluster.max_size, "voxels", Range{1, 10000000}, "largest cluster");
    visit("search_radius", p.assoc.search_radius, "m", Range{0.01, 1.0},
          "reach of a seed, and of a robot over stray points");
    visit("shape_tolerance", p.assoc.shape_tolerance, "m", Range{0.0, 0.2},
          "how far a body may differ from its known shape");
    visit("noise_sigmas", p.assoc.noise_sigmas, "", Range{0.0, 20.0},
          "a known surface explains points up to this many sigmas of their noise from it");
    visit("unknown_min_points", p.assoc.unknown_min_points, "", Range{1, 1000},
          "fewest points in a set that speak for an unknown thing");
    visit("unknown_window", p.assoc.unknown_window, "sets", Range{1, 30},
          "sets looked back at for an unknown thing's persistence");
    visit("unknown_hits", p.assoc.unknown_hits, "sets", Range{1, 30},
          "sets of that window in which an unknown thing must show");
    visit("cloud_spacing", p.assoc.cloud_spacing, "m", Range{0.005, 0.5},
          "point spacing of clouds learnt in calibration");
    visit(
        "debris_size", p.assoc.debris_size, "m", Range{0.0, 1.0},
        "a thing nobody registered, at rest on a fixed body, is debris_auto_<n> when no edge of it is longer; 0: none");
    visit("debris_rest", p.assoc.debris_rest, "s", Range{0.1, 60.0}, "as long it must have been at rest for that");
    visit("camera_turn_warn", p.watch.warn_deg, "deg", Range{0.05, 90.0},
          "a camera whose points fit the known static surfaces better when turned by this is reported");
    visit("camera_turn_error", p.watch.error_deg, "deg", Range{0.05, 90.0}, "and by this, as an error");
    describeGrid(p.assoc.grid, visit);
  }

 private:
  template <class Grid, class Visitor>
  static void describeGrid(Grid& grid, Visitor& visit) {
    visit("gx", grid.size[0], "cells", Range{1, 1000}, "cells along x");
    visit("gy", grid.size[1], "cells", Range{1, 1000}, "cells along y");
    visit("gz", grid.size[2], "cells", Range{1, 1000}, "cells along z");
    visit("xmin", grid.min[0], "m", Range{-100.0, 100.0}, "lower bound of the mapped volume, world");
    visit("xmax", grid.max[0], "m", Range{-100.0, 100.0}, "upper bound (exclusive), world");
    visit("ymin", grid.min[1], "m", Range{-100.0, 100.0}, "lower bound of the mapped volume, world");
    visit("ymax", grid.max[1], "m", Range{-100.0, 100.0}, "upper bound (exclusive), world");
    visit("zmin", grid.min[2], "m", Range{-100.0, 100.0}, "lower bound of the mapped volume, world");
    visit("zmax", grid.max[2], "m", Range{-100.0, 100.0}, "upper bound (exclusive), world");
  }
};

/// Parameters of node database.
struct DatabaseParams {
  /// Name of the node.
  static constexpr char kNode[] = "database";
  double marker_rate = 5.0;
  double point_radius = 0.025;

  /// Tells `visit` of each parameter: name, value, unit, what is allowed, meaning; docs/parameters.md is made of it.
  template <class Self, class Visitor>
  static void describe(Self& p, Visitor& visit) {
    visit("marker_rate", p.marker_rate, "Hz", Range{0.1, 60.0},
          "most markers of the occupancy view in a second of wall time");
    visit("point_radius", p.point_radius, "m", Range{0.001, 0.2}, "predict_new_state: points are balls of this radius");
  }
};

}  // namespace yarm
