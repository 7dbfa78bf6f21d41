// The names of an enumeration's values, in one table.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cvr::volumes {

template <class E, std::size_t N>
struct EnumNames {
  std::array<std::pair<E, std::string_view>, N> entries;

  /// "?" for a value that is not in the table.
  constexpr std::string_view of(E value) const {
    for (const auto& [known, name] : entries) {
      if (known == value) return name;
    }
    return "?";
  }
  constexpr std::optional<E> find(std::string_view name) const {
    for (const auto& [value, known] : entries) {
      if (known == name) return value;
    }
    return std::nullopt;
  }
  /// In the order of the table.
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : entries) all.emplace_back(entry.second);
    return all;
  }
};

/// EnumNames of a list of {value, name}.
template <class E, std::size_t N>
constexpr EnumNames<E, N> enum_names(const std::pair<E, std::string_view> (&entries)[N]) {
  EnumNames<E, N> names{};
  for (std::size_t i = 0; i < N; ++i) names.entries[i] = entries[i];
  return names;
}

}  // namespace cvr::volumes
