#include "volumes/io/hdf5_axes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "volumes/io/format.hpp"

namespace cvr::volumes {

namespace {

constexpr std::string_view kLetters = "tzyxc";
constexpr std::uint64_t kMostChannels = 4;

using Names = std::vector<std::string>;

bool is_letter(const std::string& name) {
  return name.size() == 1 && kLetters.find(name) != std::string_view::npos;
}

/// One of the letters where a name is one or a usual word for one; else the name itself, in lower
/// case.
std::string letter_of(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  if (name == "time" || name == "frame" || name == "frames") return "t";
  if (name == "channel" || name == "channels") return "c";
  return name;
}

Names letters_of(std::string_view letters) {
  Names names;
  for (const char letter : letters) names.push_back(letter_of(std::string(1, letter)));
  return names;
}

struct Problem {
  std::string file, position, shape;

  [[noreturn]] void ask(const std::string& found) const {
    throw_input_error(
        file, position,
        "axes that are known: name them, slowest first, as in --axes zyxc (letters t z y x c; in a "
        "configuration the key axes)",
        found);
  }
};

/// What DIMENSION_LABELS or `axes` say; empty where they say nothing of x, y, z.
Names stated_names(const Problem& problem, const Names& stated, const char* attribute,
                   std::size_t rank) {
  Names names;
  for (const std::string& name : stated) names.push_back(letter_of(name));
  const auto known = static_cast<std::size_t>(std::count_if(names.begin(), names.end(), is_letter));
  if (known == 0) return {};
  const std::string text = fmt::format("{}", fmt::join(stated, " "));
  if (names.size() != rank) {
    problem.ask(fmt::format("{} names '{}' in the attribute {} of an array of rank {} ({})",
                            names.size(), text, attribute, rank, problem.shape));
  }
  return names;
}

Names names_of_file(const Problem& problem, std::size_t rank, const Hdf5Attributes& dataset) {
  if (const auto text = dataset.text("axistags")) {
    const auto tags = hdf5_axistags(*text);
    if (!tags || tags->size() != rank) {
      problem.ask(tags ? fmt::format("axistags of {} axes for an array of rank {} ({})",
                                     tags->size(), rank, problem.shape)
                       : "an attribute axistags that is not vigra's JSON");
    }
    Names names;
    for (const Hdf5Axis& tag : *tags) names.push_back(letter_of(tag.name));
    return names;
  }
  for (const char* attribute : {"axes", "DIMENSION_LABELS"}) {
    Names stated;
    if (const auto text = dataset.text(attribute); text && text->size() == rank) {
      stated = letters_of(*text);
    } else if (const auto texts = dataset.texts(attribute)) {
      stated = *texts;
    }
    if (Names names = stated_names(problem, stated, attribute, rank); !names.empty()) return names;
  }
  return {};
}

Names names_by_rule(const Problem& problem, const std::vector<std::uint64_t>& size, bool ours) {
  switch (size.size()) {
    case 2:
      return letters_of("yx");
    case 3:
      return letters_of("zyx");
    case 4: {
      const bool channels = size[3] <= kMostChannels && size[3] < size[2] && size[3] < size[1];
      if (channels && !ours) {
        problem.ask(fmt::format(
            "{} without a word about its axes; the last one may be channels or x", problem.shape));
      }
      return letters_of("tzyx");
    }
    case 5:
      problem.ask(fmt::format("{} without a word about its axes", problem.shape));
    default:
      throw_input_error(problem.file, problem.position,
                        "an array of rank 2 (y x), 3 (z y x), 4 (t z y x) or 5",
                        fmt::format("rank {} ({})", size.size(), problem.shape));
  }
}

Names asked_names(const Problem& problem, const std::string& asked, std::size_t rank) {
  const Names names = letters_of(asked);
  const bool letters = std::all_of(names.begin(), names.end(), is_letter);
  if (!letters || names.size() != rank) {
    throw_input_error(
        problem.file, problem.position,
        fmt::format("axes of {} letters out of t z y x c for the array {}, slowest first", rank,
                    problem.shape),
        fmt::format("'{}'", asked));
  }
  return names;
}

}  // namespace

Hdf5AxisOrder settle_hdf5_axes(const std::string& file, const std::string& position,
                               const std::vector<std::uint64_t>& size, const std::string& asked,
                               const Hdf5Attributes& dataset) {
  const Problem problem{file, position, fmt::format("{}", fmt::join(size, "x"))};
  Names names = asked.empty() ? names_of_file(problem, size.size(), dataset)
                              : asked_names(problem, asked, size.size());
  if (names.empty()) names = names_by_rule(problem, size, dataset.ours());
  const std::string order = fmt::format("{}", fmt::join(names, " "));

  Hdf5AxisOrder result;
  std::set<std::string> seen;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i];
    if (is_letter(name) && !seen.insert(name).second)
      problem.ask(fmt::format("the axes {} with {} twice", order, name));
    if (name == "t") {
      result.time = static_cast<int>(i);
    } else if (is_letter(name) && name != "c") {
      result.axis[static_cast<std::size_t>(name[0] - 'x')] = static_cast<int>(i);
    } else if (size[i] != 1 && name == "c") {
      throw_input_error(
          file, position,
          "one channel: write the one that is meant to a dataset of its own (h5py: f['one'] = "
          "f['all'][..., 0]), or name the axes with --axes if these are no channels",
          fmt::format("{} channels in {} ({})", size[i], problem.shape, order));
    } else if (size[i] != 1) {
      problem.ask(
          fmt::format("an axis '{}' of length {} in {} ({})", name, size[i], problem.shape, order));
    }
  }
  if (result.axis == std::array<int, 3>{-1, -1, -1})
    problem.ask(fmt::format("no x, y or z among the axes {}", order));
  return result;
}

}  // namespace cvr::volumes
