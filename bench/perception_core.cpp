// Compute per camera set, stage by stage, of both back ends on the same clouds in the same run.
//   perception_core [sets [CSV]]     prints percentiles of CPU time, and page faults; see bench/README.md
// A row a set and back end goes to the CSV.
#include "scene_factory.hpp"

#include "yarm/perception/association.hpp"
#include "yarm/perception/hiders.hpp"
#include "yarm/perception/merge.hpp"
#include "yarm/perception/occupancy.hpp"
#include "yarm/perception/visibility.hpp"

#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>

namespace {

namespace pc = yarm::perception;

constexpr int kDistinctSets = 8;
constexpr int kCalibration = 4;
constexpr int kCameras = 4;

/// Milliseconds of every set, by stage.
using Samples = std::map<std::string, std::vector<double>>;

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

long pageFaults() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

/// Processor time of this thread: compute, whoever else wants the cores.
double cpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

class Stopwatch {
 public:
  explicit Stopwatch(Samples& samples) : samples_(samples), start_(cpuSeconds()), last_(start_) {}
  void lap(const std::string& stage) {
    const double now = cpuSeconds();
    samples_[stage].push_back(1e3 * (now - last_));
    last_ = now;
  }
  void total() { samples_["total"].push_back(1e3 * (cpuSeconds() - start_)); }

 private:
  Samples& samples_;
  double start_;
  double last_;
};

/// Association that looks for debris which nobody registered up to this edge, metres; 0: for none.
pc::AssociationParams withStrays(double debris_size) {
  pc::AssociationParams params;
  params.debris_size = debris_size;
  return params;
}

/// Telling free from hidden: votes of the cameras, the cells' states, and who hides them.
class Visibility {
 public:
  void vote(const std::vector<pc::CameraCloud>& clouds, const pc::MergedSet& set, Stopwatch& watch) {
    voter_.vote(clouds, set, votes_);
    watch.lap("5 votes");
    if (coverage_.through.empty()) {
      voter_.coverage(coverage_);
      for (std::size_t camera = 0; camera < kCameras; ++camera) {
        seen_.cameras.push_back(voter_.place(camera));
      }
      watch.lap("(coverage)");
    }
  }

  void describe(const pc::OccupancyGrid& grid, Stopwatch& watch) {
    map_.update(votes_);
    map_.describe(votes_, coverage_, seen_);
    watch.lap("6 states");
    hidden_ = finder_.find(grid, seen_).size();
    watch.lap("7 who hides");
  }

  [[nodiscard]] std::size_t hidden() const { return hidden_; }

 private:
  pc::VisibilityVoter voter_{pc::GridSpec{}, {}, {}, kCameras};
  pc::VisibilityMap map_;
  pc::HiderFinder finder_{pc::GridSpec{}};
  pc::CellVotes votes_;
  pc::CellVotes coverage_;
  pc::SeenCells seen_;
  std::size_t hidden_{0};
};

/// One back end with everything behind it.
class Chain {
 public:
  Chain(const std::string& backend, const pc::MergeParams& params, double debris_size = 0.0,
        Visibility* visibility = nullptr)
      : backend_(pc::makeBackend(backend, params, {})),
        associator_(pc::makeAssociator("yarm", withStrays(debris_size))),
        grid_(pc::GridSpec{}),
        visibility_(visibility) {}

  void process(const std::vector<pc::CameraCloud>& clouds, const yarm::test::Scene& scene, bool calibrating) {
    const auto seeds = scene.seeds(clouds.front().stamp_ns);
    const auto knowledge = scene.knowledge();
    Stopwatch watch(samples_);
    backend_->merge(clouds, set_);
    watch.lap("1 merge");
    if (visibility_ != nullptr) {
      visibility_->vote(clouds, set_, watch);
    }
    backend_->cluster(set_);
    watch.lap("2 cluster");
    const pc::AssociatedSet& result = associator_->associate({&set_, &seeds, &knowledge, &scene.poses, calibrating});
    watch.lap("3 associate");
    const pc::OccupancyGrid& grid = grid_.build(result);
    watch.lap("4 grid");
    if (visibility_ != nullptr) {
      visibility_->describe(grid, watch);
    }
    watch.total();
  }

  void countFaults(long faults) { faults_ += faults; }
  void forget() {
    samples_.clear();
    faults_ = 0;
  }
  [[nodiscard]] const Samples& samples() const { return samples_; }
  [[nodiscard]] double faults() const {
    return static_cast<double>(faults_) / static_cast<double>(samples_.at("total").size());
  }
  [[nodiscard]] const pc::MergedSet& set() const { return set_; }

 private:
  std::unique_ptr<pc::MergeBackend> backend_;
  std::unique_ptr<pc::Associator> associator_;
  pc::OccupancyBuilder grid_;
  Visibility* visibility_;
  pc::MergedSet set_;
  Samples samples_;
  long faults_{0};
};

/// The raw rows: what every single set cost. Nothing is kept without a path.
class RawRows {
 public:
  explicit RawRows(const std::string& path) {
    if (!path.empty()) {
      file_.open(path);
      if (!file_) {
        throw std::runtime_error("cannot write " + path + ": does its folder exist?");
      }
      file_ << "case,value,backend,set,merge_ms,cluster_ms,associate_ms,grid_ms,total_ms\n";
    }
  }

  void add(const std::string& title, double value, const std::string& backend, const Samples& samples) {
    for (std::size_t set = 0; file_.is_open() && set < samples.at("total").size(); ++set) {
      file_ << title << ',' << value << ',' << backend << ',' << set;
      for (const auto& [stage, times] : samples) {  // "1 merge" to "4 grid", then "total"
        file_ << ',' << times[set];
      }
      file_ << '\n';
    }
  }

 private:
  std::ofstream file_;
};

void measured(Chain& chain, const std::vector<pc::CameraCloud>& clouds, const yarm::test::Scene& scene,
              bool calibrating) {
  const long faults = pageFaults();
  chain.process(clouds, scene, calibrating);
  chain.countFaults(pageFaults() - faults);
}

/// Runs both chains, set by set in turn, over the same clouds.
void race(const yarm::test::Scene& scene, int cameras, int sets, yarm::test::CameraModel model, Chain& one,
          Chain& other) {
  std::vector<yarm::test::SceneFactory> factories;
  std::vector<std::vector<pc::CameraCloud>> recorded;
  for (int i = 0; i < kDistinctSets; ++i) {
    factories.emplace_back(static_cast<std::uint64_t>(i + 1), 1.0, cameras, model);
    factories.back().render(scene);
  }
  for (const auto& factory : factories) {
    recorded.push_back(factory.clouds(1));
  }
  for (int i = 0; i < kCalibration + kDistinctSets + sets; ++i) {
    if (i == kCalibration + kDistinctSets) {
      one.forget();
      other.forget();
    }
    const auto& clouds = recorded[static_cast<std::size_t>(i % kDistinctSets)];
    measured(one, clouds, scene, i < kCalibration);
    measured(other, clouds, scene, i < kCalibration);
  }
}

void printTable(const char* title, const Chain& fused, const Chain& pcl) {
  std::printf("\n%s: %zu points in the box, %zu voxels, %zu clusters\n", title, fused.set().points.size(),
              fused.set().centroids.size(), fused.set().clusters.size());
  std::printf("| %-12s | %-21s | %-21s | ratio |\n", "CPU ms a set", "fused p50      p99", "pcl p50        p99");
  for (const auto& [stage, values] : fused.samples()) {
    const auto other = pcl.samples().find(stage);
    std::printf("| %-12s | %9.3f %11.3f |", stage.c_str(), percentile(values, 0.5), percentile(values, 0.99));
    if (other == pcl.samples().end()) {
      std::printf(" %21s |       |\n", "");
    } else {
      const double half = percentile(other->second, 0.5);
      std::printf(" %9.3f %11.3f | %5.1f |\n", half, percentile(other->second, 0.99), half / percentile(values, 0.5));
    }
  }
  std::printf("| %-12s | %9.1f %11s | %9.1f %11s |       |\n", "page faults", fused.faults(), "", pcl.faults(), "");
}

void compare(RawRows& rows, const char* name, const char* title, const yarm::test::Scene& scene, int sets,
             const pc::MergeParams& params) {
  Chain fused("fused", params);
  Chain pcl("pcl", params);
  race(scene, kCameras, sets, {}, fused, pcl);
  printTable(title, fused, pcl);
  rows.add(name, kCameras, "fused", fused.samples());
  rows.add(name, kCameras, "pcl", pcl.samples());
}

/// One line a setting: name, value, p50 of fused and pcl.
void sweep(RawRows& rows, const char* name, double value, const yarm::test::Scene& scene, int cameras, int sets,
           yarm::test::CameraModel model) {
  Chain fused("fused", {});
  Chain pcl("pcl", {});
  race(scene, cameras, sets, model, fused, pcl);
  std::printf("%-8s %8g %9.4f %9.4f\n", name, value, percentile(fused.samples().at("total"), 0.5),
              percentile(pcl.samples().at("total"), 0.5));
  rows.add(name, value, "fused", fused.samples());
  rows.add(name, value, "pcl", pcl.samples());
}

/// What looking for debris that nobody registered costs, set by set in turn with the same chain that does not look.
void measureStrays(const yarm::test::Scene& scene, int sets) {
  Chain looking("fused", {}, pc::AssociationParams().debris_size);
  Chain plain("fused", {});
  race(scene, kCameras, sets, {}, looking, plain);
  const auto associate = [](const Chain& chain, double share) {
    return percentile(chain.samples().at("3 associate"), share);
  };
  std::printf("\nassociate, CPU ms a set: p50, p99\nplain          %9.3f %9.3f\nstray debris   %9.3f %9.3f\n",
              associate(plain, 0.5), associate(plain, 0.99), associate(looking, 0.5), associate(looking, 0.99));
}

/// What telling free from hidden costs: the fused back end with it beside `pcl` without.
void measureVisibility(const yarm::test::Scene& scene, int sets) {
  Visibility visibility;
  Chain fused("fused", {}, 0.0, &visibility);
  Chain pcl("pcl", {});
  race(scene, kCameras, sets, {}, fused, pcl);
  printTable("the first again, fused with visibility", fused, pcl);
  std::printf("%zu cells that no camera sees\n", visibility.hidden());
}

void measureAll(int sets, RawRows& rows) {
  const yarm::test::Scene scene = yarm::test::standardCell(2, 2);
  pc::MergeParams fine;
  fine.voxel_size[2] = 0.001;
  compare(rows, "cell_2_2", "2 robots, 2 debris, HC10; voxel 0.1 x 0.1 x 0.1 m", scene, sets, {});
  compare(rows, "cell_2_2_fine", "the same; voxel 0.1 x 0.1 x 0.001 m", scene, sets / 2, fine);
  compare(rows, "cell_3_3", "3 robots, 3 debris, HC10", yarm::test::standardCell(3, 3), sets / 2, {});
  measureVisibility(scene, sets);
  measureStrays(scene, sets);
  std::printf("\nwhat, value, fused ms, pcl ms (p50)\n");
  for (int cameras = 1; cameras <= 8; ++cameras) {
    sweep(rows, "cameras", cameras, scene, cameras, sets / 4, {});
  }
  for (const int edge : {80, 160, 240, 320, 480, 640}) {
    yarm::test::CameraModel model;
    model.width = model.height = edge;
    sweep(rows, "points", 4.0 * edge * edge, scene, kCameras, sets / 4, model);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    RawRows rows(argc > 2 ? argv[2] : "");
    measureAll(argc > 1 ? std::max(10, std::atoi(argv[1])) : 200, rows);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "perception_core_bench: %s\n", error.what());
    return 1;
  }
  return 0;
}
