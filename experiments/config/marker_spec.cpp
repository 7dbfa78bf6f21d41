#include "experiments/config/marker_spec.hpp"

#include <fmt/format.h>

namespace cvr::experiments {

namespace {

constexpr std::uint64_t kMostDecimals = 9;

void check_marker(const MarkerSpec& spec, const YamlValue& value) {
  const bool lines = !spec.lines.rows.empty();
  int kinds = lines ? 1 : 0;
  for (const std::string* one : {&spec.value, &spec.least, &spec.largest, &spec.range, &spec.sum,
                                 &spec.cells, &spec.table, &spec.claim})
    kinds += one->empty() ? 0 : 1;
  kinds += spec.claims.empty() ? 0 : 1;
  if (kinds != 1)
    value.reject(
        fmt::format("expected one of the keys value, least, largest, range, sum, cells, "
                    "table, rows, claim and claims, found {}",
                    kinds == 0 ? "none" : "several"));
  if (lines == (spec.lines.columns.empty() && !spec.lines.pivot))
    value.reject("expected rows beside columns or pivot, found one without the other");
}

}  // namespace

std::vector<Key<MarkerSpec>> marker_keys(const std::string& document, MetricNames metrics) {
  using M = MarkerSpec;
  const auto metric = metric_name(metrics);
  const auto own = [](auto TableSpec::*member) {
    return [member](M& spec, auto value) { spec.lines.*member = std::move(value); };
  };
  return {
      required(key("run", &M::run, one_text("a name"), "", "A folder of results/evidence.")),
      key("value", &M::value, metric, "", "The figure of the one line that `where` keeps."),
      key("over", &M::over, conditions(), "",
          "Beside `value`: of which other line the figure is divided by the same figure."),
      key("least", &M::least, metric, "", "The least figure of all lines that `where` keeps."),
      key("largest", &M::largest, metric, "", "The largest one."),
      key("range", &M::range, metric, "", "Both."),
      key("sum", &M::sum, metric, "", "The sum of them."),
      key("cells", &M::cells,
          one_word({"ok", "failed", "timeout", "out-of-memory", "unsupported", "data-missing"},
                   "a status"),
          "", "How many cells have this status."),
      key("table", &M::table, one_text("a name"), "", "A table of the configuration."),
      key<M>("rows", list_of(line_label(), "labels of a line"), own(&TableSpec::rows), "",
             "A table of the marker's own, with `columns` or `pivot` and perhaps `published` as "
             "tables of configurations have them."),
      key<M>("columns", list_of(metric, "metrics"), own(&TableSpec::columns), "", "Metrics."),
      key<M>("pivot", map_of(pivot_keys(metrics), "a map"), own(&TableSpec::pivot), "",
             "Spreads one metric over columns."),
      key<M>("published", map_of(published_place_keys(document), "a map"),
             own(&TableSpec::published), "", "Figures of a publication."),
      key("claim", &M::claim, one_text("a name"), "", "The verdict on one claim."),
      key("claims", &M::claims, list_of(one_text("a name"), "names of claims"), "",
          "A table of claims; [all]: of all of the configuration."),
      key("where", &M::where, conditions(), "", "Keeps cells whose labels match."),
      key("decimals", &M::decimals, whole_number(0, kMostDecimals), "as in tables",
          "Digits behind the point."),
  };
}

MarkerSpec read_marker(const std::string& body, const std::string& place,
                       const std::string& document, MetricNames metrics) {
  const YamlValue value = YamlValue::from_text(body, place);
  MarkerSpec spec;
  read_keys(value, marker_keys(document, metrics), spec);
  check_marker(spec, value);
  return spec;
}

}  // namespace cvr::experiments
