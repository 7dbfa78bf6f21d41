// Reads the descriptions of data sets.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "experiments/config/dataset_keys.hpp"
#include "experiments/config/datasets.hpp"
#include "experiments/config/yaml_reader.hpp"
#include "volumes/generators/generator.hpp"

namespace cvr::experiments {

volumes::Extent Dataset::generated_extent() const {
  const auto scaled = [this](std::uint64_t n) {
    return std::max<std::uint64_t>(
        1, static_cast<std::uint64_t>(std::llround(static_cast<double>(n) * scale)));
  };
  return {scaled(extent.x), scaled(extent.y), scaled(extent.z)};
}

Catalogue Catalogue::from_folder(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path().string());
  }
  if (error || files.empty()) {
    throw InputError(
        fmt::format("{}: expected a folder of data set descriptions (*.yaml), found none", folder));
  }
  std::ranges::sort(files);
  Catalogue catalogue;
  for (const std::string& file : files) catalogue.add_file(file);
  return catalogue;
}

void Catalogue::add_file(const std::string& path) {
  for (const auto& [name, value] : YamlValue::from_file(path).entries()) {
    if (find(name.text()) != nullptr) {
      name.reject(fmt::format("expected a name that no other description has, found '{}' again",
                              name.text()));
    }
    datasets_.push_back(read_description(name.text(), value, path));
  }
}

const Dataset* Catalogue::find(const std::string& name) const {
  const auto found = std::ranges::find(datasets_, name, &Dataset::name);
  return found == datasets_.end() ? nullptr : &*found;
}

std::vector<std::string> Catalogue::names() const {
  std::vector<std::string> names;
  for (const Dataset& dataset : datasets_) names.push_back(dataset.name);
  return names;
}

}  // namespace cvr::experiments
