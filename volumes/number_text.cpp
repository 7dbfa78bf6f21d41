#include "volumes/number_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "volumes/plain_text.hpp"

namespace cvr::volumes {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Octal to some readers, decimal to others.
bool has_leading_zero(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  return text.size() > 1 && text[0] == '0' && is_digit(text[1]);
}

template <class T>
std::optional<T> parse_whole(std::string_view text) {
  T value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || stop != end || has_leading_zero(text)) return std::nullopt;
  return value;
}

}  // namespace

std::optional<std::uint64_t> parse_unsigned(std::string_view text) {
  return parse_whole<std::uint64_t>(text);
}

std::optional<std::int64_t> parse_signed(std::string_view text) {
  return parse_whole<std::int64_t>(text);
}

std::optional<double> parse_real(std::string_view text) {
  const auto value = parse_whole<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::string found_number(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  const std::string shown =
      printable(text.substr(0, kLongest)) + (text.size() > kLongest ? "..." : "");
  if (text.empty()) return "found nothing";
  std::string hint;
  if (has_leading_zero(text) && std::ranges::all_of(text.substr(1), is_digit))
    hint = " (write it without leading zeros)";
  if (text.starts_with('+')) hint = " (write it without a plus)";
  return fmt::format("found '{}'{}", shown, hint);
}

}  // namespace cvr::volumes
