#include "assignment.hpp"

#include <algorithm>
#include <limits>

namespace yarm::perception {

namespace {

/// Adds row after row by the cheapest augmenting path. Index 0 of rows and columns stands for none.
class Hungarian {
 public:
  /// The columns behind the given ones are each row's own way to stay without.
  Hungarian(const std::vector<std::vector<double>>& costs, double unassigned)
      : costs_(costs),
        unassigned_(unassigned),
        given_(costs.empty() ? 0 : costs.front().size()),
        row_potential_(costs.size() + 1, 0.0),
        column_potential_(given_ + costs.size() + 1, 0.0),
        row_of_(column_potential_.size(), 0),
        before_(column_potential_.size(), 0) {}

  std::vector<int> solve() {
    for (std::size_t row = 1; row < row_potential_.size(); ++row) {
      std::size_t column = reachFreeColumn(row);
      while (column != 0) {
        row_of_[column] = row_of_[before_[column]];
        column = before_[column];
      }
    }
    std::vector<int> column_of(costs_.size(), kUnassigned);
    for (std::size_t column = 1; column <= given_; ++column) {
      if (row_of_[column] != 0) {
        column_of[row_of_[column] - 1] = static_cast<int>(column) - 1;
      }
    }
    return column_of;
  }

 private:
  [[nodiscard]] double cost(std::size_t row, std::size_t column) const {
    if (column > given_) {
      return column - given_ == row ? unassigned_ : kNever;
    }
    const double c = costs_[row - 1][column - 1];
    return c < unassigned_ ? c : kNever;
  }

  /// Dijkstra over reduced costs from a row to the nearest column that no row has; fills before_.
  std::size_t reachFreeColumn(std::size_t row) {
    std::vector<double> distance(row_of_.size(), std::numeric_limits<double>::infinity());
    std::vector<char> done(row_of_.size(), 0);
    row_of_[0] = row;
    std::size_t column = 0;
    do {
      done[column] = 1;
      const std::size_t from = row_of_[column];
      double least = std::numeric_limits<double>::infinity();
      std::size_t next = 0;
      for (std::size_t j = 1; j < row_of_.size(); ++j) {
        if (done[j] != 0) {
          continue;
        }
        const double reduced = cost(from, j) - row_potential_[from] - column_potential_[j];
        if (reduced < distance[j]) {
          distance[j] = reduced;
          before_[j] = column;
        }
        if (distance[j] < least) {
          least = distance[j];
          next = j;
        }
      }
      for (std::size_t j = 0; j < row_of_.size(); ++j) {
        if (done[j] != 0) {
          row_potential_[row_of_[j]] += least;
          column_potential_[j] -= least;
        } else {
          distance[j] -= least;
        }
      }
      column = next;
    } while (row_of_[column] != 0);
    return column;
  }

  static constexpr double kNever = 1e12;

  const std::vector<std::vector<double>>& costs_;
  double unassigned_;
  std::size_t given_;
  std::vector<double> row_potential_;
  std::vector<double> column_potential_;
  std::vector<std::size_t> row_of_;
  std::vector<std::size_t> before_;
};

}  // namespace

std::vector<int> assignAtLeastCost(const std::vector<std::vector<double>>& costs, double unassigned) {
  return Hungarian(costs, unassigned).solve();
}

}  // namespace yarm::perception
