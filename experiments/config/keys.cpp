#include "experiments/config/keys.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "experiments/results/rows.hpp"

namespace cvr::experiments {

std::string schema_of_map(std::span<const KeyInfo> keys) {
  Row schema;
  schema["type"] = "object";
  Row& properties = schema["properties"] = Row::object();
  Row needed = Row::array();
  for (const KeyInfo& one : keys) {
    Row property = Row::parse(one.schema);
    if (!one.sentence.empty()) property["description"] = one.sentence;
    if (const std::string former(former_name(one.name)); !former.empty()) {
      properties[former] = property;
      properties[former]["deprecated"] = true;
    }
    properties[one.name] = std::move(property);
    if (one.required) needed.push_back(one.name);
  }
  schema["additionalProperties"] = false;
  if (!needed.empty()) schema["required"] = std::move(needed);
  return schema.dump();
}

std::string schema_of_list(std::string_view items, std::size_t least, std::size_t most) {
  Row schema;
  schema["type"] = "array";
  schema["items"] = Row::parse(items);
  schema["minItems"] = least;
  if (most > 0) schema["maxItems"] = most;
  return schema.dump();
}

std::string schema_of_either(std::string_view one, std::string_view other) {
  Row schema;
  schema["anyOf"] = {Row::parse(one), Row::parse(other)};
  return schema.dump();
}

Shape<std::uint64_t> whole_number(std::uint64_t minimum, std::uint64_t maximum) {
  Row schema{{"type", "integer"}, {"minimum", minimum}};
  if (maximum != UINT64_MAX) schema["maximum"] = maximum;
  return {[=](const YamlValue& value) { return value.integer(minimum, maximum); },
          maximum == UINT64_MAX ? fmt::format("an integer from {}", minimum)
                                : fmt::format("an integer, {} to {}", minimum, maximum),
          schema.dump()};
}

Shape<double> real_number(double minimum, double maximum) {
  constexpr double kAny = 1e300;  // stands for "any number" in words
  Row schema{{"type", "number"}};
  std::string words = "a number";
  if (minimum > -kAny) schema["minimum"] = minimum;
  if (maximum < kAny) schema["maximum"] = maximum;
  if (minimum > -kAny && maximum < kAny)
    words += fmt::format(", {} to {}", minimum, maximum);
  else if (minimum > -kAny)
    words += fmt::format(" from {}", minimum);
  return {[=](const YamlValue& value) { return value.number(minimum, maximum); }, std::move(words),
          schema.dump()};
}

Shape<std::string> one_text(std::string what) {
  return {[what](const YamlValue& value) { return value.text(what); }, what,
          std::string(kTextSchema)};
}

Shape<bool> zero_or_one() {
  return {[](const YamlValue& value) { return value.integer(0, 1) == 1; }, "0 or 1",
          R"({"enum": [0, 1]})"};
}

Shape<bool> yes_or_no() {
  return {[](const YamlValue& value) {
            const std::string word = value.text("true or false");
            if (word != "true" && word != "false" && word != "1" && word != "0")
              value.expected("true or false");
            return word == "true" || word == "1";
          },
          "true or false", R"({"enum": [true, false, 0, 1]})"};
}

Shape<std::string> one_word(std::vector<std::string> names, std::string words) {
  const Row schema{{"enum", names}};
  return {[names, words](const YamlValue& value) {
            std::string name = value.text(words);
            if (std::ranges::find(names, name) == names.end())
              value.expected(words + did_you_mean(name, names));
            return name;
          },
          words, schema.dump()};
}

}  // namespace cvr::experiments
