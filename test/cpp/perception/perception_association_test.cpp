// Association scored against the truth, ours and the original algorithm in one table.
#include "association_score.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace yarm::test {
namespace {

struct Row {
  Mean apart;
  Mean contact;
  int longest_gap{0};
  int longest_phantom{0};
};

std::string percent(const std::map<std::string, Mean>& by_object) {
  char text[16] = "-";
  if (!by_object.empty()) {
    std::snprintf(text, sizeof(text), "%.2f %%", 100 * Score::mean(by_object));
  }
  return text;
}

/// Runs one variant over all sequences and prints its lines of the table.
Row scoreVariant(const std::string& title, const std::string& associator,
                 const std::function<Sequence(Sequence)>& change, const Errors& errors = {}) {
  std::map<std::string, Mean> apart;
  std::map<std::string, Mean> contact;
  Row row;
  std::uint64_t seed = 100;
  for (const Sequence& sequence : scoredSequences()) {
    AssociationRun run(associator, seed++, errors);
    const Score score = run.run(change ? change(sequence) : sequence);
    std::printf("| %-22s | %-20s | %8s | %8s |\n", title.c_str(), sequence.name.c_str(), percent(score.apart).c_str(),
                percent(score.contact).c_str());
    for (const auto& [name, mean] : score.apart) {
      row.apart.add(mean.value());
      if (mean.value() < 0.98 && associator == "yarm") {
        std::printf("|   apart %-30s %6.2f %% of %d sets\n", name.c_str(), 100 * mean.value(), mean.count);
      }
    }
    for (const auto& [name, mean] : score.contact) {
      row.contact.add(mean.value());
      if (mean.value() < 0.95 && associator == "yarm") {
        std::printf("|   contact %-28s %6.2f %% of %d sets\n", name.c_str(), 100 * mean.value(), mean.count);
      }
    }
    row.longest_gap = std::max(row.longest_gap, score.longest_gap);
    row.longest_phantom = std::max(row.longest_phantom, score.longest_phantom);
  }
  std::printf("| %-22s | %-20s | %6.2f %% | %6.2f %% | longest gap %d, phantom %d\n", title.c_str(), "ALL",
              100 * row.apart.value(), 100 * row.contact.value(), row.longest_gap, row.longest_phantom);
  return row;
}

TEST(Association, IsRightApartAndInContact) {
  const Row yarm = scoreVariant("yarm", "yarm", {});
  const Row original = scoreVariant("original", "original", {});
  EXPECT_GE(yarm.apart.value(), 0.98);
  EXPECT_GE(yarm.contact.value(), 0.90);
  EXPECT_LE(yarm.longest_gap, 1);
  EXPECT_LE(yarm.longest_phantom, 1);
  EXPECT_LT(original.apart.value(), yarm.apart.value());
  EXPECT_LT(original.contact.value(), yarm.contact.value());
}

TEST(Association, BearsPosesThatAreOff) {
  const Row row = scoreVariant("yarm, poses off 5 mm", "yarm", {}, Errors::ofPoses(0.005));
  EXPECT_GE(row.apart.value(), 0.98);
  EXPECT_GE(row.contact.value(), 0.90);
  EXPECT_LE(row.longest_phantom, 1);
}

TEST(Association, LearnsRobotsWithoutShapes) {
  const Row row = scoreVariant("yarm, robots undrawn", "yarm", [](Sequence s) { return withoutRobotShapes(s); });
  EXPECT_GE(row.apart.value(), 0.97);
  EXPECT_GE(row.contact.value(), 0.92);
  EXPECT_LE(row.longest_gap, 1);
}

TEST(Association, WorksWithoutTheShapesOfMovingBodies) {
  const Row row = scoreVariant("yarm, fixtures only", "yarm", [](Sequence s) { return withoutShapes(std::move(s)); });
  EXPECT_GE(row.apart.value(), 0.92);
  EXPECT_GE(row.contact.value(), 0.88);
}

}  // namespace
}  // namespace yarm::test
