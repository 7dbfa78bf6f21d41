// --set KEY=VALUE of the command line: values that are put into a configuration before it is read.
#pragma once

#include <span>
#include <string>

#include "experiments/config/yaml_reader.hpp"

namespace cvr::experiments {

/// The key of "key=value". Throws InputError where there is no '='.
std::string key_of_setting(const std::string& setting);

/// Puts a value into a document, at a path of keys and places of lists (from 0) with dots between
/// them; '*' stands for all elements of a list or map: "matrix.*.size", "matrix.0.codecs.*.id". The
/// last key may be new, those before it may not. The value is YAML; commas without brackets make a
/// list of it. What an alias of the document stands for changes wherever it stands. Throws
/// InputError.
void put_setting(const YamlValue& root, const std::string& setting);

/// A key of blocks by itself: puts the value into each block of `matrix` that `takes` it. There it
/// holds for all of the block, so what entries of its `codecs` and `per_dataset` have under the key
/// goes. False where no block takes it.
bool put_block_setting(const YamlValue& root, const std::string& setting,
                       const std::function<bool(const YamlValue& block)>& takes);

}  // namespace cvr::experiments
