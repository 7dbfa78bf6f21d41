// The keys of data sets: of a description in a catalogue (configs/datasets), and of one in the
// matrix of a configuration, which chooses a described data set, names a file or generates its own.
#pragma once

#include <string>
#include <vector>

#include "experiments/config/datasets.hpp"
#include "experiments/config/keys.hpp"

namespace cvr::experiments {

/// A description as it is read: what belongs to the data set, and what is only known as a whole.
struct DescriptionDraft {
  Dataset dataset;
  GeneratorChoice generator;  ///< of the keys generator, seed, parameters
  std::optional<GeneratorChoice> stand_in;
};
/// `catalogue_path`: what paths of volumes are relative to.
std::vector<Key<DescriptionDraft>> description_keys(const std::string& catalogue_path);
/// Reads one description of a catalogue. Throws InputError.
Dataset read_description(const std::string& name, const YamlValue& value,
                         const std::string& catalogue_path);

/// A described data set with what a configuration changes of it.
struct ChoiceDraft {
  Dataset dataset;
  std::optional<double> scale;
  std::optional<volumes::Extent> extent;
  std::optional<std::string> axes;
  std::optional<bool> allow_external;
  std::uint32_t bytes_per_voxel = 0;
  bool exchange_axes = false;
};
std::vector<Key<ChoiceDraft>> choice_keys(const Catalogue& catalogue);

/// A volume file without a description: it says itself what it holds.
struct FileDraft {
  Dataset dataset;
  std::optional<volumes::VolumeKind> kind;
};
/// `config_path`: what paths of volumes are relative to.
std::vector<Key<FileDraft>> file_keys(const std::string& config_path);

/// A volume that only this configuration describes.
struct GeneratedDraft {
  Dataset dataset;
  GeneratorChoice generator;
};
std::vector<Key<GeneratedDraft>> generated_keys();

/// An entry of `datasets` in a configuration: the name of a described one, or a map of choice_keys,
/// file_keys or generated_keys. Files are opened for what they hold. `catalogue` outlives the shape.
Shape<Dataset> dataset_shape(const Catalogue& catalogue, const std::string& config_path);

}  // namespace cvr::experiments
