#include "codecs/parameters.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "volumes/enum_names.hpp"
#include "volumes/number_text.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::codecs {

using volumes::ErrorCode;
using volumes::Expected;
using volumes::fail;

namespace {

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0;;) {
    const std::size_t end = text.find(separator, at);
    parts.push_back(text.substr(at, end == std::string_view::npos ? end : end - at));
    if (end == std::string_view::npos) return parts;
    at = end + 1;
  }
}

/// The canonical text of a value, or nothing if it is not allowed.
std::optional<std::string> check(const ParameterSpec& spec, std::string_view value) {
  const auto in_range = [&spec](std::int64_t n) {
    if (!spec.choices.empty()) return std::ranges::find(spec.choices, n) != spec.choices.end();
    return n >= spec.minimum && n <= spec.maximum;
  };
  if (spec.type == ParameterType::kText) {
    if (std::ranges::find(spec.names, value) == spec.names.end()) return std::nullopt;
    return std::string(value);
  }
  const std::size_t count = spec.type == ParameterType::kTriple ? 3 : 1;
  const auto parts = split(value, ',');
  if (parts.size() != count) return std::nullopt;
  std::vector<std::int64_t> numbers;
  for (const std::string_view part : parts) {
    const auto number = volumes::parse_signed(part);
    if (!number || !in_range(*number)) return std::nullopt;
    numbers.push_back(*number);
  }
  return fmt::format("{}", fmt::join(numbers, ","));
}

}  // namespace

std::string_view name_of(ParameterType type) {
  static constexpr auto kNames =
      volumes::enum_names<ParameterType>({{ParameterType::kInteger, "integer"},
                                          {ParameterType::kTriple, "triple"},
                                          {ParameterType::kText, "text"}});
  return kNames.of(type);
}

std::string describe_range(const ParameterSpec& spec) {
  if (spec.type == ParameterType::kText) return fmt::format("{}", fmt::join(spec.names, ", "));
  if (spec.type == ParameterType::kTriple)
    return fmt::format("x,y,z, each {}..{}", spec.minimum, spec.maximum);
  if (!spec.choices.empty()) return fmt::format("{}", fmt::join(spec.choices, ", "));
  return fmt::format("{}..{}", spec.minimum, spec.maximum);
}

Expected<Parameters> Parameters::parse(std::span<const ParameterSpec> specs,
                                       std::span<const std::string> assignments) {
  Parameters parameters;
  for (const std::string& assignment : assignments) {
    const std::size_t equals = assignment.find('=');
    const std::string_view name = std::string_view(assignment).substr(0, equals);
    const auto spec = std::ranges::find(specs, name, &ParameterSpec::name);
    if (spec == specs.end()) {
      std::vector<std::string> known;
      for (const ParameterSpec& s : specs) known.emplace_back(s.name);
      return fail(
          ErrorCode::kBadArgument,
          fmt::format("unknown parameter '{}'; expected one of: {}{}", volumes::printable(name),
                      known.empty() ? "(none)" : fmt::format("{}", fmt::join(known, ", ")),
                      volumes::did_you_mean(name, known)));
    }
    if (equals == std::string::npos) {
      return fail(ErrorCode::kBadArgument,
                  fmt::format("parameter '{}': expected {}=VALUE", assignment, name));
    }
    const std::string_view value = std::string_view(assignment).substr(equals + 1);
    const auto canonical = check(*spec, value);
    if (!canonical) {
      return fail(ErrorCode::kBadArgument,
                  fmt::format("parameter '{}': expected {}, {}", name, describe_range(*spec),
                              volumes::found_number(value)));
    }
    if (!parameters.values_.emplace(name, *canonical).second) {
      return fail(ErrorCode::kBadArgument, fmt::format("parameter '{}' is given twice", name));
    }
  }
  for (const ParameterSpec& spec : specs)
    parameters.values_.try_emplace(std::string(spec.name), spec.default_value);
  return parameters;
}

const std::string& Parameters::text(std::string_view name) const {
  const auto found = values_.find(name);
  if (found == values_.end())
    throw std::logic_error(fmt::format("parameter '{}' is not declared", name));
  return found->second;
}

std::int64_t Parameters::integer(std::string_view name) const {
  return volumes::parse_signed(text(name)).value();
}

std::array<std::uint32_t, 3> Parameters::triple(std::string_view name) const {
  const auto parts = split(text(name), ',');
  std::array<std::uint32_t, 3> numbers{};
  for (std::size_t i = 0; i < 3; ++i)
    numbers[i] = static_cast<std::uint32_t>(volumes::parse_signed(parts.at(i)).value());
  return numbers;
}

std::string Parameters::canonical() const {
  std::string text;
  for (const auto& [name, value] : values_)
    text += fmt::format("{}{}={}", text.empty() ? "" : ";", name, value);
  return text;
}

std::string Parameters::changes(std::span<const ParameterSpec> specs) const {
  std::string text;
  for (const ParameterSpec& spec : specs) {
    const auto found = values_.find(spec.name);
    if (found == values_.end() || found->second == spec.default_value ||
        found->second == check(spec, spec.default_value))
      continue;
    text += fmt::format("{}{}={}", text.empty() ? "" : " ", spec.name, found->second);
  }
  return text.empty() && !specs.empty() ? "defaults" : text;
}

std::vector<std::string> split_canonical(std::string_view canonical) {
  std::vector<std::string> assignments;
  if (canonical.empty()) return assignments;
  for (const std::string_view part : split(canonical, ';')) assignments.emplace_back(part);
  return assignments;
}

}  // namespace cvr::codecs
