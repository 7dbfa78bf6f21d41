// What single arguments of the command line may be. Each validator judges the text before CLI11
// converts it, since its own conversions wrap -1 around, take 010 for octal and NaN for a number;
// what they refuse is "NAME: expected ..., found ...".
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "volumes/io/io.hpp"

namespace cvr::experiments::cli {

inline constexpr unsigned kMostThreads = 4096;

/// A whole number as volumes::parse_unsigned reads it.
CLI::Validator integer_in(std::uint64_t minimum, std::uint64_t maximum);
/// A whole number of 64 bits with a sign.
CLI::Validator signed_integer();
/// A finite number as volumes::parse_real reads it.
CLI::Validator number_in(double minimum, double maximum);
/// One of a few words.
CLI::Validator one_of(std::vector<std::string> words);
/// "YYYY-MM-DD", and what of the time follows it.
CLI::Validator time_text();

/// What is said of a volume file beside its name.
struct VolumeChoices {
  std::string kind, axes;
  bool allow_external = false;

  volumes::OpenOptions options() const;
  /// For a file that is no volume: encoded files say all this themselves. Throws InputError naming
  /// the first that is given.
  void require_none(const std::string& encoded_file) const;
};

/// An option that names axes.
void add_axes_option(CLI::App& command, const std::string& name, std::string& axes,
                     const std::string& description);
/// --kind, --axes, --allow-external.
void add_volume_choices(CLI::App& command, VolumeChoices& choices);

}  // namespace cvr::experiments::cli
