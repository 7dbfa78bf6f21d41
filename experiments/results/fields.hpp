// Tables of fields: each field of a struct is described once, with its name, its member, its
// meaning and what a JSON schema says beyond the member's type. JSON both ways and the schema are
// made from the table. A member that is std::optional is left out of the JSON where it is empty; one
// that is Nullable is null there.
//
// A struct has a table by a specialisation of table_of(). Only the files with the tables include
// this one.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "experiments/results/result.hpp"

namespace cvr::experiments {

template <class S>
struct Field {
  std::string name;
  bool required;  ///< by the schema
  Row schema;
  std::function<void(const S&, Row&)> put;
  std::function<void(const Row&, S&, const std::string& where)> take;
};

template <class S>
class FieldTable;

/// The table of a struct: to be specialised for each.
template <class S>
FieldTable<S> table_of();

template <class S>
const FieldTable<S>& fields_of() {
  static const FieldTable<S> kFields = table_of<S>();
  return kFields;
}

/// Throws ShapeError unless `is`.
inline void expect(bool is, const char* what, const std::string& where) {
  if (!is) throw ShapeError(fmt::format("{} as {}", what, where.empty() ? "a row" : where));
}

/// The JSON schema of a struct with a table.
template <class S>
Row schema_of_fields() {
  Row schema{{"type", "object"}}, properties = Row::object();
  for (const Field<S>& field : fields_of<S>()) {
    properties[field.name] = field.schema;
    if (field.required) schema["required"].push_back(field.name);
  }
  schema["additionalProperties"] = false;
  schema["properties"] = std::move(properties);
  return schema;
}

/// How a type is carried in JSON: write(), read() and schema(). This one: a struct with a table.
template <class T>
struct Carrier {
  static Row write(const T& part) {
    Row row = Row::object();
    for (const Field<T>& field : fields_of<T>()) field.put(part, row);
    return row;
  }
  static void read(const Row& row, T& part, const std::string& where) {
    expect(row.is_object(), "an object", where);
    for (const Field<T>& field : fields_of<T>()) {
      if (const auto found = row.find(field.name); found != row.end())
        field.take(*found, part, where.empty() ? field.name : where + "." + field.name);
    }
  }
  static Row schema() { return schema_of_fields<T>(); }
};

template <>
struct Carrier<double> {
  static Row write(double value) { return value; }
  static void read(const Row& row, double& into, const std::string& where) {
    expect(row.is_number(), "a number", where);
    into = row.get<double>();
  }
  static Row schema() { return {{"type", "number"}}; }
};

template <>
struct Carrier<std::uint64_t> {
  static Row write(std::uint64_t value) { return value; }
  static void read(const Row& row, std::uint64_t& into, const std::string& where) {
    const double value = row.is_number() ? row.get<double>() : -1;  // 5.0 is an integer as well
    expect(row.is_number_unsigned() || (value >= 0 && value < 0x1p64 && value == std::floor(value)),
           "an integer from 0", where);
    into = row.get<std::uint64_t>();
  }
  static Row schema() { return {{"type", "integer"}}; }
};

template <>
struct Carrier<bool> {
  static Row write(bool value) { return value; }
  static void read(const Row& row, bool& into, const std::string& where) {
    expect(row.is_boolean(), "true or false", where);
    into = row.get<bool>();
  }
  static Row schema() { return {{"type", "boolean"}}; }
};

template <>
struct Carrier<std::string> {
  static Row write(const std::string& value) { return value; }
  static void read(const Row& row, std::string& into, const std::string& where) {
    expect(row.is_string(), "a text", where);
    into = row.get_ref<const std::string&>();
  }
  static Row schema() { return {{"type", "string"}}; }
};

/// An object that another table describes.
template <>
struct Carrier<Row> {
  static Row write(const Row& value) { return value; }
  static void read(const Row& row, Row& into, const std::string& where) {
    expect(row.is_object(), "an object", where);
    into = row;
  }
  static Row schema() { return {{"type", "object"}}; }
};

template <class T>
struct Carrier<Nullable<T>> {
  static Row write(const Nullable<T>& value) {
    return value ? Carrier<T>::write(*value) : Row(nullptr);
  }
  static void read(const Row& row, Nullable<T>& into, const std::string& where) {
    into.reset();
    if (!row.is_null()) Carrier<T>::read(row, into.emplace(), where);
  }
  static Row schema() {
    Row schema = Carrier<T>::schema();
    schema["type"] = {schema["type"], "null"};
    return schema;
  }
};

template <class T>
struct Carrier<std::vector<T>> {
  static Row write(const std::vector<T>& values) {
    Row row = Row::array();
    for (const T& value : values) row.push_back(Carrier<T>::write(value));
    return row;
  }
  static void read(const Row& row, std::vector<T>& into, const std::string& where) {
    expect(row.is_array(), "a list", where);
    into.assign(row.size(), T());
    const std::string element = where + "[]";
    for (std::size_t i = 0; i < row.size(); ++i) Carrier<T>::read(row[i], into[i], element);
  }
  static Row schema() { return {{"type", "array"}, {"items", Carrier<T>::schema()}}; }
};

template <class T, std::size_t N>
struct Carrier<std::array<T, N>> {
  static Row write(const std::array<T, N>& values) { return values; }
  static void read(const Row& row, std::array<T, N>& into, const std::string& where) {
    expect(row.is_array() && row.size() == N, "a list of its length", where);
    for (std::size_t i = 0; i < N; ++i) Carrier<T>::read(row[i], into[i], where + "[]");
  }
  static Row schema() {
    return {{"type", "array"}, {"items", Carrier<T>::schema()}, {"minItems", N}, {"maxItems", N}};
  }
};

template <class T>
struct Carrier<Named<T>> {
  static Row write(const Named<T>& values) {
    Row row = Row::object();
    for (const auto& [name, value] : values) row[name] = Carrier<T>::write(value);
    return row;
  }
  static void read(const Row& row, Named<T>& into, const std::string& where) {
    expect(row.is_object(), "an object", where);
    into.clear();
    for (const auto& [name, value] : row.items())
      Carrier<T>::read(value, into[name], where + "." + name);
  }
  static Row schema() {
    return {{"type", "object"}, {"additionalProperties", Carrier<T>::schema()}};
  }
};

/// A list of fields that grows. `facts`: members of the value's JSON schema that replace those of
/// its type.
template <class S>
class FieldTable : public std::vector<Field<S>> {
 public:
  template <class M>
  FieldTable& required(const char* name, M S::*member, const char* sentence = "",
                       const char* facts = "") {
    return add(name, true, member, sentence, facts);
  }
  template <class M>
  FieldTable& optional(const char* name, M S::*member, const char* sentence = "",
                       const char* facts = "") {
    return add(name, false, member, sentence, facts);
  }
  /// The fields of what S is made from.
  template <class Base>
  FieldTable& all_of() {
    for (const Field<Base>& field : fields_of<Base>())
      this->push_back({field.name, field.required, field.schema, field.put, field.take});
    return *this;
  }

 private:
  template <class T>
  struct Inner {
    using Type = T;
    static constexpr bool kOptional = false;
  };
  template <class T>
  struct Inner<std::optional<T>> {
    using Type = T;
    static constexpr bool kOptional = true;
  };

  template <class M>
  FieldTable& add(const char* name, bool required, M S::*member, const char* sentence,
                  const char* facts) {
    using T = typename Inner<M>::Type;
    Row schema = Carrier<T>::schema();
    if (*facts != 0) schema.update(Row::parse(facts));
    if (*sentence != 0) schema["description"] = sentence;
    this->push_back({name, required, std::move(schema),
                     [name, member](const S& part, Row& row) {
                       if constexpr (Inner<M>::kOptional) {
                         if (part.*member) row[name] = Carrier<T>::write(*(part.*member));
                       } else {
                         row[name] = Carrier<T>::write(part.*member);
                       }
                     },
                     [member](const Row& row, S& part, const std::string& where) {
                       if constexpr (Inner<M>::kOptional)
                         Carrier<T>::read(row, (part.*member).emplace(), where);
                       else
                         Carrier<T>::read(row, part.*member, where);
                     }});
    return *this;
  }
};

template <class S>
Row to_json(const S& part) {
  return Carrier<S>::write(part);
}

template <class S>
S from_json(const Row& row) {
  S part;
  Carrier<S>::read(row, part, "");
  return part;
}

// The tables of what other tables are made of.
template <>
FieldTable<Repeated> table_of();
template <>
FieldTable<Parts> table_of();
/// Statistics have one place in the schema of rows.
template <>
Row Carrier<Repeated>::schema();

}  // namespace cvr::experiments
