// Strict reading of YAML: every node knows its place, every unexpected thing is an InputError
// "FILE:LINE:COLUMN: expected ..., found ...". Unknown and repeated keys are errors, with the
// nearest known key as a hint.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "volumes/error.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::volumes {

class YamlValue {
 public:
  /// Throws InputError when the file cannot be read or is no YAML document.
  static YamlValue from_file(const std::string& path);
  /// `document` names the text in errors.
  static YamlValue from_text(const std::string& text, const std::string& document);

  /// "FILE:LINE:COLUMN".
  std::string place() const;
  [[noreturn]] void expected(std::string_view what) const;
  [[noreturn]] void reject(std::string_view message) const;

  bool is_list() const { return node_.IsSequence(); }
  bool is_map() const { return node_.IsMap(); }
  bool is_scalar() const { return node_.IsScalar(); }

  /// A scalar without control characters, which no name or title has a use for.
  std::string text(std::string_view what = "text") const;
  /// A scalar, whatever it holds.
  std::string any_text(std::string_view what = "text") const;
  std::uint64_t integer(std::uint64_t minimum, std::uint64_t maximum) const;
  double number(double minimum, double maximum) const;
  /// The elements; `what` they are; an empty list is an error.
  std::vector<YamlValue> list(std::string_view what) const;
  /// The elements of a list, or the value itself as the only one.
  std::vector<YamlValue> list_or_one(std::string_view what) const;
  /// Key and value in the order of the file. Repeated keys are an error; an empty map is allowed.
  std::vector<std::pair<YamlValue, YamlValue>> entries() const;

  /// The value of a key of this map; none where it has no such key.
  std::optional<YamlValue> find(const std::string& key) const;

  // Changes of the document, which every YamlValue of it sees.

  /// Another value in place of this one.
  void become(const YamlValue& value) const;
  /// A value under a key of this map, new or in place of the one that is there.
  void put(const std::string& key, const YamlValue& value) const;
  /// This map without a key, if it is there.
  void remove(const std::string& key) const;
  /// A copy whose values have no line and column: errors name the document that they are put into.
  YamlValue without_places() const;

  struct Field {
    std::string key;
    std::function<void(const YamlValue&)> read;
    bool required = false;
    std::string former = {};  ///< another name of the key; only one of the two may stand there
  };
  /// Reads a map with exactly these keys.
  void fields(const std::vector<Field>& known) const;

 private:
  YamlValue(const YAML::Node& node, std::string document)
      : node_(node), document_(std::move(document)) {}
  [[noreturn]] void expected_number(const std::string& what) const;
  std::string describe() const;

  YAML::Node node_;
  std::string document_;
};

}  // namespace cvr::volumes
