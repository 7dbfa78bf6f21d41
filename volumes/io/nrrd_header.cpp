// The line-by-line parser and the writer of NRRD headers; nrrd.hpp says what is understood.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <vector>

#include "volumes/io/nrrd.hpp"

namespace cvr::volumes {

namespace {

constexpr std::size_t kMaximumHeader = 1 << 20;

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t at = text.find_first_not_of(" \t"); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(" \t", at), text.size());
    words.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(" \t", end);
  }
  return words;
}

/// The texts between quotation marks.
std::vector<std::string> quoted_of(std::string_view text) {
  std::vector<std::string> texts;
  for (std::size_t open = text.find('"'); open != std::string_view::npos;) {
    const std::size_t close = text.find('"', open + 1);
    if (close == std::string_view::npos) break;
    texts.emplace_back(trimmed(text.substr(open + 1, close - open - 1)));
    open = text.find('"', close + 1);
  }
  return texts;
}

/// Values of key/value pairs: a backslash escapes itself and line ends.
std::string unescaped(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool escape = text[i] == '\\' && i + 1 < text.size() && (text[i + 1] == 'n' || text[i + 1] == '\\');
    if (escape) ++i;
    result += escape && text[i] == 'n' ? '\n' : text[i];
  }
  return result;
}

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) result += c == '\n' ? "\\n" : c == '\\' ? "\\\\" : std::string(1, c);
  return result;
}

std::optional<StoredType> stored_type(const std::string& name) {
  struct Names {
    StoredType type;
    std::vector<std::string_view> names;
  };
  static const std::vector<Names> kNames{
      {{VoxelType::kU8, true}, {"signed char", "int8", "int8_t"}},
      {{VoxelType::kU8, false}, {"uchar", "unsigned char", "uint8", "uint8_t"}},
      {{VoxelType::kI16, true},
       {"short", "short int", "signed short", "signed short int", "int16", "int16_t"}},
      {{VoxelType::kU16, false}, {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"}},
      {{VoxelType::kU32, true}, {"int", "signed int", "int32", "int32_t"}},
      {{VoxelType::kU32, false}, {"uint", "unsigned int", "uint32", "uint32_t"}},
      {{VoxelType::kU64, true},
       {"longlong", "long long", "long long int", "signed long long", "signed long long int", "int64",
        "int64_t"}},
      {{VoxelType::kU64, false},
       {"ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"}},
      {{VoxelType::kF32, false}, {"float"}},
  };
  for (const Names& entry : kNames) {
    if (std::find(entry.names.begin(), entry.names.end(), name) != entry.names.end()) return entry.type;
  }
  return std::nullopt;
}

class HeaderParser {
 public:
  HeaderParser(const std::string& file, std::string_view text) : file_(file), text_(text) {}

  NrrdHeader parse() {
    magic();
    while (next_line()) {
      if (line_.empty()) break;
      if (line_.front() == '#') continue;
      const std::size_t colon = line_.find(':');
      if (colon == std::string_view::npos) fail("'field: description', 'key:=value' or a comment", line_);
      if (colon + 1 < line_.size() && line_[colon + 1] == '=') {
        key(line_.substr(0, colon), line_.substr(colon + 2));
      } else {
        field(lower(trimmed(line_.substr(0, colon))), trimmed(line_.substr(colon + 1)));
      }
    }
    header_.data_offset = at_;
    finish();
    return header_;
  }

 private:
  [[noreturn]] void fail(std::string_view expected, std::string_view found) const {
    throw_input_error(file_, fmt::format("line {}", number_), expected,
                      fmt::format("'{}'", found.substr(0, 200)));
  }

  bool next_line() {
    if (at_ >= text_.size()) return false;
    ++number_;
    const std::size_t end = text_.substr(0, kMaximumHeader).find('\n', at_);
    if (end == std::string_view::npos && text_.size() > kMaximumHeader) {
      throw_input_error(file_, fmt::format("line {}", number_), "a header of at most 1 MiB", "a longer one");
    }
    line_ = text_.substr(at_, end == std::string_view::npos ? std::string_view::npos : end - at_);
    if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
    at_ = end == std::string_view::npos ? text_.size() : end + 1;
    return true;
  }

  void magic() {
    number_ = 1;
    if (!text_.starts_with("NRRD000")) {
      const std::string_view start = text_.substr(0, 8);
      const bool printable =
          std::all_of(start.begin(), start.end(), [](char c) { return c >= ' ' && c <= '~'; });
      fail("the magic NRRD0001 to NRRD0005", printable ? start : "other bytes");
    }
    number_ = 0;
    next_line();
    const bool known = line_.size() == 8 && line_[7] >= '1' && line_[7] <= '5';
    if (!known) fail("the magic NRRD0001 to NRRD0005", line_);
  }

  template <class T>
  T number(std::string_view text, std::string_view expected) const {
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) fail(expected, text);
    return value;
  }

  void field(const std::string& name, std::string_view value) {
    using Handler = void (HeaderParser::*)(std::string_view);
    static const std::map<std::string, Handler> kHandlers{
        {"dimension", &HeaderParser::dimension},
        {"type", &HeaderParser::type},
        {"sizes", &HeaderParser::sizes},
        {"encoding", &HeaderParser::encoding},
        {"endian", &HeaderParser::endian},
        {"data file", &HeaderParser::data_file},
        {"datafile", &HeaderParser::data_file},
        {"line skip", &HeaderParser::line_skip},
        {"lineskip", &HeaderParser::line_skip},
        {"byte skip", &HeaderParser::byte_skip},
        {"byteskip", &HeaderParser::byte_skip},
        {"spacings", &HeaderParser::spacings},
        {"space directions", &HeaderParser::space_directions},
        {"units", &HeaderParser::units},
        {"space units", &HeaderParser::space_units},
        {"kinds", &HeaderParser::kinds},
        {"space dimension", &HeaderParser::space_dimension},
    };
    static const std::vector<std::string_view> kDescriptive{
        "content",           "number",       "min",        "max",        "old min",     "oldmin",
        "old max",           "oldmax",       "centers",    "centerings", "thicknesses", "axis mins",
        "axismins",          "axis maxs",    "axismaxs",   "labels",     "space",       "space origin",
        "measurement frame", "sample units", "sampleunits"};
    if (const auto handler = kHandlers.find(name); handler != kHandlers.end()) {
      if (!seen_.emplace(name, number_).second) fail("each field once", name);
      (this->*handler->second)(value);
    } else if (std::find(kDescriptive.begin(), kDescriptive.end(), name) == kDescriptive.end()) {
      fail("a field that this reader knows", name);
    }
  }

  void key(std::string_view name, std::string_view value) {
    const std::string text = unescaped(value);
    if (name == "kind") {
      header_.kind = volume_kind_from_name(text);
      if (!header_.kind) fail("kind:=labels or kind:=scalars", value);
    }
    if (name == "name") header_.provenance.name = text;
    if (name == "source") header_.provenance.source = text;
    if (name == "licence") header_.provenance.licence = text;
  }

  void dimension(std::string_view value) {
    if (value != "3" && value != "4") fail("dimension 3, or 4 for a series", value);
    axes_ = value == "3" ? 3 : 4;
  }
  void space_dimension(std::string_view value) {
    if (value != "3") fail("space dimension 3", value);
  }

  void type(std::string_view value) {
    const auto type = stored_type(lower(value));
    if (!type) fail("an integer type or float", value);
    header_.type = *type;
  }

  std::vector<std::string_view> words_of_axes(std::string_view value) const {
    auto words = words_of(value);
    if (words.size() != axes_) fail(fmt::format("{} values, one an axis, after the field 'dimension'", axes_), value);
    return words;
  }

  void sizes(std::string_view value) {
    const auto words = words_of_axes(value);
    for (std::size_t axis = 0; axis < 3; ++axis)
      header_.size[axis] = number<std::uint64_t>(words[axis], "a size");
    if (axes_ == 4) header_.steps = number<std::uint64_t>(words[3], "a number of steps");
    if (axes_ == 4 && header_.steps == 0) fail("at least one step", value);
  }

  void encoding(std::string_view value) {
    const std::string name = lower(value);
    if (name == "raw") {
      header_.encoding = NrrdEncoding::kRaw;
    } else if (name == "gz" || name == "gzip") {
      header_.encoding = NrrdEncoding::kGzip;
    } else {
      fail("encoding raw or gzip", value);
    }
  }

  void endian(std::string_view value) {
    const std::string name = lower(value);
    if (name != "little" && name != "big") fail("endian little or big", value);
    header_.big_endian = name == "big";
  }

  void data_file(std::string_view value) {
    const bool several = value.starts_with("LIST") || value.find('%') != std::string_view::npos;
    if (value.empty() || several) fail("the name of one data file", value);
    header_.data_file = value;
  }

  void line_skip(std::string_view value) {
    header_.line_skip = number<std::uint64_t>(value, "a number of lines");
  }

  void byte_skip(std::string_view value) {
    header_.byte_skip = number<std::int64_t>(value, "a number of bytes, or -1");
    if (header_.byte_skip < -1) fail("a number of bytes, or -1", value);
  }

  /// A voxel size; NaN and 0 mean that it is unknown, a sign only turns the axis round.
  double spacing(double value, std::string_view text) const {
    if (std::isinf(value)) fail("a finite spacing", text);
    return std::isnan(value) || value == 0 ? 1 : std::fabs(value);
  }

  void spacings(std::string_view value) {
    const auto words = words_of_axes(value);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      header_.voxel_size[axis] = spacing(number<double>(words[axis], "a spacing"), words[axis]);
    }
  }

  void space_directions(std::string_view value) {
    std::size_t at = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t open = value.find('(', at);
      const std::size_t close = value.find(')', at);
      if (open == std::string_view::npos || close == std::string_view::npos || close < open ||
          !trimmed(value.substr(at, open - at)).empty()) {
        fail("three vectors (a,b,c)", value);
      }
      std::string inner(value.substr(open + 1, close - open - 1));
      std::replace(inner.begin(), inner.end(), ',', ' ');
      const auto parts = words_of(inner);
      if (parts.size() != 3) fail("three vectors (a,b,c)", value);
      const std::array<double, 3> v{number<double>(parts[0], "a number"),
                                    number<double>(parts[1], "a number"),
                                    number<double>(parts[2], "a number")};
      header_.voxel_size[axis] = spacing(std::hypot(v[0], v[1], v[2]), value);
      at = close + 1;
    }
    const std::string_view time = axes_ == 4 ? "none" : "";
    if (lower(trimmed(value.substr(at))) != time) {
      fail(axes_ == 4 ? "three vectors (a,b,c) and none for the time" : "three vectors (a,b,c)", value);
    }
  }

  /// One an axis; that of the time is not read.
  void units(std::string_view value) {
    const auto texts = quoted_of(value);
    if (texts.size() != axes_) fail(fmt::format("{} units in quotation marks", axes_), value);
    set_unit(texts, value);
  }
  void space_units(std::string_view value) {
    const auto texts = quoted_of(value);
    if (texts.size() != 3) fail("three units in quotation marks", value);
    set_unit(texts, value);
  }
  void set_unit(const std::vector<std::string>& texts, std::string_view value) {
    if (texts[0] != texts[1] || texts[1] != texts[2]) fail("the same unit on all axes", value);
    header_.voxel_unit = texts[0] == "???" ? "" : texts[0];
  }

  void kinds(std::string_view value) {
    const auto words = words_of_axes(value);
    for (std::size_t axis = 0; axis < words.size(); ++axis) {
      const std::string kind = lower(words[axis]);
      if (kind == "none" || kind == "???") continue;
      if (axis < 3 && kind != "domain" && kind != "space") fail("kinds domain or space", words[axis]);
      if (axis == 3 && kind != "list" && kind != "time") fail("the kind list or time of the last axis", words[axis]);
    }
  }

  /// Errors about the header as a whole name its last line.
  void finish() const {
    for (const char* name : {"dimension", "type", "sizes", "encoding"}) {
      if (!seen_.contains(name))
        fail(fmt::format("the field '{}' before the end of the header", name), line_);
    }
    if (axes_ == 4 && !seen_.contains("kinds")) fail("the field 'kinds', which says that the last axis is a list", line_);
    if (size_of(header_.type.type) > 1 && !seen_.contains("endian")) fail("the field 'endian'", line_);
    if (header_.byte_skip < 0 && header_.encoding != NrrdEncoding::kRaw)
      fail("byte skip -1 only with raw", "gzip");
  }

  const std::string& file_;
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t number_ = 0;
  std::string_view line_;
  std::map<std::string, std::size_t> seen_;
  std::size_t axes_ = 3;
  NrrdHeader header_;
};

std::string_view type_name(VoxelType type) {
  switch (type) {
    case VoxelType::kU8:
      return "uint8";
    case VoxelType::kU16:
      return "uint16";
    case VoxelType::kU32:
      return "uint32";
    case VoxelType::kU64:
      return "uint64";
    case VoxelType::kI16:
      return "int16";
    case VoxelType::kF32:
      return "float";
  }
  return "?";
}

}  // namespace

NrrdHeader parse_nrrd_header(const std::string& file, std::string_view text) {
  return HeaderParser(file, text).parse();
}

std::string nrrd_header_text(const VolumeInfo& info, const Provenance& provenance, NrrdEncoding encoding,
                             const std::string& data_file) {
  // Time is the last axis of a series, without spacing and unit.
  const bool series = info.time_steps > 1;
  const Extent step = info.step_extent();
  std::string text =
      fmt::format("NRRD0004\ntype: {}\ndimension: {}\nsizes: {} {} {}{}\nspacings: {} {} {}{}\n", type_name(info.type),
                  series ? 4 : 3, step.x, step.y, step.z, series ? fmt::format(" {}", info.time_steps) : "",
                  info.voxel_size[0], info.voxel_size[1], info.voxel_size[2], series ? " nan" : "");
  if (!info.voxel_unit.empty())
    text += fmt::format("units: \"{0}\" \"{0}\" \"{0}\"{1}\n", info.voxel_unit, series ? " \"\"" : "");
  text += fmt::format("kinds: domain domain domain{}\nendian: little\nencoding: {}\n", series ? " list" : "",
                      encoding == NrrdEncoding::kRaw ? "raw" : "gzip");
  if (!data_file.empty()) text += fmt::format("data file: {}\n", data_file);
  text += fmt::format("kind:={}\n", name_of(info.kind));
  if (!provenance.name.empty()) text += fmt::format("name:={}\n", escaped(provenance.name));
  if (!provenance.source.empty()) text += fmt::format("source:={}\n", escaped(provenance.source));
  if (!provenance.licence.empty()) text += fmt::format("licence:={}\n", escaped(provenance.licence));
  if (data_file.empty()) text += "\n";
  return text;
}

}  // namespace cvr::volumes
