#include "volumes/io/yaml.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <set>

#include "volumes/io/file.hpp"

namespace cvr::volumes {

namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

constexpr std::size_t kMaximumDocument = std::size_t{1} << 24;

/// Whether a number is written like 010, which YAML 1.1 and C read as 8 and everybody else as 10.
bool looks_octal(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  return text.size() > 1 && text[0] == '0' && text[1] >= '0' && text[1] <= '9';
}

template <class T>
std::optional<T> parse_number(const std::string& text) {
  T value{};
  if (looks_octal(text)) return std::nullopt;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string_view unambiguous(const YAML::Node& node) {
  return node.IsScalar() && looks_octal(node.Scalar()) ? " without a leading 0, which may mean octal" : "";
}

std::string place_of(const std::string& document, const YAML::Mark& mark) {
  if (mark.is_null()) return document;
  return fmt::format("{}:{}:{}", document, mark.line + 1, mark.column + 1);
}

}  // namespace

std::string did_you_mean(std::string_view word, std::span<const std::string> candidates) {
  const auto nearest =
      std::ranges::min_element(candidates, {}, [&](const std::string& c) { return edit_distance(word, c); });
  const std::size_t allowed = word.size() <= 3 ? 1 : std::max<std::size_t>(2, word.size() / 3);
  if (nearest == candidates.end() || edit_distance(word, *nearest) > allowed) return "";
  return fmt::format(" (did you mean '{}'?)", *nearest);
}

YamlValue YamlValue::from_file(const std::string& path) {
  const MappedFile file(path);
  if (file.bytes().size() > kMaximumDocument) {
    throw InputError(fmt::format("{}: expected YAML of at most {} bytes, found {} bytes", path, kMaximumDocument,
                                 file.bytes().size()));
  }
  return from_text(std::string(file.text()), path);
}

YamlValue YamlValue::from_text(const std::string& text, const std::string& document) {
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    if (documents.size() > 1) {
      throw InputError(fmt::format("{}: expected one YAML document, found {}, of which '---' begins each",
                                   place_of(document, documents[1].Mark()), documents.size()));
    }
    return YamlValue(documents.empty() ? YAML::Node() : documents[0], document);
  } catch (const YAML::ParserException& error) {
    throw InputError(fmt::format("{}: expected YAML, found: {}", place_of(document, error.mark), error.msg));
  }
}

std::string YamlValue::place() const { return place_of(document_, node_.Mark()); }

std::string YamlValue::describe() const {
  switch (node_.Type()) {
    case YAML::NodeType::Null:
      return "nothing";
    case YAML::NodeType::Sequence:
      return node_.size() == 0 ? "an empty list" : "a list";
    case YAML::NodeType::Map:
      return "a map";
    case YAML::NodeType::Scalar:
      return fmt::format("'{}'", node_.Scalar());
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

std::string YamlValue::text(std::string_view what) const {
  if (!node_.IsScalar()) expected(what);
  return node_.Scalar();
}

std::uint64_t YamlValue::integer(std::uint64_t minimum, std::uint64_t maximum) const {
  const auto value = node_.IsScalar() ? parse_number<std::uint64_t>(node_.Scalar()) : std::nullopt;
  if (!value || *value < minimum || *value > maximum)
    expected(fmt::format("an integer in {}..{}{}", minimum, maximum, unambiguous(node_)));
  return *value;
}

double YamlValue::number(double minimum, double maximum) const {
  const auto value = node_.IsScalar() ? parse_number<double>(node_.Scalar()) : std::nullopt;
  if (!value || !std::isfinite(*value) || *value < minimum || *value > maximum) {
    const bool any = minimum == std::numeric_limits<double>::lowest() && maximum == std::numeric_limits<double>::max();
    expected((any ? "a finite number" : fmt::format("a number in {}..{}", minimum, maximum)) + std::string(unambiguous(node_)));
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
    const auto field = std::ranges::find(known, name, &Field::key);
    if (field == known.end()) {
      std::vector<std::string> keys;
      for (const Field& f : known) keys.push_back(f.key);
      throw InputError(fmt::format("{}: expected one of the keys {}, found '{}'{}", key.place(),
                                   fmt::join(keys, ", "), name, did_you_mean(name, keys)));
    }
    seen.insert(name);
    field->read(value);
  }
  for (const Field& field : known) {
    if (field.required && !seen.contains(field.key)) {
      throw InputError(fmt::format("{}: expected the key '{}', found none", place(), field.key));
    }
  }
}

}  // namespace cvr::volumes
