// The strict reader of YAML; yaml_document.hpp says what a document may be.
#include "volumes/io/yaml.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <set>

#include "volumes/io/file.hpp"
#include "volumes/number_text.hpp"
#include "volumes/yaml_document.hpp"

namespace cvr::volumes {

YamlValue YamlValue::from_file(const std::string& path) {
  return from_text(std::string(MappedFile(path).text()), path);
}

YamlValue YamlValue::from_text(const std::string& text, const std::string& document) {
  return YamlValue(load_yaml(text, document), document);
}

namespace {

YAML::Node without_marks(const YAML::Node& node) {
  YAML::Node copy;
  switch (node.Type()) {
    case YAML::NodeType::Scalar:
      copy = YAML::Node(node.Scalar());
      copy.SetTag(node.Tag());
      break;
    case YAML::NodeType::Sequence:
      copy = YAML::Node(YAML::NodeType::Sequence);
      for (const YAML::Node& element : node) copy.push_back(without_marks(element));
      break;
    case YAML::NodeType::Map:
      copy = YAML::Node(YAML::NodeType::Map);
      for (const auto& entry : node)
        copy.force_insert(without_marks(entry.first), without_marks(entry.second));
      break;
    default:
      break;
  }
  return copy;
}

}  // namespace

std::optional<YamlValue> YamlValue::find(const std::string& key) const {
  if (!node_.IsMap()) return std::nullopt;
  const YAML::Node found = node_[key];
  return found.IsDefined() ? std::optional(YamlValue(found, document_)) : std::nullopt;
}

void YamlValue::become(const YamlValue& value) const {
  YAML::Node node = node_;
  node = value.node_;
}

void YamlValue::put(const std::string& key, const YamlValue& value) const {
  YAML::Node node = node_;
  node[key] = value.node_;
}

void YamlValue::remove(const std::string& key) const {
  YAML::Node node = node_;
  node.remove(key);
}

YamlValue YamlValue::without_places() const { return YamlValue(without_marks(node_), document_); }

std::string YamlValue::place() const { return yaml_place(document_, node_.Mark()); }

namespace {

/// In quotes, as much as a line of an error holds.
std::string shown(const std::string& text) {
  constexpr std::size_t kLongest = 120;
  return fmt::format("'{}'", text.size() <= kLongest ? printable(text)
                                                     : printable(text.substr(0, kLongest)) + "...");
}

}  // namespace

std::string YamlValue::describe() const {
  switch (node_.Type()) {
    case YAML::NodeType::Null:
      return "nothing";
    case YAML::NodeType::Sequence:
      return node_.size() == 0 ? "an empty list" : "a list";
    case YAML::NodeType::Map:
      return "a map";
    case YAML::NodeType::Scalar:
      return shown(node_.Scalar());
    default:
      return "nothing";
  }
}

void YamlValue::expected(std::string_view what) const {
  throw InputError(fmt::format("{}: expected {}, found {}", place(), what, describe()));
}

void YamlValue::reject(std::string_view message) const {
  throw InputError(fmt::format("{}: {}", place(), message));
}

void YamlValue::expected_number(const std::string& what) const {
  if (!node_.IsScalar()) expected(what);
  reject(fmt::format("expected {}, {}", what, found_number(node_.Scalar())));
}

std::string YamlValue::text(std::string_view what) const {
  if (!node_.IsScalar()) expected(what);
  if (unprintable_at(node_.Scalar()))
    expected(fmt::format("{} of one line without control characters", what));
  return node_.Scalar();
}

std::string YamlValue::any_text(std::string_view what) const {
  if (!node_.IsScalar()) expected(what);
  return node_.Scalar();
}

std::uint64_t YamlValue::integer(std::uint64_t minimum, std::uint64_t maximum) const {
  const auto value = node_.IsScalar() ? parse_unsigned(node_.Scalar()) : std::nullopt;
  if (!value || *value < minimum || *value > maximum)
    expected_number(fmt::format("an integer in {}..{}", minimum, maximum));
  return *value;
}

double YamlValue::number(double minimum, double maximum) const {
  const auto value = node_.IsScalar() ? parse_real(node_.Scalar()) : std::nullopt;
  if (!value || *value < minimum || *value > maximum) {
    const bool any = minimum == std::numeric_limits<double>::lowest() &&
                     maximum == std::numeric_limits<double>::max();
    expected_number(any ? "a finite number" : fmt::format("a number in {}..{}", minimum, maximum));
  }
  return *value;
}

std::vector<YamlValue> YamlValue::list(std::string_view what) const {
  if (!node_.IsSequence() || node_.size() == 0) expected(fmt::format("a list of {}", what));
  std::vector<YamlValue> values;
  for (const YAML::Node& element : node_) values.push_back(YamlValue(element, document_));
  return values;
}

std::vector<YamlValue> YamlValue::list_or_one(std::string_view what) const {
  if (node_.IsSequence()) return list(what);
  return {*this};
}

std::vector<std::pair<YamlValue, YamlValue>> YamlValue::entries() const {
  if (!node_.IsMap()) expected("a map of keys and values");
  std::vector<std::pair<YamlValue, YamlValue>> pairs;
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    const YamlValue name(entry.first, document_);
    if (!seen.insert(name.text("a key")).second) {
      throw InputError(
          fmt::format("{}: expected each key once, found '{}' again", name.place(), name.text()));
    }
    pairs.emplace_back(name, YamlValue(entry.second, document_));
  }
  return pairs;
}

void YamlValue::fields(const std::vector<Field>& known) const {
  std::set<std::string> seen;
  for (const auto& [key, value] : entries()) {
    const std::string name = key.text();
    const auto field = std::ranges::find_if(
        known, [&](const Field& f) { return f.key == name || f.former == name; });
    if (field == known.end()) {
      std::vector<std::string> keys;
      for (const Field& f : known) keys.push_back(f.key);
      throw InputError(fmt::format("{}: expected one of the keys {}, found '{}'{}", key.place(),
                                   fmt::join(keys, ", "), name, did_you_mean(name, keys)));
    }
    if (!seen.insert(field->key).second) {
      throw InputError(fmt::format("{}: expected each key once, found '{}' beside '{}'",
                                   key.place(), field->former, field->key));
    }
    field->read(value);
  }
  for (const Field& field : known) {
    if (field.required && !seen.contains(field.key)) {
      throw InputError(fmt::format("{}: expected the key '{}', found none", place(), field.key));
    }
  }
}

}  // namespace cvr::volumes
