// Codec parameters: each codec declares names, types, defaults and ranges; the command line, the
// YAML check and the lists are made from these declarations. On the command line and in files a
// parameter is written `name=value`.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volumes/error.hpp"

namespace cvr::codecs {

enum class ParameterType : std::uint8_t {
  kInteger,  ///< one of `choices` if there are any, else minimum..maximum
  kTriple,   ///< three integers "x,y,z", each minimum..maximum
  kText,     ///< one of `names`
};

struct ParameterSpec {
  std::string_view name;
  ParameterType type;
  std::string_view default_value;
  std::int64_t minimum = 0;
  std::int64_t maximum = 0;
  std::vector<std::int64_t> choices = {};
  std::vector<std::string_view> names = {};
  std::string_view description;
};

std::string_view name_of(ParameterType type);
/// "16, 32, 64", "0..9" or "x,y,z, each 1..64".
std::string describe_range(const ParameterSpec& spec);

/// A complete, checked set of values: every declared parameter has one.
class Parameters {
 public:
  Parameters() = default;
  /// Reads "name=value" strings; what is not named takes its default. Fails on unknown names,
  /// repeated names, malformed values and values out of range, naming the parameter and what is
  /// allowed.
  static volumes::Expected<Parameters> parse(std::span<const ParameterSpec> specs,
                                             std::span<const std::string> assignments);

  std::int64_t integer(std::string_view name) const;
  std::array<std::uint32_t, 3> triple(std::string_view name) const;
  const std::string& text(std::string_view name) const;

  /// "brick=32;delta=0", in the order of the names: the form that the envelope stores and that
  /// identifies a cell.
  std::string canonical() const;
  /// The same for readers: what differs from the defaults; "defaults" where nothing does, "" where
  /// nothing is declared.
  std::string changes(std::span<const ParameterSpec> specs) const;
  /// The values by name, as canonical text.
  const std::map<std::string, std::string, std::less<>>& values() const { return values_; }

 private:
  std::map<std::string, std::string, std::less<>> values_;
};

/// Splits the canonical form into assignments.
std::vector<std::string> split_canonical(std::string_view canonical);

}  // namespace cvr::codecs
