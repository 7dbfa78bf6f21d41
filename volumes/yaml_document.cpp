#include "volumes/yaml_document.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <string_view>
#include <vector>

#include "volumes/error.hpp"
#include "volumes/plain_text.hpp"

namespace cvr::volumes {

namespace {

/// Goes through a document as it is parsed, before yaml-cpp makes nodes of it.
class Inspection final : public YAML::EventHandler {
 public:
  explicit Inspection(const std::string& document) : document_(document) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) refuse(mark, "one YAML document", "a second one: it would not be read");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { add_leaf(mark, anchor); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string&) override {
    check_tag(mark, tag);
    add_leaf(mark, anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = sizes_.find(anchor);
    if (found == sizes_.end())
      refuse(mark, "an alias of something that has ended", "one within what it names");
    add(mark, found->second);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    begin(mark, tag, anchor);
  }
  void OnSequenceEnd() override { end(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    begin(mark, tag, anchor);
  }
  void OnMapEnd() override { end(); }

 private:
  struct Open {
    YAML::anchor_t anchor;
    std::size_t nodes_before;
  };

  [[noreturn]] void refuse(const YAML::Mark& mark, std::string_view expected,
                           std::string_view found) const {
    throw InputError(
        fmt::format("{}: expected {}, found {}", yaml_place(document_, mark), expected, found));
  }

  void check_tag(const YAML::Mark& mark, const std::string& tag) const {
    if (!tag.empty() && tag != "?" && tag != "!")
      refuse(mark, "a value without a tag", fmt::format("the tag '{}'", printable(tag)));
  }

  void add(const YAML::Mark& mark, std::size_t nodes) {
    nodes_ += nodes;
    if (nodes_ > kMaxYamlNodes) {
      refuse(mark, fmt::format("at most {} values", kMaxYamlNodes),
             "more, counting what aliases stand for");
    }
  }

  void add_leaf(const YAML::Mark& mark, YAML::anchor_t anchor) {
    add(mark, 1);
    if (anchor != YAML::NullAnchor) sizes_[anchor] = 1;
  }

  void begin(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    check_tag(mark, tag);
    if (open_.size() >= kMaxYamlDepth)
      refuse(mark, fmt::format("at most {} levels of lists and maps", kMaxYamlDepth),
             "a deeper one");
    open_.push_back({anchor, nodes_});
    add(mark, 1);
  }

  void end() {
    if (open_.back().anchor != YAML::NullAnchor)
      sizes_[open_.back().anchor] = nodes_ - open_.back().nodes_before;
    open_.pop_back();
  }

  const std::string& document_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, std::size_t> sizes_;  ///< of what has an anchor and has ended
  std::size_t documents_ = 0, nodes_ = 0;
};

/// Control characters but tabs and line ends. YAML has escapes for them, which are judged where the
/// text is used.
void require_plain(const std::string& text, const std::string& document) {
  const auto is_control = [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte < 0x20 && c != '\n' && c != '\r' && c != '\t') || byte == 0x7F;
  };
  const auto at = std::ranges::find_if(text, is_control);
  if (at == text.end()) return;
  const auto line = std::count(text.begin(), at, '\n') + 1;
  throw InputError(
      fmt::format("{}:{}: expected text in UTF-8 without control characters, found '{}'", document,
                  line, printable(std::string_view(&*at, 1))));
}

}  // namespace

std::string yaml_place(const std::string& document, const YAML::Mark& mark) {
  if (mark.is_null()) return document;
  return fmt::format("{}:{}:{}", document, mark.line + 1, mark.column + 1);
}

YAML::Node load_yaml(const std::string& text, const std::string& document) {
  if (text.size() > kMaxYamlBytes) {
    throw InputError(fmt::format("{}: expected YAML of at most {} MiB, found {} bytes", document,
                                 kMaxYamlBytes >> 20, text.size()));
  }
  require_plain(text, document);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    Inspection inspection(document);
    while (parser.HandleNextDocument(inspection)) continue;
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}: expected YAML, found: {}", yaml_place(document, error.mark),
                                 printable(error.msg)));
  }
}

}  // namespace cvr::volumes
