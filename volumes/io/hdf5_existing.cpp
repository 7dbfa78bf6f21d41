#include "volumes/io/hdf5_existing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "volumes/io/format.hpp"
#include "volumes/io/hdf5_attributes.hpp"
#include "volumes/io/hdf5_objects.hpp"
#include "volumes/io/hdf5_process.hpp"

namespace cvr::volumes {

namespace {

using Json = nlohmann::json;

constexpr unsigned kListSeconds = 5;

Json list_existing(const std::string& path) {
  const Hdf5Handle file = open_hdf5_file(path, H5F_ACC_RDONLY);
  const Hdf5Content content = list_hdf5(file.get());
  bool ours = content.datasets.size() == 1;
  if (ours) {
    const Hdf5Handle dataset(
        H5Dopen2(file.get(), content.datasets.front().name.c_str(), H5P_DEFAULT), H5Dclose);
    ours = dataset.valid() && Hdf5Attributes(read_hdf5_attributes(dataset.get())).ours();
  }
  Json names = Json::array();
  for (const Hdf5Entry& entry : content.datasets) names.push_back(entry.name);
  return {{"datasets", names},
          {"groups", content.groups},
          {"links", content.links.size()},
          {"ours", ours},
          {"text", to_string(content)}};
}

Json ask(const std::string& path) {
  const Hdf5Process process(
      1, [path](const Json&, std::span<std::byte>) { return list_existing(path); });
  return process.call(Json::object(), kListSeconds);
}

/// Nothing but a volume that this project wrote, or one dataset of the name that is about to be
/// written.
bool holds_only(const Json& found, const std::string& dataset) {
  const bool names =
      std::all_of(found["datasets"].begin(), found["datasets"].end(),
                  [&](const Json& name) { return name.get<std::string>() == dataset; });
  return (names || found["ours"].get<bool>()) && found["groups"].empty() && found["links"] == 0;
}

}  // namespace

bool keeps_existing_hdf5(const std::string& path, const std::string& dataset,
                         const std::string& written) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored) ||
      std::filesystem::file_size(path, ignored) == 0)
    return false;
  Json found;
  try {
    found = ask(path);
  } catch (const std::runtime_error& error) {  // also Hdf5Failure
    throw_input_error(
        path, "",
        "a new name, or an HDF5 file to write into (this one is there already; remove it to write "
        "anew)",
        error.what());
  }
  if (!dataset.empty()) return true;
  if (!holds_only(found, written)) {
    throw_input_error(path, "",
                      fmt::format("the name of a dataset to add or replace, as in {}:{}, or a new "
                                  "file: this one is there "
                                  "already and nothing else of it may be lost",
                                  path, written),
                      found["text"].get<std::string>());
  }
  return false;
}

void remove_hdf5_dataset(const std::string& path, long long file, const std::string& name) {
  for (std::size_t end = name.find('/', 1);; end = name.find('/', end + 1)) {
    const bool last = end == std::string::npos;
    const std::string part = name.substr(0, end);
    if (part.empty() || part.ends_with('/')) {
      if (last) return;
      continue;
    }
    H5L_info_t link;
    if (H5Lget_info(file, part.c_str(), &link, H5P_DEFAULT) < 0)
      return;  // nothing there, nor below it
    H5O_info_t object;
    const bool hard = link.type == H5L_TYPE_HARD;
    if (hard &&
        H5Oget_info_by_name2(file, part.c_str(), &object, H5O_INFO_BASIC, H5P_DEFAULT) < 0) {
      throw_input_error(path, fmt::format("'{}'", part), "a readable object", hdf5_reason());
    }
    if (!last && (!hard || object.type != H5O_TYPE_GROUP)) {
      throw_input_error(path, fmt::format("'{}'", part), "a group to write into",
                        hard ? "a dataset" : "a link");
    }
    if (!last) continue;
    if (hard && object.type != H5O_TYPE_DATASET) {
      throw_input_error(path, fmt::format("'{}'", part),
                        "the name of a dataset to replace, or of none", "a group");
    }
    if (H5Ldelete(file, part.c_str(), H5P_DEFAULT) < 0) throw_output_error(path, hdf5_reason());
    return;
  }
}

}  // namespace cvr::volumes
