// How the association bears what it is told wrongly: one curve an error, over the scored courses of the tests.
//
// Usage: robustness_bench SEEDS FILE.csv [ERROR]   (ERROR: that curve alone, for instance "tf late")
#include "association_score.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

namespace {

using yarm::test::Errors;
constexpr double kDegree = M_PI / 180.0;
constexpr double kRobotMps = 0.5;  // what a late stamp is worth

struct Curve {
  std::string error;
  std::string unit;
  std::vector<double> levels;
  std::function<void(Errors&, double)> set;
};

std::vector<Curve> curves() {
  return {
      {"pose", "mm", {0, 5, 10, 15, 20, 30}, [](Errors& e, double v) { e.pose_m = 1e-3 * v; }},
      {"heading", "deg", {0.5, 1, 2, 3}, [](Errors& e, double v) { e.turn_rad = v * kDegree; }},
      {"shape", "%", {2, 5, 10, 15}, [](Errors& e, double v) { e.shape = 0.01 * v; }},
      {"one camera turned",
       "deg",
       {0.25, 0.5, 1, 2},
       [](Errors& e, double v) {
         e.cameras.off.rotate(Eigen::AngleAxisf(static_cast<float>(v * kDegree), Eigen::Vector3f::UnitX()));
       }},
      {"depth",
       "%",
       {0.25, 0.5, 1, 2},
       [](Errors& e, double v) { e.cameras.depth_scale = static_cast<float>(1.0 + 0.01 * v); }},
      {"tf late", "ms", {20, 50, 100, 200, 400}, [](Errors& e, double v) { e.lag_m = kRobotMps * 1e-3 * v; }},
      {"tf jitter", "ms", {20, 50, 100, 200}, [](Errors& e, double v) { e.jitter_m = kRobotMps * 1e-3 * v; }},
  };
}

struct Result {
  yarm::test::Mean apart;
  yarm::test::Mean contact;
  int phantoms{0};
  int gap{0};
};

Result run(const Errors& errors, std::uint64_t seed, bool drawn) {
  Result result;
  for (const yarm::test::Sequence& sequence : yarm::test::scoredSequences()) {
    yarm::test::AssociationRun course("yarm", seed++, errors);
    const yarm::test::Score score = course.run(drawn ? sequence : yarm::test::withoutRobotShapes(sequence));
    for (const auto& [name, mean] : score.apart) {
      result.apart.add(mean.value());
    }
    for (const auto& [name, mean] : score.contact) {
      result.contact.add(mean.value());
    }
    result.phantoms += score.phantom_sets;
    result.gap = std::max(result.gap, score.longest_gap);
  }
  return result;
}

void write(std::FILE* file, const std::string& error, const std::string& unit, double level, int seed,
           const Result& found) {
  std::fprintf(file, "%s,%s,%g,%d,%.4f,%.4f,%d,%d\n", error.c_str(), unit.c_str(), level, seed, found.apart.value(),
               found.contact.value(), found.phantoms, found.gap);
  std::fflush(file);
  std::printf("%-18s %5g %-3s seed %d: apart %.3f, contact %.3f, %d sets with a phantom\n", error.c_str(), level,
              unit.c_str(), seed, found.apart.value(), found.contact.value(), found.phantoms);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc == 3 || argc == 4 ? std::atoi(argv[1]) : 0;
  const std::string only = argc == 4 ? argv[3] : "";
  std::FILE* file = seeds > 0 ? std::fopen(argv[2], "w") : nullptr;
  if (file == nullptr) {
    std::fprintf(stderr, "usage: robustness_bench SEEDS FILE.csv [ERROR] (SEEDS from 1; FILE must be writable)\n");
    return 2;
  }
  std::fprintf(file, "error,unit,level,seed,apart,contact,phantom_sets,longest_gap\n");
  for (int seed = 1; seed <= seeds; ++seed) {
    if (only.empty()) {
      write(file, "robots undrawn", "", 1.0, seed, run({}, 100 * seed, false));
    }
    for (const Curve& curve : curves()) {
      for (const double level : only.empty() || only == curve.error ? curve.levels : std::vector<double>()) {
        Errors errors;
        curve.set(errors, level);
        write(file, curve.error, curve.unit, level, seed, run(errors, 100 * seed, true));
      }
    }
  }
  std::fclose(file);
  return 0;
}
