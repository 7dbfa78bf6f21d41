// Text that came from outside on its way into messages and documents.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace cvr::volumes {

/// The text with what could move a terminal's cursor or end a line made visible: control characters
/// (U+0000..U+001F, U+007F..U+009F, U+2028, U+2029) and bytes that are no UTF-8 as \n, \t, \x1b,
/// \u0085, ... All else stays as it is.
std::string printable(std::string_view text);

/// Byte of the first character that `printable` would change, if there is one.
std::optional<std::size_t> unprintable_at(std::string_view text);

/// " (did you mean 'csgvr'?)" or "" if no candidate is near.
std::string did_you_mean(std::string_view word, std::span<const std::string> candidates);

}  // namespace cvr::volumes
