#include "experiments/config/published.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/config/yaml_reader.hpp"

namespace cvr::experiments {

const PublishedFigure* PublishedTable::find(const Cell& cell) const {
  const std::string& dataset =
      cell.dataset->stand_in_for.empty() ? cell.dataset->name : cell.dataset->stand_in_for;
  const auto agrees = [&](const PublishedFigure& figure) {
    if (figure.dataset != dataset || (!figure.codec.empty() && figure.codec != cell.codec))
      return false;
    const auto same = [&](const std::string& wanted, std::string_view label) {
      return wanted.empty() || (cell.render && cell.render->label(label) == wanted);
    };
    if (!same(figure.access_mode, "access_mode") || !same(figure.shading, "shading")) return false;
    return std::ranges::all_of(figure.parameters, [&](const auto& parameter) {
      const auto found = cell.parameters.values().find(parameter.first);
      return found != cell.parameters.values().end() && found->second == parameter.second;
    });
  };
  const auto found = std::ranges::find_if(figures, agrees);
  return found == figures.end() ? nullptr : &*found;
}

std::vector<Key<PublishedFigure>> published_figure_keys() {
  using F = PublishedFigure;
  const auto number = real_number(0, 1e12);
  const Shape<std::vector<std::pair<std::string, std::string>>> parameters{
      [](const YamlValue& value) {
        std::vector<std::pair<std::string, std::string>> all;
        for (const auto& [name, one] : value.entries()) all.emplace_back(name.text(), one.text());
        return all;
      },
      "a map of names and values", R"({"type": "object"})"};
  return {required(key("dataset", &F::dataset, one_text(), "",
                       "A data set, or the one that a generated volume stands in for.")),
          key("codec", &F::codec, one_text(), "any", "The id of a codec."),
          key("parameters", &F::parameters, parameters, "",
              "Parameters of the codec that the figure is about; all must agree."),
          key("rate", &F::rate, number, "", "Encoded size in percent of the original."),
          key("seconds", &F::seconds, number, "", "Seconds to encode."),
          key("labels", &F::labels, number, "", "Distinct labels of the data set."),
          key("original_gb", &F::original_gb, number, "", "Gigabytes of the original."),
          key("bricks", &F::bricks, number, "", "Of images: bricks of the volume."),
          key("cache_bytes_per_voxel", &F::cache_bytes_per_voxel, number, "",
              "Of images: bytes of the cache over voxels of the volume."),
          key("voxels_per_pixel", &F::voxels_per_pixel, number, "",
              "Of images: voxels of the volume over pixels of a frame."),
          key("frames_per_brick", &F::frames_per_brick, number, "",
              "Of images: frames of the path over bricks of the volume."),
          key("logged_rate", &F::logged_rate, number, "",
              "The same in the authors' own log, which the publication rounds."),
          key("logged_bytes", &F::logged_bytes, number, "", "Encoded bytes that the log says."),
          key("gb_per_s", &F::gb_per_s, number, "", "Gigabytes per second of encoding."),
          key("frame_ms", &F::frame_ms, number, "", "Milliseconds per frame."),
          key("logged_frame_ms", &F::logged_frame_ms, number, "",
              "The mean of the frames in a log of the authors."),
          key("logged_frame_min_ms", &F::logged_frame_min_ms, number, "",
              "The fastest frame of that log."),
          key("logged_frame_max_ms", &F::logged_frame_max_ms, number, "",
              "The slowest frame of that log."),
          key("access_mode", &F::access_mode, one_text("an access mode"), "",
              "Of images: the access mode."),
          key("shading", &F::shading, one_text("a shading"), "", "Of images: the shading.")};
}

std::vector<Key<PublishedTable>> published_table_keys() {
  using T = PublishedTable;
  return {required(key("title", &T::title, one_text(), "", "")),
          key("hardware", &T::hardware, one_text(), "that of the file", ""),
          required(key("figures", &T::figures,
                       list_of(map_of(published_figure_keys(), "a map"), "figures"), "", ""))};
}

std::vector<Key<PublishedFile>> published_file_keys() {
  using F = PublishedFile;
  const auto one_table = map_of(published_table_keys(), "a map");
  const Shape<std::vector<std::pair<std::string, PublishedTable>>> tables{
      [read = one_table.read](const YamlValue& value) {
        std::vector<std::pair<std::string, PublishedTable>> all;
        for (const auto& [name, table] : value.entries())
          all.emplace_back(name.text(), read(table));
        return all;
      },
      "a map of names and tables",
      fmt::format(R"({{"type": "object", "additionalProperties": {}}})", one_table.schema)};
  return {required(key("citation", &F::citation, one_text(), "", "The publication.")),
          key("hardware", &F::hardware, one_text(), "", "What it measured on."),
          key("notes", &F::notes, one_text(), "", "What a reader should know of the figures."),
          required(key("tables", &F::tables, tables, "", "Its tables by name."))};
}

PublishedTable load_published(const std::string& path, const std::string& table,
                              const std::vector<std::string>& scaled) {
  PublishedFile file;
  read_keys(YamlValue::from_file(path), published_file_keys(), file);
  for (auto& [name, found] : file.tables) {
    if (name != table) continue;
    found.citation = file.citation;
    if (found.hardware.empty()) found.hardware = file.hardware;
    for (PublishedFigure& figure : found.figures)
      std::erase_if(figure.parameters, [&](const auto& parameter) {
        return std::ranges::find(scaled, parameter.first) != scaled.end();
      });
    return std::move(found);
  }
  throw InputError(fmt::format("{}: expected a table '{}', found none", path, table));
}

}  // namespace cvr::experiments
