#include "experiments/config/config.hpp"

#include <fmt/ranges.h>
#include <xxhash.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "experiments/config/block.hpp"
#include "experiments/config/settings.hpp"

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

/// The one of the simple keys that a setting names; none where it is a path or a key of blocks.
std::optional<Key<Config>> simple_key_of(const std::string& setting) {
  const auto keys = simple_keys();
  const auto found = std::ranges::find(keys, key_of_setting(setting),
                                       [](const Key<Config>& one) { return one.info.name; });
  return found == keys.end() ? std::nullopt : std::optional(*found);
}

/// Whether a block draws images.
bool draws(const YamlValue& block, StageList stages) {
  const auto ids = block.find("stages");
  return ids && ids->is_list() &&
         std::ranges::any_of(ids->list("stages"), [&](const YamlValue& id) {
           const StageTraits* stage = id.is_scalar() ? find_stage(stages, id.text()) : nullptr;
           return stage != nullptr && stage->renders;
         });
}

/// Puts what is none of the simple keys into the document.
void put_in_document(const YamlValue& root, const std::string& setting,
                     const BlockContext& context) {
  const std::string name = key_of_setting(setting);
  if (name.find('.') != std::string::npos) return put_setting(root, setting);
  std::vector<std::string> names;
  for (const auto& one : simple_keys()) names.push_back(one.info.name);
  for (const auto& one : block_keys(context)) names.push_back(one.info.name);
  if (std::ranges::find(names, name) == names.end())
    throw InputError(
        fmt::format("--set {}: expected one of the keys {}, or a path such as "
                    "matrix.*.size, found '{}'{}",
                    setting, fmt::join(names, ", "), name, did_you_mean(name, names)));
  const bool of_images = std::ranges::any_of(
      render_options(), [&](const RenderOption& option) { return option.key.name == name; });
  const bool taken = put_block_setting(root, setting, [&](const YamlValue& block) {
    return !of_images || draws(block, context.stages);
  });
  if (!taken)
    throw InputError(fmt::format(
        "--set {}: expected a block with the stage render, which has this key, found none",
        setting));
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
      key("rounds_per_process", &C::rounds_per_process, whole_number(1, 1000000), "all",
          "Rounds of a cell that one worker process makes before another takes its place. 1: each "
          "round is a process of its own. Images are checked by the first process alone, volumes "
          "by "
          "each."),
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
  const YamlValue root = YamlValue::from_file(path);
  const auto keys = config_keys(path, catalogue, vocabulary);
  const auto read = [&] {
    ConfigDraft draft;
    read_keys(root, keys, draft);
    return draft;
  };
  ConfigDraft draft = read();
  std::set<std::string> set_keys;
  for (const std::string& setting : settings) {
    if (!set_keys.insert(key_of_setting(setting)).second)
      throw InputError(fmt::format("--set {}: expected each key once", setting));
    if (simple_key_of(setting)) continue;
    put_in_document(root, setting, {catalogue, vocabulary.stages, path});
    try {
      draft = read();
    } catch (const InputError& error) {
      throw InputError(fmt::format("--set {}: {}", setting, error.what()));
    }
  }
  Config config = std::move(draft.config);
  config.path = path;
  require_names_once(root, config);
  for (const std::string& setting : settings) {
    if (const auto simple = simple_key_of(setting)) {
      const std::string name = key_of_setting(setting);
      simple->read(YamlValue::from_text(setting.substr(name.size() + 1), "--set " + name), config);
    }
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
