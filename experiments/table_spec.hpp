// Reads the tables of a configuration.
#pragma once

#include <string>

#include "experiments/config.hpp"
#include "experiments/yaml_reader.hpp"

namespace cvr::experiments {

/// `config_path`: what the path of published figures is relative to. Throws InputError.
TableSpec read_table(const YamlValue& value, const std::string& config_path);

}  // namespace cvr::experiments
