#include "volumes/io/hdf5_attributes.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "volumes/io/hdf5_handle.hpp"

namespace cvr::volumes {

namespace {

using Json = nlohmann::json;

constexpr std::array kNames{
    "voxel_size", "offset",  "voxel_unit",      "kind",       "axes",     "name",
    "source",     "licence", "element_size_um", "resolution", "axistags", "DIMENSION_LABELS"};
constexpr hssize_t kMaximumValues = 64;
constexpr std::size_t kMaximumText = 1 << 20;

/// Texts of variable length.
Json read_variable_texts(hid_t attribute, hid_t type, hid_t space, std::size_t count) {
  std::vector<char*> values(count, nullptr);
  if (H5Aread(attribute, type, values.data()) < 0) return nullptr;
  Json texts = Json::array();
  for (const char* value : values) {
    texts.push_back(value == nullptr ? std::string()
                                     : std::string(value, ::strnlen(value, kMaximumText)));
  }
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, values.data());
  return texts;
}

Json read_fixed_texts(hid_t attribute, hid_t type, std::size_t count) {
  const std::size_t size = H5Tget_size(type);
  if (size == 0 || size > kMaximumText) return nullptr;
  std::string all(size * count, '\0');
  if (H5Aread(attribute, type, all.data()) < 0) return nullptr;
  const bool spaces = H5Tget_strpad(type) == H5T_STR_SPACEPAD;
  Json texts = Json::array();
  for (std::size_t i = 0; i < count; ++i) {
    std::string text(all.data() + i * size, ::strnlen(all.data() + i * size, size));
    while (spaces && text.ends_with(' ')) text.pop_back();
    texts.push_back(std::move(text));
  }
  return texts;
}

Json read_attribute(hid_t attribute) {
  const Hdf5Handle type(H5Aget_type(attribute), H5Tclose);
  const Hdf5Handle space(H5Aget_space(attribute), H5Sclose);
  const hssize_t points = H5Sget_simple_extent_npoints(space.get());
  if (points < 1 || points > kMaximumValues) return nullptr;
  const auto count = static_cast<std::size_t>(points);
  const bool scalar = H5Sget_simple_extent_ndims(space.get()) == 0;
  const H5T_class_t kind = H5Tget_class(type.get());
  Json values;
  if (kind == H5T_STRING) {
    values = H5Tis_variable_str(type.get()) > 0
                 ? read_variable_texts(attribute, type.get(), space.get(), count)
                 : read_fixed_texts(attribute, type.get(), count);
  } else if (kind == H5T_INTEGER || kind == H5T_FLOAT) {
    std::vector<double> numbers(count);
    if (H5Aread(attribute, H5T_NATIVE_DOUBLE, numbers.data()) >= 0) values = numbers;
  }
  return scalar && values.is_array() ? values.front() : values;
}

/// Whether the bytes are UTF-8: what every report of ours is written in.
bool is_utf8(const std::string& text) {
  try {
    return !Json(text).dump().empty();
  } catch (const Json::exception&) {
    return false;
  }
}

std::optional<std::string> clean(const Json& value) {
  if (!value.is_string()) return std::nullopt;
  auto text = value.get<std::string>();
  if (!is_utf8(text)) return std::nullopt;
  const auto control = [](char c) {
    return (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7f;
  };
  std::replace_if(text.begin(), text.end(), control, ' ');
  return text;
}

std::array<double, 3> reversed(const std::vector<double>& zyx) { return {zyx[2], zyx[1], zyx[0]}; }

}  // namespace

nlohmann::json read_hdf5_attributes(hid_t object) {
  Json values = Json::object();
  for (const char* name : kNames) {
    if (H5Aexists(object, name) <= 0) continue;
    const Hdf5Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
    if (!attribute.valid()) continue;
    if (Json value = read_attribute(attribute.get()); !value.is_null())
      values[name] = std::move(value);
  }
  return values;
}

std::optional<std::string> Hdf5Attributes::text(const char* name) const {
  const auto found = values_.find(name);
  if (found == values_.end()) return std::nullopt;
  return clean(found->is_array() && found->size() == 1 ? found->front() : *found);
}

std::optional<std::vector<std::string>> Hdf5Attributes::texts(const char* name) const {
  const auto found = values_.find(name);
  if (found == values_.end() || !found->is_array()) return std::nullopt;
  std::vector<std::string> result;
  for (const Json& value : *found) {
    const auto text = clean(value);
    if (!text) return std::nullopt;
    result.push_back(*text);
  }
  return result;
}

std::optional<std::vector<double>> Hdf5Attributes::numbers(const char* name,
                                                           std::size_t count) const {
  const auto found = values_.find(name);
  if (found == values_.end() || !found->is_array() || found->size() != count) return std::nullopt;
  std::vector<double> result;
  for (const Json& value : *found) {
    if (!value.is_number() || !std::isfinite(value.get<double>())) return std::nullopt;
    result.push_back(value.get<double>());
  }
  return result;
}

std::optional<std::array<double, 3>> Hdf5Attributes::triple(const char* name, bool positive) const {
  const auto zyx = numbers(name, 3);
  if (!zyx) return std::nullopt;
  if (positive && !std::all_of(zyx->begin(), zyx->end(), [](double v) { return v > 0; }))
    return std::nullopt;
  return reversed(*zyx);
}

std::optional<VolumeKind> Hdf5Attributes::kind() const {
  const auto word = text("kind");
  return word ? volume_kind_from_name(*word) : std::nullopt;
}

std::optional<std::vector<Hdf5Axis>> hdf5_axistags(const std::string& text) {
  const Json tags = Json::parse(text, nullptr, false);
  if (!tags.is_object() || !tags.contains("axes") || !tags["axes"].is_array()) return std::nullopt;
  std::vector<Hdf5Axis> axes;
  for (const Json& tag : tags["axes"]) {
    if (!tag.is_object() || !tag.contains("key") || !tag["key"].is_string()) return std::nullopt;
    const Json resolution = tag.value("resolution", Json(0.0));
    axes.push_back(
        {tag["key"].get<std::string>(), resolution.is_number() ? resolution.get<double>() : 0.0});
  }
  return axes;
}

namespace {

/// Voxel size and unit by other people's attributes.
void understand_others(const Hdf5Attributes& dataset, std::size_t rank,
                       const std::array<int, 3>& axis, Hdf5Meaning& meaning) {
  const auto take = [&](const std::vector<double>& by_axis, const char* unit) {
    std::array<double, 3> size{1, 1, 1};
    for (std::size_t i = 0; i < 3; ++i) {
      if (axis[i] >= 0) size[i] = by_axis[static_cast<std::size_t>(axis[i])];
    }
    if (!std::all_of(size.begin(), size.end(), [](double v) { return std::isfinite(v) && v > 0; }))
      return;
    meaning.voxel_size = size;
    meaning.voxel_unit = unit;
  };
  if (const auto resolution = dataset.triple("resolution", true)) {
    meaning.voxel_size = *resolution;
    meaning.voxel_unit = "nm";
  } else if (const auto element = dataset.triple("element_size_um", true)) {
    meaning.voxel_size = *element;
    meaning.voxel_unit = "um";
  } else if (const auto by_axis = dataset.numbers("element_size_um", rank)) {
    take(*by_axis, "um");
  } else if (const auto text = dataset.text("axistags")) {
    const auto tags = hdf5_axistags(*text);
    if (!tags || tags->size() != rank) return;
    std::vector<double> resolutions;
    for (const Hdf5Axis& tag : *tags) resolutions.push_back(tag.resolution);
    take(resolutions, "");
  }
}

}  // namespace

Hdf5Meaning understand_hdf5(const Hdf5Attributes& dataset, const Hdf5Attributes& root,
                            std::size_t rank, const std::array<int, 3>& axis) {
  // What the root says is of this dataset only where the dataset does not speak for itself.
  const Hdf5Attributes silent;
  const Hdf5Attributes& file = dataset.ours() ? silent : root;
  const auto text = [&](const char* name) {
    if (const auto own = dataset.text(name)) return *own;
    return file.text(name).value_or("");
  };
  Hdf5Meaning meaning;
  understand_others(dataset, rank, axis, meaning);
  for (const Hdf5Attributes* level : {&file, &dataset}) {
    const auto size = level->triple("voxel_size", true);
    if (!size || (level == &file && meaning.voxel_size != std::array<double, 3>{1, 1, 1})) continue;
    meaning.voxel_size = *size;
    meaning.voxel_unit = text("voxel_unit");
    if (const auto offset = level->triple("offset", false)) meaning.offset = *offset;
  }
  if (const auto offset = dataset.triple("offset", false)) meaning.offset = *offset;
  if (meaning.voxel_unit.empty()) meaning.voxel_unit = text("voxel_unit");
  meaning.kind = dataset.kind() ? dataset.kind() : file.kind();
  meaning.provenance = {text("name"), text("source"), text("licence")};
  return meaning;
}

}  // namespace cvr::volumes
