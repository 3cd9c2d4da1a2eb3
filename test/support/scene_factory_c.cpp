// The scene factory and the perception chain for Python, by ctypes: see perception_chain.py.
#include "scene_factory.hpp"

#include "yarm/perception/association.hpp"
#include "yarm/perception/camera_watch.hpp"
#include "yarm/perception/hiders.hpp"
#include "yarm/perception/merge.hpp"
#include "yarm/perception/occupancy.hpp"
#include "yarm/perception/visibility.hpp"

#include <algorithm>
#include <cstring>
#include <exception>
#include <memory>
#include <set>
#include <string>

namespace {

namespace pc = yarm::perception;

Eigen::Isometry3d poseOf(const double* row_major) {
  Eigen::Isometry3d T;
  T.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(row_major);
  return T;
}

/// Merge, association and grid behind one handle.
struct Chain {
  Chain(const char* backend, const char* associator)
      : merge(pc::makeBackend(backend, {}, {})),
        association(pc::makeAssociator(associator, {})),
        builder(pc::GridSpec{}),
        hiders(pc::GridSpec{}) {}

  /// What the cameras see of the cells, on the map just made.
  void see() {
    if (!voter) {
      voter = std::make_unique<pc::VisibilityVoter>(pc::GridSpec{}, pc::MergeParams{}, pc::VisibilityParams{},
                                                    clouds.size());
    }
    set.stamp_ns = clouds.front().stamp_ns;
    voter->vote(clouds, set, votes);
    map.update(votes);
    if (views != voter->views()) {
      views = voter->views();
      voter->coverage(coverage);
    }
    seen.cameras.clear();
    for (std::size_t camera = 0; camera < clouds.size(); ++camera) {
      seen.cameras.push_back(voter->place(camera));
    }
    map.describe(votes, coverage, seen);
    hidden_by = &hiders.find(*grid, seen);
  }

  std::unique_ptr<pc::MergeBackend> merge;
  std::unique_ptr<pc::Associator> association;
  pc::OccupancyBuilder builder;
  pc::CameraWatch watch;
  pc::MergedSet set;
  std::vector<pc::Seed> seeds;
  pc::Knowledge knowledge;
  pc::LinkPoses links;
  std::vector<pc::CameraCloud> clouds;
  std::set<std::string> grasping;
  pc::HiderFinder hiders;
  std::unique_ptr<pc::VisibilityVoter> voter;
  pc::VisibilityMap map;
  pc::CellVotes votes;
  pc::CellVotes coverage;
  pc::SeenCells seen;
  int views{0};
  const std::vector<std::uint32_t>* hidden_by{nullptr};
  const pc::AssociatedSet* result{nullptr};
  const pc::OccupancyGrid* grid{nullptr};
};

}  // namespace

extern "C" {

/// A chain, or null when a name is not known.
void* yarm_chain_new(const char* backend, const char* associator) {
  try {
    return std::make_unique<Chain>(backend, associator).release();
  } catch (const std::exception&) {
    return nullptr;
  }
}

void yarm_chain_free(void* chain) {
  const std::unique_ptr<Chain> owned(static_cast<Chain*>(chain));
}

/// Starts a set: forgets clouds, seeds, shapes and poses of the set before.
void yarm_chain_begin(void* chain) {
  auto* c = static_cast<Chain*>(chain);
  c->clouds.clear();
  c->seeds.clear();
  c->knowledge.clear();
  c->links.clear();
  c->grasping.clear();
}

/// Adds a camera: 16-byte points in its optical frame; T_world_camera is row-major 4 x 4. The data must live until
/// _run.
void yarm_chain_cloud(void* chain, const void* data, int width, int height, const double* T_world_camera,
                      long long stamp_ns) {
  pc::CameraCloud cloud;
  cloud.data = static_cast<const std::uint8_t*>(data);
  cloud.width = static_cast<std::size_t>(width);
  cloud.height = static_cast<std::size_t>(height);
  cloud.T_world_camera = poseOf(T_world_camera).cast<float>();
  cloud.stamp_ns = stamp_ns;
  static_cast<Chain*>(chain)->clouds.push_back(cloud);
}

/// Adds an object; returns 0 when its kind is not known.
int yarm_chain_object(void* chain, const char* name, const char* kind, int is_static, const char* seed_frame,
                      const double* T_world_seed) {
  auto* c = static_cast<Chain*>(chain);
  const auto known = pc::fromString(kind);
  if (!known) {
    return 0;
  }
  c->seeds.push_back({name, *known, is_static != 0, poseOf(T_world_seed), 0});
  c->knowledge[name].seed_frame = seed_frame;
  return 1;
}

/// Adds a frame of an object with its pose.
void yarm_chain_link(void* chain, const char* name, const char* frame, const double* T_world_frame) {
  auto* c = static_cast<Chain*>(chain);
  c->knowledge[name].link_frames.emplace_back(frame);
  c->links[frame] = poseOf(T_world_frame);
}

/// Gives the pose of a frame that is no link, such as that of a solid which moves by itself.
void yarm_chain_frame(void* chain, const char* frame, const double* T_world_frame) {
  static_cast<Chain*>(chain)->links[frame] = poseOf(T_world_frame);
}

/// Adds a known solid: shape 0 box, 1 sphere, 2 cylinder, 3 capsule; size as in Solid.
void yarm_chain_solid(void* chain, const char* name, const char* frame, int shape, const double* size,
                      const double* T_frame_solid) {
  pc::Solid solid;
  solid.shape = static_cast<pc::Solid::Shape>(shape);
  solid.size = Eigen::Vector3d(size[0], size[1], size[2]);
  solid.T_frame_solid = poseOf(T_frame_solid);
  solid.frame = frame;
  static_cast<Chain*>(chain)->knowledge[name].solids.push_back(solid);
}

/// Says that something hangs on a robot's hand.
void yarm_chain_grasping(void* chain, const char* robot) {
  static_cast<Chain*>(chain)->grasping.insert(robot);
}

/// Processes the set; returns the number of objects in the map.
int yarm_chain_run(void* chain, int calibrating) {
  auto* c = static_cast<Chain*>(chain);
  c->merge->merge(c->clouds, c->set);
  for (std::size_t camera = 0; camera < c->clouds.size(); ++camera) {
    if (c->clouds[camera].width * c->clouds[camera].height == 0) {
      c->set.absent.push_back(static_cast<std::int32_t>(camera));
    }
  }
  c->merge->cluster(c->set);
  c->result =
      &c->association->associate({&c->set, &c->seeds, &c->knowledge, &c->links, calibrating != 0, &c->grasping});
  c->grid = &c->builder.build(*c->result);
  return static_cast<int>(c->result->objects.size());
}

/// Judges what the cameras see of the cells, after _run: copies the states, 50 * 50 * 20 values, and for each cell that
/// is hidden or never seen who may hide it; returns how many these are. All sets must have as many cameras.
int yarm_chain_see(void* chain, signed char* states, unsigned* hidden_by) {
  auto* c = static_cast<Chain*>(chain);
  c->see();
  std::transform(c->seen.states.begin(), c->seen.states.end(), states,
                 [](pc::CellState state) { return static_cast<signed char>(state); });
  std::copy(c->hidden_by->begin(), c->hidden_by->end(), hidden_by);
  return static_cast<int>(c->hidden_by->size());
}

/// Shows the set to the camera watch, in place of _run.
void yarm_chain_watch(void* chain) {
  auto* c = static_cast<Chain*>(chain);
  c->merge->merge(c->clouds, c->set);
  c->watch.add({&c->set, &c->seeds, &c->knowledge, &c->links, false});
}

/// Copies up to `capacity` of the watch's fits, camera and turn in degrees; returns how many there are.
int yarm_chain_turns(void* chain, int* cameras, double* turned_deg, int capacity) {
  const std::vector<pc::CameraFit> fits = static_cast<Chain*>(chain)->watch.take();
  for (std::size_t i = 0; i < std::min(fits.size(), static_cast<std::size_t>(capacity)); ++i) {
    cameras[i] = fits[i].camera;
    turned_deg[i] = fits[i].turned_deg;
  }
  return static_cast<int>(fits.size());
}

/// Copies the grid, 50 * 50 * 20 values.
void yarm_chain_grid(void* chain, signed char* out) {
  const auto& cells = static_cast<Chain*>(chain)->grid->cells;
  std::copy(cells.begin(), cells.end(), out);
}

/// Name of an object of the map; valid until the next run.
const char* yarm_chain_name(void* chain, int object) {
  return static_cast<Chain*>(chain)->result->objects[static_cast<std::size_t>(object)].name.c_str();
}

/// Copies up to `capacity` cells of an object; returns how many it has.
int yarm_chain_cells(void* chain, int object, int* out, int capacity) {
  const auto& cells = static_cast<Chain*>(chain)->grid->object_cells[static_cast<std::size_t>(object)];
  std::copy_n(cells.begin(), std::min<std::size_t>(cells.size(), static_cast<std::size_t>(capacity)), out);
  return static_cast<int>(cells.size());
}

/// Copies what is seen of an object as a piece of debris: points, top x, y, z, axis, length, width; 0 when nothing is.
int yarm_chain_piece(void* chain, int object, double* out) {
  const auto& piece = static_cast<Chain*>(chain)->result->objects[static_cast<std::size_t>(object)].piece;
  if (!piece) {
    return 0;
  }
  out[0] = static_cast<double>(piece->points);
  std::copy_n(piece->top.data(), 3, out + 1);
  out[4] = piece->axis_rad;
  out[5] = piece->length;
  out[6] = piece->width;
  return 1;
}

/// Name of the robot that carries an object; empty for none. Valid until the next run.
const char* yarm_chain_carrier(void* chain, int object) {
  const auto& carried = static_cast<Chain*>(chain)->result->objects[static_cast<std::size_t>(object)].carried;
  return carried ? carried->robot.c_str() : "";
}

/// Number of points in the box.
int yarm_chain_points(void* chain) {
  return static_cast<int>(static_cast<Chain*>(chain)->set.points.size());
}

/// Copies the owner of each point: index of the object, -1 nobody.
void yarm_chain_owners(void* chain, int* out) {
  auto* c = static_cast<Chain*>(chain);
  std::fill_n(out, c->set.points.size(), -1);
  for (std::size_t o = 0; o < c->result->objects.size(); ++o) {
    for (const std::uint32_t i : c->result->objects[o].source) {
      out[i] = static_cast<int>(o);
    }
  }
}

/// A synthetic cell: renders the standard cell with its truth. Returns a handle.
void* yarm_factory_new(unsigned long long seed, double noise) {
  return std::make_unique<yarm::test::SceneFactory>(seed, noise).release();
}

void yarm_factory_free(void* factory) {
  const std::unique_ptr<yarm::test::SceneFactory> owned(static_cast<yarm::test::SceneFactory*>(factory));
}

/// Renders the cell with so many robots and debris into arrays of 4 cameras x 102400 pixels: points (4 floats each),
/// truth (index of the body, -1 floor, -2 nothing) and poses (row-major 4 x 4). Body order: table, stand, hc10_barc,
/// robots, debris.
void yarm_factory_render(void* factory, int robots, int debris, float* points, short* truth, double* poses) {
  const yarm::test::Scene scene = yarm::test::standardCell(robots, debris);
  for (const yarm::test::Render& r : static_cast<yarm::test::SceneFactory*>(factory)->render(scene)) {
    points = std::copy(r.data.begin(), r.data.end(), points);
    truth = std::copy(r.truth.begin(), r.truth.end(), truth);
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T = r.T_world_camera.matrix().cast<double>();
    poses = std::copy_n(T.data(), 16, poses);
  }
}

}  // extern "C"
