// The keys of YAML files, each described once: its name, what it may hold, its default and its
// meaning. From these tables a map is read (unknown and repeated keys are errors), and the JSON
// schema and docs/config.md are made (key_documents.hpp).
#pragma once

#include <fmt/format.h>

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "experiments/config/former_names.hpp"
#include "experiments/config/yaml_reader.hpp"

namespace cvr::experiments {

/// What documents and schemas say of a key.
struct KeyInfo {
  std::string name;
  std::string values;    ///< what it may hold, in words
  std::string schema;    ///< the same as a JSON schema
  std::string fallback;  ///< what holds without the key; empty: nothing
  std::string sentence;
  bool required = false;
};

/// What a value may be: how it is read, and what documents and schemas call it.
template <class T>
struct Shape {
  std::function<T(const YamlValue&)> read;
  std::string values, schema;
};

template <class S>
struct Key {
  KeyInfo info;
  std::function<void(const YamlValue&, S&)> read;
};

/// A key whose value goes into a member.
template <class S, class T, class M>
Key<S> key(std::string name, M S::*member, const Shape<T>& shape, std::string fallback,
           std::string sentence) {
  return {{std::move(name), shape.values, shape.schema, std::move(fallback), std::move(sentence)},
          [member, read = shape.read](const YamlValue& value, S& into) {
            if constexpr (std::is_arithmetic_v<M>)
              into.*member = static_cast<M>(read(value));
            else
              into.*member = read(value);
          }};
}

/// A key whose value is handed to `set(S&, T)`.
template <class S, class T, class Set>
Key<S> key(std::string name, const Shape<T>& shape, Set set, std::string fallback,
           std::string sentence) {
  return {{std::move(name), shape.values, shape.schema, std::move(fallback), std::move(sentence)},
          [set, read = shape.read](const YamlValue& value, S& into) { set(into, read(value)); }};
}

/// The same key; a map without it is an error.
template <class S>
Key<S> required(Key<S> one) {
  one.info.required = true;
  return one;
}

template <class S>
std::vector<KeyInfo> infos_of(const std::vector<Key<S>>& keys) {
  std::vector<KeyInfo> infos;
  for (const Key<S>& one : keys) infos.push_back(one.info);
  return infos;
}

/// Reads a map with exactly these keys. Throws InputError.
template <class S>
void read_keys(const YamlValue& value, const std::vector<Key<S>>& keys, S& into) {
  std::vector<YamlValue::Field> fields;
  for (const Key<S>& one : keys) {
    fields.push_back({one.info.name, [&one, &into](const YamlValue& v) { one.read(v, into); },
                      one.info.required, std::string(former_name(one.info.name))});
  }
  value.fields(fields);
}

/// The JSON schema of a map with exactly these keys.
std::string schema_of_map(std::span<const KeyInfo> keys);

/// {"type": "array"} of what another schema describes; `most` 0: any number.
std::string schema_of_list(std::string_view items, std::size_t least = 1, std::size_t most = 0);
/// What either of two schemas accepts.
std::string schema_of_either(std::string_view one, std::string_view other);
/// A scalar of any kind: what is a number to YAML is a text here as well.
inline constexpr std::string_view kTextSchema = R"({"type": ["string", "number", "boolean"]})";

Shape<std::uint64_t> whole_number(std::uint64_t minimum, std::uint64_t maximum);
Shape<double> real_number(double minimum, double maximum);
/// A text of one line; `what` it is: "a name".
Shape<std::string> one_text(std::string what = "text");
/// 0 or 1.
Shape<bool> zero_or_one();
/// true or false, also as 1 or 0.
Shape<bool> yes_or_no();
/// One of few words; `words` "local, shadow or ao" stands in errors.
Shape<std::string> one_word(std::vector<std::string> names, std::string words);

/// A word that stands for a value; `find` knows the values of all `names`.
template <class Find>
auto named(Find find, std::vector<std::string> names, std::string words) {
  using T = typename decltype(find(std::string_view()))::value_type;
  const auto word = one_word(std::move(names), std::move(words));
  return Shape<T>{[read = word.read, find](const YamlValue& value) { return *find(read(value)); },
                  word.values, word.schema};
}

/// A list; `what` its elements are.
template <class T>
Shape<std::vector<T>> list_of(const Shape<T>& shape, const std::string& what) {
  return {[read = shape.read, what](const YamlValue& value) {
            std::vector<T> all;
            for (const YamlValue& one : value.list(what)) all.push_back(read(one));
            return all;
          },
          fmt::format("a list of {}", what), schema_of_list(shape.schema)};
}

/// A list, or its only element by itself.
template <class T>
Shape<std::vector<T>> one_or_list(const Shape<T>& shape, const std::string& what) {
  return {[read = shape.read, what](const YamlValue& value) {
            std::vector<T> all;
            for (const YamlValue& one : value.list_or_one(what)) all.push_back(read(one));
            return all;
          },
          shape.values + ", or a list",
          schema_of_either(shape.schema, schema_of_list(shape.schema))};
}

/// A list of exactly N; `what`: "three numbers [x, y, z]".
template <std::size_t N, class T>
Shape<std::array<T, N>> exactly(const Shape<T>& shape, const std::string& what) {
  return {[read = shape.read, what](const YamlValue& value) {
            const auto elements = value.list(what);
            if (elements.size() != N) value.expected(what);
            std::array<T, N> all;
            for (std::size_t i = 0; i < N; ++i) all[i] = read(elements[i]);
            return all;
          },
          what, schema_of_list(shape.schema, N, N)};
}

/// A map that a table of keys describes.
template <class S>
Shape<S> map_of(const std::vector<Key<S>>& keys, std::string values) {
  return {[keys](const YamlValue& value) {
            S into;
            read_keys(value, keys, into);
            return into;
          },
          std::move(values), schema_of_map(infos_of(keys))};
}

}  // namespace cvr::experiments
