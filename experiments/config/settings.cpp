#include "experiments/config/settings.hpp"

#include <fmt/format.h>

#include "volumes/number_text.hpp"

namespace cvr::experiments {

namespace {

constexpr std::string_view kAll = "*";

YamlValue value_of(const std::string& setting) {
  const std::string name = "--set " + key_of_setting(setting);
  const std::string text = setting.substr(setting.find('=') + 1);
  const bool is_words = text.find(',') != std::string::npos && !text.empty() &&
                        std::string_view("[{\"'").find(text.front()) == std::string_view::npos;
  return YamlValue::from_text(is_words ? "[" + text + "]" : text, name).without_places();
}

std::vector<std::string> path_of(const std::string& setting) {
  const std::string key = key_of_setting(setting);
  std::vector<std::string> path;
  for (std::size_t begin = 0; begin <= key.size();) {
    const std::size_t end = std::min(key.find('.', begin), key.size());
    path.push_back(key.substr(begin, end - begin));
    begin = end + 1;
  }
  return path;
}

class Walk {
 public:
  explicit Walk(const std::string& setting)
      : setting_(setting), path_(path_of(setting)), value_(value_of(setting)) {}

  void put(const YamlValue& at, std::size_t depth = 0) const {
    const std::string& step = path_[depth];
    if (at.is_list()) {
      const auto elements = at.list("elements");
      if (step == kAll) {
        for (const YamlValue& element : elements) put_at(element, depth);
        return;
      }
      const auto place = volumes::parse_unsigned(step);
      if (!place || *place >= elements.size())
        refuse(at, fmt::format("a place of the list, 0..{}, or *", elements.size() - 1), step);
      put_at(elements[*place], depth);
    } else if (at.is_map()) {
      if (step == kAll) {
        for (const auto& [name, element] : at.entries()) put_at(element, depth);
        return;
      }
      const auto element = at.find(step);
      const bool is_last = depth + 1 == path_.size();
      if (element)
        put_at(*element, depth);
      else if (is_last)
        at.put(step, value_);
      else
        refuse(at, "a key that is there", step);
    } else {
      refuse(at, "a list or a map to go on in", step);
    }
  }

 private:
  void put_at(const YamlValue& element, std::size_t depth) const {
    if (depth + 1 == path_.size())
      element.become(value_);
    else
      put(element, depth + 1);
  }
  [[noreturn]] void refuse(const YamlValue& at, const std::string& what,
                           const std::string& step) const {
    throw InputError(
        fmt::format("--set {}: at {}: expected {}, found '{}'", setting_, at.place(), what, step));
  }

  const std::string& setting_;
  std::vector<std::string> path_;
  YamlValue value_;
};

}  // namespace

std::string key_of_setting(const std::string& setting) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos)
    throw InputError(fmt::format("--set {}: expected key=value, found no '='", setting));
  return setting.substr(0, equals);
}

void put_setting(const YamlValue& root, const std::string& setting) { Walk(setting).put(root); }

bool put_block_setting(const YamlValue& root, const std::string& setting,
                       const std::function<bool(const YamlValue& block)>& takes) {
  const std::string key = key_of_setting(setting);
  const YamlValue value = value_of(setting);
  bool taken = false;
  for (const YamlValue& block : root.find("matrix")->list("blocks")) {
    if (!takes(block)) continue;
    taken = true;
    block.put(key, value);
    if (const auto codecs = block.find("codecs"); codecs && codecs->is_list()) {
      for (const YamlValue& codec : codecs->list("codecs")) {
        if (codec.is_map()) codec.remove(key);
      }
    }
    if (const auto datasets = block.find("per_dataset")) {
      for (const auto& [name, own] : datasets->entries()) own.remove(key);
    }
  }
  return taken;
}

}  // namespace cvr::experiments
