#include "experiments/config/claim_spec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/config/table_spec.hpp"

namespace cvr::experiments {

namespace {

constexpr double kLargest = 1e300;

Comparison read_comparison(const YamlValue& value) {
  const std::string name = value.text("difference or ratio");
  if (name == "difference") return Comparison::kDifference;
  if (name == "ratio") return Comparison::kRatio;
  value.expected("difference or ratio");
}

Quorum read_quorum(const YamlValue& value) {
  const std::string name = value.text("all, most or some");
  if (name == "all") return Quorum::kAll;
  if (name == "most") return Quorum::kMost;
  if (name == "some") return Quorum::kSome;
  value.expected("all, most or some");
}

std::string read_number_metric(const YamlValue& value, MetricNames metrics) {
  const std::string name = read_metric(value, metrics);
  if (!find_metric_name(metrics, name)->numeric) value.expected("a metric that is a number");
  return name;
}

bool is_psnr(std::string_view metric) { return metric.ends_with("psnr_db"); }

/// What single keys cannot tell: which of them go together.
void check_keys(const ClaimSpec& claim, const YamlValue& value, MetricNames metrics) {
  if (claim.published && !find_metric_name(metrics, claim.metric)->published)
    value.reject(fmt::format(
        "expected a metric that publications state beside published, found '{}'", claim.metric));
  const bool bounded = std::isfinite(claim.at_least) || std::isfinite(claim.at_most);
  const bool compared = claim.compare != Comparison::kFigure;
  const int rights = (claim.sides.size() == 2 && !claim.ordered ? 1 : 0) + (claim.value ? 1 : 0) +
                     (claim.published ? 1 : 0);
  if (claim.sides.empty()) value.reject("expected the key left or order, found none");
  if (claim.ordered && rights > 0)
    value.reject("expected order alone, found right, value or published beside it");
  if (claim.ordered && bounded)
    value.reject("expected order without at_least and at_most, found one");
  if (rights > 1)
    value.reject("expected one of the keys right, value and published, found several");
  if (!claim.ordered && !bounded) value.reject("expected the key at_least or at_most, found none");
  if (claim.at_least > claim.at_most) value.reject("expected at_least of at most at_most");
  if ((claim.ordered || rights > 0) != compared)
    value.reject(fmt::format(
        "expected the key compare beside right, value, published or order alone, found {}",
        compared ? "it without them" : "them without it"));
  if (claim.over.empty()) return;
  if (!is_psnr(claim.metric))
    value.reject(
        fmt::format("expected a metric in dB beside over (one that ends in psnr_db), found '{}'",
                    claim.metric));
  if (claim.ordered || claim.sides.size() != 2 || claim.compare != Comparison::kDifference)
    value.reject("expected left, right and compare: difference beside over, found others");
}

/// Whether a claim is about cells of the stage render: its metric is one of images, or one of its
/// labels is.
bool is_about_images(const ClaimSpec& claim, MetricNames metrics) {
  const auto of_images = [&](const std::string& name) {
    return !name.empty() && find_metric_name(metrics, name)->of_images;
  };
  const auto names_images = [](const Conditions& conditions) {
    return std::ranges::any_of(conditions, [](const auto& c) { return is_render_label(c.first); });
  };
  return of_images(claim.metric) || of_images(claim.over) || names_images(claim.where) ||
         std::ranges::any_of(claim.each, is_render_label) ||
         std::ranges::any_of(claim.sides,
                             [&](const ClaimSide& side) { return names_images(side.conditions); });
}

}  // namespace

std::string_view name_of(Comparison comparison) {
  switch (comparison) {
    case Comparison::kFigure:
      return "figure";
    case Comparison::kDifference:
      return "difference";
    case Comparison::kRatio:
      return "ratio";
  }
  return "?";
}

ClaimSpec read_claim(const YamlValue& value, const std::string& config_path, MetricNames metrics) {
  ClaimSpec claim;
  std::optional<ClaimSide> left, right;
  const auto side_into = [](std::optional<ClaimSide>& side) {
    return [&side](const YamlValue& v) { side = ClaimSide{read_conditions(v), v.place()}; };
  };
  const auto number_into = [](auto& target) {
    return [&target](const YamlValue& v) { target = v.number(-kLargest, kLargest); };
  };
  value.fields(
      {{"name", [&](const YamlValue& v) { claim.name = v.text("a name"); }, true},
       {"says", [&](const YamlValue& v) { claim.says = v.text("what the paper says"); }, true},
       {"source", [&](const YamlValue& v) { claim.source = v.text("paper and section"); }, true},
       {"metric", [&](const YamlValue& v) { claim.metric = read_number_metric(v, metrics); }, true},
       {"left", side_into(left)},
       {"right", side_into(right)},
       {"value", number_into(claim.value)},
       {"published",
        [&](const YamlValue& v) { claim.published = read_published_place(v, config_path); }},
       {"order",
        [&](const YamlValue& v) {
          claim.ordered = true;
          for (const YamlValue& one : v.list("sides"))
            claim.sides.push_back({read_conditions(one), one.place()});
          if (claim.sides.size() < 2) v.expected("a list of two sides or more");
        }},
       {"compare", [&](const YamlValue& v) { claim.compare = read_comparison(v); }},
       {"at_least", number_into(claim.at_least)},
       {"at_most", number_into(claim.at_most)},
       {"tolerance", [&](const YamlValue& v) { claim.tolerance = v.number(0, kLargest); }},
       {"over", [&](const YamlValue& v) { claim.over = read_number_metric(v, metrics); }},
       {"each",
        [&](const YamlValue& v) {
          for (const YamlValue& one : v.list("labels")) claim.each.push_back(read_line_label(one));
        }},
       {"where", [&](const YamlValue& v) { claim.where = read_conditions(v); }},
       {"holds_in", [&](const YamlValue& v) { claim.quorum = read_quorum(v); }}});
  if (claim.ordered && (left || right))
    value.reject("expected order or left and right, found both");
  if (right && !left) value.reject("expected the key left beside right, found none");
  if (left) claim.sides.push_back(*left);
  if (right) claim.sides.push_back(*right);
  check_keys(claim, value, metrics);
  claim.renders = is_about_images(claim, metrics);
  if (claim.ordered) claim.at_least = claim.compare == Comparison::kRatio ? 1 : 0;
  return claim;
}

std::string ClaimSpec::describe_bounds() const {
  const char* sign = compare == Comparison::kRatio ? "/" : "-";
  std::string text = compare == Comparison::kFigure ? "the figure"
                     : ordered                      ? fmt::format("each {} the one before", sign)
                     : value                        ? fmt::format("left {} {:.6g}", sign, *value)
                             : fmt::format("left {} {}", sign, published ? "published" : "right");
  if (!over.empty()) text += fmt::format(", mean over {}", over);
  if (std::isfinite(at_least)) text += fmt::format(", at least {:.6g}", at_least);
  if (std::isfinite(at_most)) text += fmt::format(", at most {:.6g}", at_most);
  if (tolerance > 0) text += fmt::format(", tolerance {:.6g}", tolerance);
  return text;
}

}  // namespace cvr::experiments
