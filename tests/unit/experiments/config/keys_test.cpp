// What is made of the tables of keys: the schema of configurations as it is committed, the page of
// docs, and that rows name the options of the stage render as the schema of rows does.
#include "experiments/config/keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "experiments/config/key_documents.hpp"
#include "experiments/config/render_options.hpp"
#include "experiments/results/rows.hpp"
#include "experiments/run/load_config.hpp"

namespace cvr::experiments {
namespace {

using testing::HasSubstr;

std::string read(const std::string& name) {
  std::ifstream in(std::string(CVR_SOURCE_DIR) + "/" + name);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

struct Thing {
  std::uint32_t count = 3;
  std::string name;
  std::vector<double> sizes;
  bool flag = false;
};

std::vector<Key<Thing>> thing_keys() {
  return {
      required(key("name", &Thing::name, one_text("a name"), "", "Its name.")),
      key("count", &Thing::count, whole_number(1, 9), "3", "How many."),
      key("sizes", &Thing::sizes, one_or_list(real_number(0, 1), "sizes"), "", "How large."),
      key("flag", &Thing::flag, yes_or_no(), "false", ""),
  };
}

Thing read_thing(const std::string& text) {
  Thing thing;
  read_keys(YamlValue::from_text(text, "t"), thing_keys(), thing);
  return thing;
}

std::string error_of(const std::string& text) {
  try {
    read_thing(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Keys, AreReadIntoTheirMembers) {
  const Thing thing = read_thing("{name: a, count: 7, sizes: 0.5, flag: 1}");
  EXPECT_EQ(thing.name, "a");
  EXPECT_EQ(thing.count, 7u);
  EXPECT_EQ(thing.sizes, (std::vector<double>{0.5}));
  EXPECT_TRUE(thing.flag);
  EXPECT_EQ(read_thing("{name: a}").count, 3u);
  EXPECT_EQ(read_thing("{name: a, sizes: [0, 1]}").sizes.size(), 2u);
}

TEST(Keys, MistakesHaveTheirPlace) {
  EXPECT_EQ(error_of("{count: 1}"), "t:1:1: expected the key 'name', found none");
  EXPECT_EQ(error_of("{name: a, count: 10}"), "t:1:18: expected an integer in 1..9, found '10'");
  EXPECT_THAT(error_of("{name: a, cuont: 1}"), HasSubstr("did you mean 'count'?"));
  EXPECT_EQ(error_of("{name: a, flag: maybe}"), "t:1:17: expected true or false, found 'maybe'");
}

TEST(Keys, TellTheirSchema) {
  const Row schema = Row::parse(schema_of_map(infos_of(thing_keys())));
  EXPECT_EQ(schema["required"], Row({"name"}));
  EXPECT_EQ(schema["properties"]["count"]["maximum"], 9);
  EXPECT_EQ(schema["properties"]["count"]["description"], "How many.");
  EXPECT_EQ(schema["properties"]["sizes"]["anyOf"][1]["items"]["type"], "number");
  EXPECT_EQ(schema["additionalProperties"], false);
}

TEST(Keys, TheSchemaOfConfigurationsIsTheCommittedOne) {
  EXPECT_EQ(configuration_schema(vocabulary()), read("results/schema/config.schema.json"))
      << "cvrbench list config --json > results/schema/config.schema.json";
}

TEST(Keys, ThePageOfConfigurationsIsTheCommittedOne) {
  EXPECT_EQ(configuration_page(vocabulary()), read("docs/config.md"))
      << "cvrbench list config > docs/config.md";
}

TEST(Keys, EveryKeyOfTheStageRenderIsUsedOnceAndEveryAxisHasItsPlace) {
  std::set<std::string> keys, names;
  std::set<unsigned> axes;
  for (const RenderOption& option : render_options()) {
    EXPECT_TRUE(names.insert(option.name).second) << option.name;
    EXPECT_TRUE(option.key.name.empty() || keys.insert(option.key.name).second) << option.name;
    EXPECT_TRUE(option.axis == 0 || axes.insert(option.axis).second) << option.name;
  }
}

TEST(Keys, RowsNameTheOptionsOfTheStageRenderAsTheirSchemaDoes) {
  const Row schema = Row::parse(read("results/schema/row.schema.json"));
  std::set<std::string> described, options;
  for (const auto& [name, unused] : schema["properties"]["render"]["properties"].items())
    described.insert(name);
  for (const RenderOption& option : render_options()) {
    if (option.name != "scene_path") options.insert(option.name);  // of this machine alone
  }
  EXPECT_EQ(options, described);
}

TEST(Keys, StagesAreThoseOfTheSchemaOfRows) {
  const Row schema = Row::parse(read("results/schema/row.schema.json"));
  std::set<std::string> described, stages;
  for (const Row& id : schema["properties"]["stage"]["enum"]) described.insert(id);
  for (const StageTraits* stage : vocabulary().stages) stages.emplace(stage->id);
  EXPECT_EQ(stages, described);
}

}  // namespace
}  // namespace cvr::experiments
