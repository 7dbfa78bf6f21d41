#include "experiments/cli/arguments.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "experiments/config/datasets.hpp"
#include "volumes/error.hpp"
#include "volumes/number_text.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::experiments::cli {

namespace {

/// `accepts` judges a text that must be `what`.
template <class Accepts>
CLI::Validator number_validator(const std::string& what, const std::string& range,
                                const Accepts& accepts) {
  return CLI::Validator(
      [=](std::string& text) {
        return accepts(text) ? std::string()
                             : fmt::format("expected {}, {}", what, volumes::found_number(text));
      },
      range);
}

}  // namespace

CLI::Validator integer_in(std::uint64_t minimum, std::uint64_t maximum) {
  const std::string range = fmt::format("{}..{}", minimum, maximum);
  return number_validator("an integer in " + range, range, [=](const std::string& text) {
    const auto value = volumes::parse_unsigned(text);
    return value && *value >= minimum && *value <= maximum;
  });
}

CLI::Validator signed_integer() {
  return number_validator("an integer of 64 bits", "", [](const std::string& text) {
    return volumes::parse_signed(text).has_value();
  });
}

CLI::Validator number_in(double minimum, double maximum) {
  const std::string range = fmt::format("{}..{}", minimum, maximum);
  return number_validator("a number in " + range, range, [=](const std::string& text) {
    const auto value = volumes::parse_real(text);
    return value && *value >= minimum && *value <= maximum;
  });
}

CLI::Validator one_of(std::vector<std::string> words) {
  const std::string all = fmt::format("{}", fmt::join(words, " | "));
  return CLI::Validator(
      [words = std::move(words)](std::string& text) {
        if (std::ranges::find(words, text) != words.end()) return std::string();
        return fmt::format("expected {}, found '{}'{}", fmt::join(words, " or "),
                           volumes::printable(text), volumes::did_you_mean(text, words));
      },
      all);
}

CLI::Validator time_text() {
  return CLI::Validator(
      [](std::string& text) {
        constexpr std::string_view kPattern = "dddd-dd-dd";
        const auto fits = [&](std::size_t i) {
          return kPattern[i] == 'd' ? text[i] >= '0' && text[i] <= '9' : text[i] == kPattern[i];
        };
        bool good = text.size() >= kPattern.size();
        for (std::size_t i = 0; good && i < kPattern.size(); ++i) good = fits(i);
        good = good && (text.size() == kPattern.size() || text[kPattern.size()] == 'T');
        return good ? std::string()
                    : fmt::format(
                          "expected a day YYYY-MM-DD or a time YYYY-MM-DDTHH:MM:SSZ, found '{}'",
                          volumes::printable(text));
      },
      "");
}

volumes::OpenOptions VolumeChoices::options() const {
  volumes::OpenOptions options;
  if (!kind.empty()) options.kind = volumes::volume_kind_from_name(kind);
  options.axes = axes;
  options.allow_external = allow_external;
  return options;
}

void VolumeChoices::require_none(const std::string& encoded_file) const {
  const char* given = !kind.empty()    ? "--kind"
                      : !axes.empty()  ? "--axes"
                      : allow_external ? "--allow-external"
                                       : nullptr;
  if (given != nullptr)
    throw volumes::InputError(fmt::format(
        "{}: expected {} only with a volume, found an encoded file, which says what it holds",
        encoded_file, given));
}

void add_axes_option(CLI::App& command, const std::string& name, std::string& axes,
                     const std::string& description) {
  command.add_option(name, axes, description)
      ->check(CLI::Validator(
          [](std::string& text) {
            return are_axes(text) ? std::string()
                                  : fmt::format("expected {}, found '{}'", kAxesExplained,
                                                volumes::printable(text));
          },
          ""));
}

void add_volume_choices(CLI::App& command, VolumeChoices& choices) {
  command.add_option("--kind", choices.kind, "what the voxels are where the file does not say")
      ->check(one_of({"labels", "scalars"}));
  add_axes_option(command, "--axes", choices.axes,
                  "axes of the file in its own order (HDF5: slowest first), for instance tzyxc; "
                  "default: as it says");
  command.add_flag("--allow-external", choices.allow_external,
                   "read files that the volume names outside its own folder");
}

}  // namespace cvr::experiments::cli
