#include "experiments/config/published.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/config/yaml_reader.hpp"

namespace cvr::experiments {

namespace {

PublishedFigure read_figure(const YamlValue& value) {
  PublishedFigure figure;
  const auto number_into = [](std::optional<double>& target) {
    return [&target](const YamlValue& v) { target = v.number(0, 1e12); };
  };
  value.fields({{"dataset", [&](const YamlValue& v) { figure.dataset = v.text(); }, true},
                {"codec", [&](const YamlValue& v) { figure.codec = v.text(); }, true},
                {"parameters",
                 [&](const YamlValue& v) {
                   for (const auto& [name, one] : v.entries())
                     figure.parameters.emplace_back(name.text(), one.text());
                 }},
                {"rate", number_into(figure.rate)},
                {"seconds", number_into(figure.seconds)},
                {"gb_per_s", number_into(figure.gb_per_s)},
                {"frame_ms", number_into(figure.frame_ms)},
                {"cache", [&](const YamlValue& v) { figure.cache = v.text("an access mode"); }},
                {"shading", [&](const YamlValue& v) { figure.shading = v.text("a shading"); }}});
  return figure;
}

}  // namespace

const PublishedFigure* PublishedTable::find(const Cell& cell) const {
  const std::string& dataset =
      cell.dataset->stand_in_for.empty() ? cell.dataset->name : cell.dataset->stand_in_for;
  const auto agrees = [&](const PublishedFigure& figure) {
    if (figure.dataset != dataset || figure.codec != cell.codec) return false;
    const auto same = [&](const std::string& wanted, std::string_view label) {
      return wanted.empty() || (cell.render && cell.render->label(label) == wanted);
    };
    if (!same(figure.cache, "cache") || !same(figure.shading, "shading")) return false;
    return std::ranges::all_of(figure.parameters, [&](const auto& parameter) {
      const auto found = cell.parameters.values().find(parameter.first);
      return found != cell.parameters.values().end() && found->second == parameter.second;
    });
  };
  const auto found = std::ranges::find_if(figures, agrees);
  return found == figures.end() ? nullptr : &*found;
}

PublishedTable load_published(const std::string& path, const std::string& table) {
  PublishedTable published;
  bool found = false;
  std::string own_hardware;
  const auto read_table = [&](const YamlValue& value) {
    PublishedTable here;
    value.fields({{"title", [&](const YamlValue& v) { here.title = v.text(); }, true},
                  {"hardware", [&](const YamlValue& v) { here.hardware = v.text(); }},
                  {"figures",
                   [&](const YamlValue& v) {
                     for (const YamlValue& one : v.list("figures"))
                       here.figures.push_back(read_figure(one));
                   },
                   true}});
    return here;
  };
  YamlValue::from_file(path).fields(
      {{"citation", [&](const YamlValue& v) { published.citation = v.text(); }, true},
       {"hardware", [&](const YamlValue& v) { published.hardware = v.text(); }},
       {"notes", [](const YamlValue& v) { v.text(); }},
       {"tables",
        [&](const YamlValue& v) {
          for (const auto& [name, value] : v.entries()) {
            PublishedTable here = read_table(value);
            if (name.text() != table) continue;
            published.title = here.title;
            own_hardware = here.hardware;
            published.figures = std::move(here.figures);
            found = true;
          }
        },
        true}});
  if (!found) throw InputError(fmt::format("{}: expected a table '{}', found none", path, table));
  if (!own_hardware.empty()) published.hardware = own_hardware;
  return published;
}

}  // namespace cvr::experiments
