// The strict reader of YAML under the names of this room; volumes/io/yaml.hpp has it.
#pragma once

#include "volumes/io/yaml.hpp"

namespace cvr::experiments {

using volumes::did_you_mean;
using volumes::InputError;
using volumes::YamlValue;

}  // namespace cvr::experiments
