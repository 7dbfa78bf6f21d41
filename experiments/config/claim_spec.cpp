#include "experiments/config/claim_spec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/config/render_options.hpp"

namespace cvr::experiments {

namespace {

constexpr double kLargest = 1e300;

/// find() of a table of names.
template <class Names>
auto finder(const Names& names) {
  return [&names](std::string_view name) { return names.find(name); };
}

Shape<std::string> number_metric(MetricNames metrics) {
  auto shape = metric_name(metrics);
  shape.read = [read = shape.read, metrics](const YamlValue& value) {
    std::string name = read(value);
    if (!find_metric_name(metrics, name)->numeric) value.expected("a metric that is a number");
    return name;
  };
  shape.values = "a metric that is a number";
  return shape;
}

Shape<ClaimSide> one_side() {
  const auto all = conditions();
  return {[read = all.read](const YamlValue& value) {
            return ClaimSide{read(value), value.place()};
          },
          all.values, all.schema};
}

/// A key whose value goes into a member of the claim.
template <class T, class M>
Key<ClaimDraft> claim_key(std::string name, M ClaimSpec::*member, const Shape<T>& shape,
                          std::string fallback, std::string sentence) {
  return key<ClaimDraft>(
      std::move(name), shape,
      [member](ClaimDraft& d, T value) { d.claim.*member = std::move(value); }, std::move(fallback),
      std::move(sentence));
}

bool is_psnr(std::string_view metric) { return metric.ends_with("psnr_db"); }

/// A claim that says why it cannot be tested has nothing to compare.
void check_not_testable(const ClaimSpec& claim, const YamlValue& value) {
  if (!claim.metric.empty() || !claim.sides.empty() || claim.value || claim.published)
    value.reject("expected not_testable alone, found what would be compared beside it");
}

/// What single keys cannot tell: which of them go together.
void check_keys(const ClaimSpec& claim, const YamlValue& value, MetricNames metrics) {
  if (claim.metric.empty()) value.reject("expected the key metric, found none");
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

std::vector<Key<ClaimDraft>> claim_keys(const std::string& config_path, MetricNames metrics) {
  using D = ClaimDraft;
  const auto any = real_number(-kLargest, kLargest);
  const auto order = list_of(one_side(), "sides");
  const Shape<std::vector<ClaimSide>> two_or_more{[read = order.read](const YamlValue& value) {
                                                    auto sides = read(value);
                                                    if (sides.size() < 2)
                                                      value.expected("a list of two sides or more");
                                                    return sides;
                                                  },
                                                  "a list of two maps of conditions or more",
                                                  schema_of_list(conditions().schema, 2)};
  return {
      required(
          claim_key("name", &ClaimSpec::name, one_text("a name"), "", "Tells it from others.")),
      required(claim_key("says", &ClaimSpec::says, one_text("what the paper says"), "",
                         "The paper's words, shortened.")),
      required(claim_key("source", &ClaimSpec::source, one_text("paper and section"), "",
                         "Paper, section, figure.")),
      claim_key("metric", &ClaimSpec::metric, number_metric(metrics), "", "What is compared."),
      key("left", &D::left, one_side(), "", "One line of a table in each group."),
      key("right", &D::right, one_side(), "", "What it is compared with; or"),
      claim_key("value", &ClaimSpec::value, any, "", "a number; or"),
      claim_key("published", &ClaimSpec::published,
                map_of(published_place_keys(config_path), "a map"), "",
                "the published figure of the same line and quantity; or none of them: the figure "
                "itself is held to the bounds."),
      key<D>(
          "order", two_or_more,
          [](D& d, std::vector<ClaimSide> sides) {
            d.claim.ordered = true;
            d.claim.sides = std::move(sides);
          },
          "", "In place of left and right: lines by ascending metric."),
      claim_key("compare", &ClaimSpec::compare,
                named(finder(kComparisonNames), {"difference", "ratio"}, "difference or ratio"), "",
                "left - right or left / right; needed beside right, value, published and order."),
      claim_key("at_least", &ClaimSpec::at_least, any, "",
                "Bound of the figure, difference or ratio; one of them or both, not beside order."),
      claim_key("at_most", &ClaimSpec::at_most, any, "", "The other bound."),
      claim_key("tolerance", &ClaimSpec::tolerance, real_number(0, kLargest), "0",
                "Widens the bounds."),
      claim_key("over", &ClaimSpec::over, number_metric(metrics), "",
                "The sides are curves of a PSNR over this metric, and their difference is the mean "
                "over the logarithm of what both have."),
      claim_key("each", &ClaimSpec::each, list_of(line_label(), "labels"), "one group",
                "A group for each combination of the values of these labels."),
      claim_key("where", &ClaimSpec::where, conditions(), "", "Restricts all sides."),
      claim_key("holds_in", &ClaimSpec::quorum,
                named(finder(kQuorumNames), {"all", "most", "some"}, "all, most or some"), "all",
                "Of the groups that can be checked, where the paper speaks of such a share."),
      claim_key("fitted", &ClaimSpec::fitted, conditions(), "",
                "Groups whose left side matches prove nothing, because their volumes were made to "
                "meet the published figure: they are marked as fitted and not counted."),
      claim_key("not_testable", &ClaimSpec::not_testable, one_text("a reason"), "",
                "In place of metric and sides: why this claim cannot be tested here."),
  };
}

ClaimSpec read_claim(const YamlValue& value, const std::string& config_path, MetricNames metrics) {
  ClaimDraft draft;
  read_keys(value, claim_keys(config_path, metrics), draft);
  ClaimSpec claim = std::move(draft.claim);
  if (claim.ordered && (draft.left || draft.right))
    value.reject("expected order or left and right, found both");
  if (draft.right && !draft.left) value.reject("expected the key left beside right, found none");
  if (draft.left) claim.sides.push_back(*draft.left);
  if (draft.right) claim.sides.push_back(*draft.right);
  if (!claim.not_testable.empty()) {
    check_not_testable(claim, value);
    return claim;
  }
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
