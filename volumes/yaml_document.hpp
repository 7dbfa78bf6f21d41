// One YAML document of a text that somebody else may have written: configurations, catalogues,
// scenes, sidecars of volumes.
//
// yaml-cpp alone reads the first document and passes over the rest, and follows anchors wherever
// they lead. Here a second document, a tag, nesting beyond kMaxYamlDepth, aliases that make a
// document larger than kMaxYamlNodes, an alias within what it names and control characters are
// errors. Keys that stand twice are the reader's to find, since yaml-cpp hands both over.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstddef>
#include <string>

namespace cvr::volumes {

inline constexpr std::size_t kMaxYamlDepth = 32;         ///< levels of lists and maps
inline constexpr std::size_t kMaxYamlNodes = 1'000'000;  ///< with what aliases stand for
inline constexpr std::size_t kMaxYamlBytes = 16 << 20;

/// `document` names the text in errors. Throws InputError "DOCUMENT:LINE:COLUMN: expected ...,
/// found ...".
YAML::Node load_yaml(const std::string& text, const std::string& document);

/// "DOCUMENT:LINE:COLUMN" from 1, "DOCUMENT" for what has no place.
std::string yaml_place(const std::string& document, const YAML::Mark& mark);

}  // namespace cvr::volumes
