// Keys that data sets have in catalogues and in configurations.
#pragma once

#include <string>

#include "experiments/config/yaml_reader.hpp"

namespace cvr::experiments {

/// Axes as are_axes takes them. Throws InputError.
std::string read_axes(const YamlValue& value);

/// true or false, also as 1 or 0. Throws InputError.
bool read_yes_no(const YamlValue& value);

}  // namespace cvr::experiments
