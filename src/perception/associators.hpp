// Factories of the two associations and what they share.
#pragma once

#include "yarm/perception/association.hpp"

#include <memory>

namespace yarm::perception {

[[nodiscard]] std::unique_ptr<Associator> makeYarmAssociator(const AssociationParams& params);
[[nodiscard]] std::unique_ptr<Associator> makeOriginalAssociator(const AssociationParams& params);

/// Throws std::invalid_argument naming every parameter that is out of range, its value and what is accepted.
void checkParams(const AssociationParams& params);

}  // namespace yarm::perception
