// Numbers as people write them on a command line, in YAML and in sidecars. Stricter than the
// library's own readers, which wrap -1 around, take 010 for 8 or 10 and stop at what they do not
// know: here the whole text is a number or it is none.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace cvr::volumes {

/// Decimal digits without a leading zero, below 2^64: no sign, blank, exponent or base.
std::optional<std::uint64_t> parse_unsigned(std::string_view text);
/// The same with a sign before negative ones, within 64 bits.
std::optional<std::int64_t> parse_signed(std::string_view text);
/// A finite decimal number, with or without fraction and exponent, without a leading zero before
/// another digit.
std::optional<double> parse_real(std::string_view text);

/// "found '010' (write it without leading zeros)": what was found, with the likely mistake where
/// one is known.
std::string found_number(std::string_view text);

}  // namespace cvr::volumes
