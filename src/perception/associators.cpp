#include "associators.hpp"

#include <sstream>
#include <stdexcept>

namespace yarm::perception {

void checkParams(const AssociationParams& params) {
  std::ostringstream faults;
  const auto require = [&](bool good, const char* name, double value, const char* accepted) {
    if (!good) {
      faults << (faults.tellp() > 0 ? "; " : "") << name << " = " << value << " (" << accepted << ")";
    }
  };
  for (std::size_t a = 0; a < 3; ++a) {
    require(params.grid.size[a] >= 1, "grid size", params.grid.size[a], "1 or more cells");
    require(params.grid.min[a] < params.grid.max[a], "grid min", params.grid.min[a], "less than max");
  }
  require(params.search_radius > 0.0 && params.search_radius <= 2.0, "search_radius", params.search_radius,
          "above 0 .. 2 m");
  require(params.shape_tolerance >= 0.001 && params.shape_tolerance <= 0.1, "shape_tolerance", params.shape_tolerance,
          "0.001 .. 0.1 m");
  require(params.noise_sigmas > 0.0 && params.noise_sigmas <= 10.0, "noise_sigmas", params.noise_sigmas,
          "above 0 .. 10");
  require(params.unknown_min_points >= 1, "unknown_min_points", params.unknown_min_points, "1 or more");
  require(params.unknown_window >= 1 && params.unknown_window <= 30, "unknown_window", params.unknown_window,
          "1 .. 30 sets");
  require(params.unknown_hits >= 1 && params.unknown_hits <= params.unknown_window, "unknown_hits", params.unknown_hits,
          "1 .. unknown_window");
  require(params.cloud_spacing >= 0.01 && params.cloud_spacing <= 0.5, "cloud_spacing", params.cloud_spacing,
          "0.01 .. 0.5 m");
  require(params.debris_size >= 0.0 && params.debris_size <= 1.0, "debris_size", params.debris_size, "0 .. 1 m");
  require(params.debris_rest >= 0.1 && params.debris_rest <= 60.0, "debris_rest", params.debris_rest, "0.1 .. 60 s");
  if (faults.tellp() > 0) {
    throw std::invalid_argument("association parameters refused: " + faults.str());
  }
}

std::unique_ptr<Associator> makeAssociator(const std::string& name, const AssociationParams& params) {
  checkParams(params);
  if (name == "yarm") {
    return makeYarmAssociator(params);
  }
  if (name == "original") {
    return makeOriginalAssociator(params);
  }
  throw std::invalid_argument("associator '" + name + "' is not known: yarm or original");
}

}  // namespace yarm::perception
