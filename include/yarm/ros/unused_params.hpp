// Parameters that are taken for the sake of another node's users and have no effect.
#pragma once

#include "yarm/ros/params.hpp"

#include <map>
#include <string>

namespace yarm {

namespace detail {

// Collects names with their values as text.
struct ValueTexts {
  std::map<std::string, std::string> by_name;

  template <class Value, class Allowed>
  void operator()(const std::string& name, const Value& value, const std::string& /*unit*/, const Allowed& /*allowed*/,
                  const std::string& /*doc*/) {
    by_name[name] = valueText(value);
  }
};

}  // namespace detail

/// Names of the parameters that were set to something of the user's, separated by commas; empty when none was.
template <class Params>
std::string changedNames(const Params& params) {
  detail::ValueTexts defaults;
  detail::ValueTexts set;
  const Params untouched;
  Params::describe(untouched, defaults);
  Params::describe(params, set);
  std::string names;
  for (const auto& [name, value] : set.by_name) {
    if (value != defaults.by_name[name]) {
      names += (names.empty() ? "" : ", ") + name;
    }
  }
  return names;
}

}  // namespace yarm
