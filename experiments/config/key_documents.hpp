// docs/config.md and results/schema/config.schema.json, made from the tables of keys.
#pragma once

#include <string>

#include "experiments/config/vocabulary.hpp"

namespace cvr::experiments {

/// A Markdown page of all keys: of configurations, data sets, scenes and published figures.
std::string configuration_page(const Vocabulary& vocabulary);
/// The JSON schema (draft 2020-12) of configurations.
std::string configuration_schema(const Vocabulary& vocabulary);

}  // namespace cvr::experiments
