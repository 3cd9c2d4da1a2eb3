// Parameters of a node as one struct: name, default, unit, range and meaning stand once, in its describe().
//
//   struct ExampleParams {
//     static constexpr char kNode[] = "example";
//     double rate = 30.0;
//     template <class Self, class Visitor> static void describe(Self& p, Visitor& visit) {
//       visit("rate", p.rate, "Hz", Range{1.0, 100.0}, "how often");
//     }
//   };
//   const auto params = loadParams<ExampleParams>(private_handle);
//
// Unknown names, wrong types and values out of range are refused all at once.
#pragma once

#include <XmlRpcValue.h>
#include <ros/node_handle.h>

#include <cmath>
#include <initializer_list>
#include <limits>
#include <ostream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace yarm {

/// Parameters that cannot be used; the message names every one, its value and what is allowed.
struct ParamError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Allowed values, both ends included.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

/// Allowed texts.
struct Choices {
  std::vector<std::string> allowed;  ///< empty: any text
};

namespace detail {

inline std::string allowedText(const Range& range) {
  std::ostringstream text;
  text << range.low << " to " << range.high;
  return text.str();
}

inline std::string allowedText(const Choices& choices) {
  std::string text;
  for (const std::string& choice : choices.allowed) {
    text += (text.empty() ? "one of '" : ", '") + choice + "'";
  }
  return text.empty() ? "any" : text;
}

inline std::string valueText(bool value) {
  return value ? "true" : "false";
}
inline std::string valueText(const std::string& value) {
  return value;
}
inline std::string valueText(int value) {
  return std::to_string(value);
}
inline std::string valueText(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}
inline std::string valueText(const std::vector<std::string>& values) {
  std::string text = "[";
  for (const std::string& value : values) {
    text += (text.size() > 1 ? ", " : "") + value;
  }
  return text + "]";
}

/// Takes values out of a parameter server's struct, noting every fault.
class ParamReader {
 public:
  explicit ParamReader(XmlRpc::XmlRpcValue values) : values_(std::move(values)) {}

  template <class Value, class Allowed>
  void operator()(const std::string& name, Value& value, const std::string& unit, const Allowed& allowed,
                  const std::string& /*doc*/) {
    known_.insert(name);
    if (!values_.hasMember(name)) {
      return;
    }
    const std::string fault = take(values_[name], value, allowed);
    if (!fault.empty()) {
      std::ostringstream text;
      values_[name].write(text);
      note(name + " = " + text.str() + ": must be " + fault + (unit.empty() ? "" : " " + unit));
    }
  }

  /// Notes as faults what was given and not asked for.
  void noteUnknown() {
    for (auto& entry : values_) {
      if (known_.count(entry.first) == 0) {
        note(entry.first + ": unknown parameter");
      }
    }
  }

  /// Every fault, separated by "; "; empty when all is well.
  const std::string& faults() const { return faults_; }

 private:
  void note(const std::string& fault) { faults_ += (faults_.empty() ? "" : "; ") + fault; }

  static std::string take(XmlRpc::XmlRpcValue& raw, double& value, const Range& range) {
    if (raw.getType() == XmlRpc::XmlRpcValue::TypeInt) {
      value = static_cast<int>(raw);
    } else if (raw.getType() == XmlRpc::XmlRpcValue::TypeDouble) {
      value = static_cast<double>(raw);
    } else {
      return "a number";
    }
    return std::isfinite(value) && value >= range.low && value <= range.high ? "" : allowedText(range);
  }

  static std::string take(XmlRpc::XmlRpcValue& raw, int& value, const Range& range) {
    if (raw.getType() != XmlRpc::XmlRpcValue::TypeInt) {
      return "a whole number";
    }
    value = static_cast<int>(raw);
    return value >= range.low && value <= range.high ? "" : allowedText(range);
  }

  static std::string take(XmlRpc::XmlRpcValue& raw, bool& value, const Choices&) {
    if (raw.getType() != XmlRpc::XmlRpcValue::TypeBoolean) {
      return "true or false";
    }
    value = static_cast<bool>(raw);
    return "";
  }

  static std::string take(XmlRpc::XmlRpcValue& raw, std::string& value, const Choices& choices) {
    if (raw.getType() != XmlRpc::XmlRpcValue::TypeString) {
      return "text";
    }
    value = static_cast<std::string>(raw);
    for (const std::string& choice : choices.allowed) {
      if (value == choice) {
        return "";
      }
    }
    return choices.allowed.empty() ? "" : allowedText(choices);
  }

  static std::string take(XmlRpc::XmlRpcValue& raw, std::vector<std::string>& value, const Choices&) {
    if (raw.getType() != XmlRpc::XmlRpcValue::TypeArray) {
      return "a list of texts";
    }
    value.clear();
    for (int i = 0; i < raw.size(); ++i) {
      if (raw[i].getType() != XmlRpc::XmlRpcValue::TypeString) {
        return "a list of texts";
      }
      value.push_back(static_cast<std::string>(raw[i]));
    }
    return "";
  }

  XmlRpc::XmlRpcValue values_;
  std::set<std::string> known_;
  std::string faults_;
};

/// Writes one line a parameter: node, name, default, unit, allowed values, meaning; separated by tabs.
class ParamTable {
 public:
  ParamTable(std::ostream& out, std::string node) : out_(out), node_(std::move(node)) {}

  template <class Value, class Allowed>
  void operator()(const std::string& name, const Value& value, const std::string& unit, const Allowed& allowed,
                  const std::string& doc) {
    out_ << node_ << '\t' << name << '\t' << valueText(value) << '\t' << unit << '\t' << allowedText(allowed) << '\t'
         << doc << '\n';
  }

 private:
  std::ostream& out_;
  std::string node_;
};

}  // namespace detail

/// A parameter struct from plain values; where: the name used in the message of a ParamError.
template <class Params>
Params readParams(const XmlRpc::XmlRpcValue& values, const std::string& where) {
  Params params;
  detail::ParamReader reader(values);
  Params::describe(params, reader);
  reader.noteUnknown();
  if (!reader.faults().empty()) {
    throw ParamError(where + ": " + reader.faults());
  }
  return params;
}

/// The parameters in a node's private namespace. Throws ParamError naming every fault.
template <class Params>
Params loadParams(const ros::NodeHandle& handle) {
  XmlRpc::XmlRpcValue values;
  if (!handle.getParam("", values) || values.getType() != XmlRpc::XmlRpcValue::TypeStruct) {
    values.begin();  ///< an empty struct
  }
  return readParams<Params>(values, handle.getNamespace());
}

/// Writes a node's parameters as rows for docs/parameters.md, with their defaults.
template <class Params>
void printParams(std::ostream& out) {
  const Params params;
  detail::ParamTable table(out, Params::kNode);
  Params::describe(params, table);
}

}  // namespace yarm
