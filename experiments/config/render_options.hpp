// The options of the stage render: each is described once, with its key in a block of the matrix,
// its name in rows and tables, its range, default and meaning. Cell keys, rows, the schemas and
// docs/config.md are made from this list.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "codecs/parameters.hpp"
#include "experiments/config/keys.hpp"
#include "experiments/config/render_choice.hpp"
#include "volumes/volume.hpp"

namespace cvr::experiments {

/// Puts a value into a choice.
using RenderSetter = std::function<void(RenderChoice&)>;
/// The values that a block gives an option, in their order; "all" depends on the kind of volume.
using RenderValues = std::function<std::vector<RenderSetter>(volumes::VolumeKind)>;

struct RenderOption {
  KeyInfo key;             ///< in a block of the matrix; without a name: no key sets it
  std::string name;        ///< in rows
  std::string label;       ///< in tables, filters and conditions; empty: it is none
  bool is_needed = false;  ///< with the stage render the block must have the key
  unsigned axis = 0;       ///< above 0: several values multiply the cells, those of axis 1 slowest
  Row row_schema;          ///< JSON schema of the value in rows
  bool in_every_row = true;

  std::function<std::string(const RenderChoice&)> text;
  /// Its part of a cell's key; empty: none. Options that came later have none at their default, so
  /// that older keys stay what they were.
  std::function<std::string(const RenderChoice&)> in_cell_key;
  std::function<void(const RenderChoice&, Row&)> to_row;
  std::function<void(const Row&, RenderChoice&)> from_row;
  /// `folder`: where paths in the configuration begin.
  std::function<RenderValues(const YamlValue&, const std::string& folder)> read;
};

std::span<const RenderOption> render_options();

/// The JSON schema of the part `render` of a row.
Row render_schema();

/// The names that tables, filters and conditions know.
std::vector<std::string> render_labels();
bool is_render_label(std::string_view name);

/// What a block of the matrix says of the stage render.
class RenderBlock {
 public:
  void give(const RenderOption& option, RenderValues values) {
    given_.push_back({&option, std::move(values)});
  }
  /// The same, but for the options that `other` has.
  RenderBlock with(const RenderBlock& other) const;
  /// After all keys: with the render stage the required keys must be there, without it no key may
  /// be. Throws InputError.
  void check(const YamlValue& block, bool renders) const;
  /// The choices that the values multiply to. `parameters`: where the codec's own brick size stands,
  /// if it has one. `kind`: of the volume.
  std::vector<RenderChoice> choices(const codecs::Parameters& parameters, volumes::VolumeKind kind,
                                    const std::string& device) const;

 private:
  struct Given {
    const RenderOption* option;
    RenderValues values;
  };
  std::vector<Given> given_;
};

}  // namespace cvr::experiments
