#include "experiments/config/config.hpp"

#include <fmt/ranges.h>
#include <xxhash.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "experiments/config/block.hpp"

namespace cvr::experiments {

namespace {

Shape<std::vector<unsigned>> levels() {
  const auto all = list_of(whole_number(0, 31), "levels, or all");
  return {[read = all.read](const YamlValue& value) {
            std::vector<unsigned> lods;
            if (value.is_scalar() && value.text() == "all") return lods;
            for (const std::uint64_t one : read(value)) lods.push_back(static_cast<unsigned>(one));
            return lods;
          },
          "all, or a list of levels", schema_of_either(R"({"const": "all"})", all.schema)};
}

void apply_setting(const std::string& setting, Config& config) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos)
    throw InputError(fmt::format("--set {}: expected key=value, found no '='", setting));
  const std::string name = setting.substr(0, equals);
  const auto keys = simple_keys();
  const auto found =
      std::ranges::find(keys, name, [](const Key<Config>& one) { return one.info.name; });
  if (found == keys.end()) {
    std::vector<std::string> names;
    for (const auto& one : keys) names.push_back(one.info.name);
    throw InputError(fmt::format("--set {}: expected one of the keys {}, found '{}'{}", setting,
                                 fmt::join(names, ", "), name, did_you_mean(name, names)));
  }
  found->read(YamlValue::from_text(setting.substr(equals + 1), "--set " + name), config);
}

/// Tables and claims are found by their names.
void require_names_once(const YamlValue& root, const Config& config) {
  std::set<std::string> tables, claims;
  for (const TableSpec& table : config.tables) {
    if (!tables.insert(table.name).second)
      root.reject(fmt::format("expected tables of different names, found '{}' twice", table.name));
  }
  for (const ClaimSpec& claim : config.claims) {
    if (!claims.insert(claim.name).second)
      root.reject(fmt::format("expected claims of different names, found '{}' twice", claim.name));
  }
}

std::string hash_config(const std::string& path, const std::vector<std::string>& settings) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  for (const std::string& setting : settings) text << '\n' << setting;
  const std::string all = text.str();
  return fmt::format("{:016x}", XXH3_64bits(all.data(), all.size()));
}

}  // namespace

std::vector<Key<Config>> simple_keys() {
  using C = Config;
  return {
      key("title", &C::title, one_text("a title"), "",
          "Stands above the tables and in the report."),
      key("scale", &C::scale, real_number(1e-4, 1), "the data sets' own",
          "Side lengths of all generated volumes over those that are described."),
      key("rounds", &C::rounds, whole_number(1, 100000), "9", "Least number of rounds."),
      key("max_rounds", &C::max_rounds, whole_number(1, 1000000), "3 x rounds",
          "Largest number of rounds."),
      key("target_interval", &C::target_interval, real_number(1e-6, 1e6), "0.05",
          "Width of the 95 % interval of the median over the median at which a cell is done."),
      key("timeout_s", &C::timeout_s, real_number(0.01, 1e7), "120",
          "Seconds of a cell: for its check, and for all its rounds; a single step that takes "
          "longer is killed."),
      key("together", &C::together, whole_number(1, 1000000), "as many as the memory holds",
          "Most cells whose rounds are interleaved. 1: each cell alone, and its row is there "
          "before "
          "the next begins."),
      key("memory_limit_gib", &C::memory_limit_gib, real_number(0.001, 1e6), "16",
          "GiB that a worker process may allocate beyond the mapped input."),
      key("seed", &C::seed, whole_number(0, UINT64_MAX), "1",
          "Of the order of the rounds and of the points of random access."),
      key("device", &C::device, one_text("an index, a name or a type"), "the renderer's choice",
          "The device that draws: an index, or a part of a name or type (`cvrbench list "
          "devices`)."),
      key("lods", &C::lods, levels(), "all", "Levels of detail of random access."),
  };
}

std::vector<Key<ConfigDraft>> config_keys(const std::string& path, const Catalogue& catalogue,
                                          const Vocabulary& vocabulary) {
  using D = ConfigDraft;
  std::vector<Key<D>> keys;
  for (const Key<Config>& simple : simple_keys()) {
    keys.push_back({simple.info, [read = simple.read](const YamlValue& value, D& draft) {
                      read(value, draft.config);
                    }});
  }
  const BlockContext context{catalogue, vocabulary.stages, path};
  const MetricNames metrics = vocabulary.metrics;
  const auto list = [](auto read_one, const std::vector<KeyInfo>& one, const std::string& what) {
    using T = decltype(read_one(std::declval<const YamlValue&>()));
    return list_of(Shape<T>{read_one, "a map", schema_of_map(one)}, what);
  };
  keys.push_back(required(key("matrix", &D::blocks,
                              list([context](const YamlValue& v) { return read_block(v, context); },
                                   infos_of(block_keys(context)), "blocks"),
                              "", "The cells are the union of the products of these blocks.")));
  keys.push_back(key<D>(
      "tables",
      list([=](const YamlValue& v) { return read_table(v, path, metrics); },
           infos_of(table_keys(path, metrics)), "tables"),
      [](D& d, std::vector<TableSpec> tables) { d.config.tables = std::move(tables); }, "",
      "Tables that are made of the rows."));
  keys.push_back(key<D>(
      "claims",
      list([=](const YamlValue& v) { return read_claim(v, path, metrics); },
           infos_of(claim_keys(path, metrics)), "claims"),
      [](D& d, std::vector<ClaimSpec> claims) { d.config.claims = std::move(claims); }, "",
      "What papers say of these cells, each to be confirmed or refuted."));
  return keys;
}

Config read_config(const std::string& path, const Catalogue& catalogue,
                   const std::vector<std::string>& settings, const Vocabulary& vocabulary) {
  ConfigDraft draft;
  const YamlValue root = YamlValue::from_file(path);
  read_keys(root, config_keys(path, catalogue, vocabulary), draft);
  Config config = std::move(draft.config);
  config.path = path;
  require_names_once(root, config);
  std::set<std::string> set_keys;
  for (const std::string& setting : settings) {
    if (!set_keys.insert(setting.substr(0, setting.find('='))).second)
      throw InputError(fmt::format("--set {}: expected each key once", setting));
    apply_setting(setting, config);
  }
  if (config.max_rounds == 0) config.max_rounds = 3 * config.rounds;
  if (config.max_rounds < config.rounds) {
    root.reject(
        fmt::format("expected max_rounds of at least rounds ({}), found {}: raise max_rounds, or "
                    "leave it out for three times rounds",
                    config.rounds, config.max_rounds));
  }
  config.hash = hash_config(path, settings);
  config.cells = cells_of(draft.blocks, config.scale, config.device, path);
  return config;
}

void choose_device(Config& config, const std::string& device) {
  config.device = device;
  for (Cell& cell : config.cells) {
    if (cell.render) cell.render->device = device;
  }
}

}  // namespace cvr::experiments
