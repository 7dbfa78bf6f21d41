#include "experiments/tracking/noise_floor.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "experiments/results/provenance.hpp"
#include "volumes/error.hpp"
#include "volumes/io/file.hpp"
#include "volumes/json_text.hpp"

namespace cvr::experiments {

namespace {

namespace fs = std::filesystem;

/// An empty object where there is no file.
Row load(const std::string& path) {
  if (!fs::exists(path)) return Row::object();
  Row file = volumes::read_json_file(path);
  if (!file.is_object())
    throw volumes::InputError(fmt::format(
        "{}: expected a JSON object of noise floors a machine, found another text", path));
  return file;
}

}  // namespace

double NoiseFloors::of(std::string_view noise_class) const {
  const auto found = floors_.find(noise_class);
  return found == floors_.end() ? kAssumedFloor : found->second;
}

NoiseFloors load_floors(const std::string& path, const std::string& machine,
                        Arrangement arrangement) {
  NoiseFloors floors;
  const Row file = load(path);
  if (!file.contains(machine)) return floors;
  const Row& known = file.at(machine);
  if (!known.is_object())
    throw volumes::InputError(fmt::format("{}: {}: expected an object of noise floors, found {}",
                                          path, machine, known.type_name()));
  const std::string arranged(name_of(arrangement));
  if (!known.contains(arranged)) return floors;
  if (!known.at(arranged).is_object())
    throw volumes::InputError(fmt::format("{}: {} {}: expected an object, found {}", path, machine,
                                          arranged, known.at(arranged).type_name()));
  for (const auto& [noise_class, entry] : known.at(arranged).items()) {
    if (!entry.is_object() || !entry.contains("floor") || !entry["floor"].is_number() ||
        !(entry["floor"].get<double>() >= 0))
      throw volumes::InputError(
          fmt::format("{}: {} {}: expected an object with a number 'floor' from 0", path, machine,
                      noise_class));
    floors.set(noise_class, entry["floor"].get<double>());
  }
  return floors;
}

void store_floors(const std::string& path, const Provenance& provenance, const std::string& config,
                  Arrangement arrangement, const Row& measured) {
  Row file = load(path);
  Row& machine = file[provenance.machine];
  machine["cpu"] = provenance.cpu;
  machine["cores"] = provenance.cores;
  machine["time"] = utc_now();
  machine["config"] = config;
  machine[std::string(name_of(arrangement))] = measured;
  if (const fs::path folder = fs::path(path).parent_path(); !folder.empty())
    fs::create_directories(folder);
  volumes::write_whole_file(path, file.dump(2) + "\n");
}

}  // namespace cvr::experiments
