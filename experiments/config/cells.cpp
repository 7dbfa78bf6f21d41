#include "experiments/config/cells.hpp"

#include <fmt/format.h>
#include <fnmatch.h>
#include <xxhash.h>

#include <map>

#include "codecs/registry.hpp"

namespace cvr::experiments {

std::string Cell::line_key() const {
  const volumes::Extent extent = dataset->generator ? dataset->generated_extent() : dataset->extent;
  const std::string axes = dataset->axes.empty() ? "" : " axes=" + dataset->axes;
  const std::string line = fmt::format("{}{}|{}|{}|{}|{}", dataset->name, axes, to_string(extent),
                                       codec, parameters.canonical(), threads.text);
  return render ? fmt::format("{}|{}", line, render->key()) : line;
}

std::string Cell::row_key() const { return fmt::format("{}|{}", line_key(), stage->id); }

std::string Cell::changes() const {
  const codecs::Codec* known = codecs::find_codec(codec);
  return known == nullptr ? parameters.canonical() : parameters.changes(known->parameters());
}

std::string Cell::describe() const {
  const std::string values = changes();
  if (render)
    return fmt::format("{} {}{}{} render, {}", dataset->name, codec, values.empty() ? "" : " ",
                       values, render->describe());
  return fmt::format("{} {}{}{} {}, {} thread{}", dataset->name, codec, values.empty() ? "" : " ",
                     values, stage->id, threads.count, threads.count == 1 ? "" : "s");
}

std::string canonical_text(const Cell& cell, const std::string& data_identity) {
  std::string text = fmt::format(
      "measurement={}\ndataset={}\ndata={}\nbytes_per_voxel={}\ncodec={}\nversion={}\nparameters={}"
      "\nstage={}"
      "\nthreads={}\n",
      cell.stage->version, cell.dataset->name, data_identity, cell.dataset->bytes_per_voxel,
      cell.codec, cell.codec_version, cell.parameters.canonical(), cell.stage->id,
      cell.threads.count);
  if (cell.render) text += fmt::format("render={}\n", cell.render->identity());
  return text;
}

std::string cell_id(const Cell& cell, const std::string& data_identity) {
  const std::string text = canonical_text(cell, data_identity);
  return fmt::format("{:016x}", XXH3_64bits(text.data(), text.size()));
}

std::string label_of(const Cell& cell, const std::string& key) {
  if (key == "dataset") return cell.dataset->name;
  if (key == "kind") return std::string(name_of(cell.dataset->kind));
  if (key == "codec") return cell.codec;
  if (key == "extent")
    return to_string(cell.dataset->generator ? cell.dataset->generated_extent()
                                             : cell.dataset->extent);
  if (key == "type") return std::string(name_of(cell.dataset->type));
  if (key == "threads")
    return cell.threads.text == "all" ? fmt::format("all ({})", cell.threads.count)
                                      : cell.threads.text;
  if (key == "parameters") return cell.changes();
  if (const auto label = cell.render ? cell.render->label(key) : std::nullopt; label) return *label;
  const auto found = cell.parameters.values().find(key);
  return found == cell.parameters.values().end() ? "" : found->second;
}

bool Filter::keeps(const Cell& cell) const {
  std::map<std::string, bool> kept;
  for (const auto& [key, glob] : only) {
    const std::string value = key == "key"       ? cell.row_key()
                              : key == "stage"   ? std::string(cell.stage->id)
                              : key == "threads" ? std::to_string(cell.threads.count)
                                                 : label_of(cell, key);
    kept[key] = kept[key] || fnmatch(glob.c_str(), value.c_str(), 0) == 0;
  }
  for (const auto& [key, any] : kept) {
    if (!any) return false;
  }
  return true;
}

}  // namespace cvr::experiments
