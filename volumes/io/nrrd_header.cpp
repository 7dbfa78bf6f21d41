// The line-by-line parser of NRRD headers; nrrd.hpp says what is understood.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <vector>

#include "volumes/io/content.hpp"
#include "volumes/io/nrrd.hpp"

namespace cvr::volumes {

namespace {

constexpr std::size_t kMaximumHeader = 1 << 20;
constexpr std::size_t kMaximumDimension = 16;  // NRRD_DIM_MAX

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
    const bool escape =
        text[i] == '\\' && i + 1 < text.size() && (text[i + 1] == 'n' || text[i + 1] == '\\');
    if (escape) ++i;
    result += escape && text[i] == 'n' ? '\n' : text[i];
  }
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
      {{VoxelType::kU16, false},
       {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"}},
      {{VoxelType::kU32, true}, {"int", "signed int", "int32", "int32_t"}},
      {{VoxelType::kU32, false}, {"uint", "unsigned int", "uint32", "uint32_t"}},
      {{VoxelType::kU64, true},
       {"longlong", "long long", "long long int", "signed long long", "signed long long int",
        "int64", "int64_t"}},
      {{VoxelType::kU64, false},
       {"ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"}},
      {{VoxelType::kF32, false}, {"float"}},
      {{VoxelType::kU64, false, true}, {"double"}},
  };
  for (const Names& entry : kNames) {
    if (std::find(entry.names.begin(), entry.names.end(), name) != entry.names.end())
      return entry.type;
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
      if (colon == std::string_view::npos)
        fail("'field: description', 'key:=value' or a comment", line_);
      if (const std::size_t key_end = line_.find(":=");
          key_end != std::string_view::npos && key_end <= line_.find(": ")) {
        key(line_.substr(0, key_end), line_.substr(key_end + 2));
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
      throw_input_error(file_, fmt::format("line {}", number_), "a header of at most 1 MiB",
                        "a longer one");
    }
    line_ = text_.substr(at_, end == std::string_view::npos ? std::string_view::npos : end - at_);
    if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
    at_ = end == std::string_view::npos ? text_.size() : end + 1;
    return true;
  }

  void magic() {
    number_ = 1;
    if (!text_.starts_with("NRRD000")) {
      throw_input_error(file_, "line 1", "the magic NRRD0001 to NRRD0005 of an NRRD file",
                        describe_content(std::as_bytes(std::span(text_))));
    }
    number_ = 0;
    next_line();
    const bool known = line_.size() == 8 && line_[7] >= '1' && line_[7] <= '5';
    if (!known) fail("the magic NRRD0001 to NRRD0005", line_);
  }

  template <class T>
  T number(std::string_view text, std::string_view expected) const {
    T value{};
    const std::string_view digits = text.starts_with('+') ? text.substr(1) : text;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size()) fail(expected, text);
    return value;
  }

  void field(const std::string& written, std::string_view value) {
    using Handler = void (HeaderParser::*)(std::string_view);
    static const std::map<std::string, Handler> kHandlers{
        {"dimension", &HeaderParser::dimension},
        {"type", &HeaderParser::type},
        {"sizes", &HeaderParser::sizes},
        {"encoding", &HeaderParser::encoding},
        {"endian", &HeaderParser::endian},
        {"data file", &HeaderParser::data_file},
        {"line skip", &HeaderParser::line_skip},
        {"byte skip", &HeaderParser::byte_skip},
        {"spacings", &HeaderParser::spacings},
        {"space directions", &HeaderParser::space_directions},
        {"space origin", &HeaderParser::space_origin},
        {"units", &HeaderParser::units},
        {"space units", &HeaderParser::space_units},
        {"kinds", &HeaderParser::kinds},
        {"space", &HeaderParser::space},
        {"space dimension", &HeaderParser::space_dimension},
    };
    static const std::map<std::string_view, std::string_view> kAliases{
        {"datafile", "data file"},      {"lineskip", "line skip"}, {"byteskip", "byte skip"},
        {"oldmin", "old min"},          {"oldmax", "old max"},     {"centerings", "centers"},
        {"axismins", "axis mins"},      {"axismaxs", "axis maxs"}, {"blocksize", "block size"},
        {"sampleunits", "sample units"}};
    static constexpr std::array<std::string_view, 15> kDescriptive{
        "content",           "number",       "min",       "max",       "old min",   "old max",
        "centers",           "thicknesses",  "labels",    "axis mins", "axis maxs", "block size",
        "measurement frame", "sample units", "data order"};
    const auto alias = kAliases.find(written);
    const std::string name(alias == kAliases.end() ? written : alias->second);
    const auto handler = kHandlers.find(name);
    if (handler == kHandlers.end() && std::ranges::find(kDescriptive, name) == kDescriptive.end()) {
      // Keys may have colons.
      if (const std::size_t end = line_.find(":="); end != std::string_view::npos)
        return key(line_.substr(0, end), line_.substr(end + 2));
      fail("a field that this reader knows", written);
    }
    if (const auto [first, fresh] = header_.lines.emplace(name, number_); !fresh)
      fail(fmt::format("each field once ('{}' is in line {})", name, first->second), line_);
    if (handler != kHandlers.end()) (this->*handler->second)(value);
  }

  void key(std::string_view name, std::string_view value) {
    if (const auto [first, fresh] = keys_.emplace(name, number_); !fresh)
      fail(fmt::format("each key once ('{}' is in line {})", name, first->second), line_);
    const std::string text = unescaped(value);
    if (name == "kind")
      header_.kind = volume_kind_from_name(text);  // another program's key may have this name
    if (name == "name") header_.provenance.name = text;
    if (name == "source") header_.provenance.source = text;
    if (name == "licence") header_.provenance.licence = text;
  }

  void dimension(std::string_view value) {
    axes_ = number<std::size_t>(value, "a dimension of 1 to 16");
    if (axes_ < 1 || axes_ > kMaximumDimension) fail("a dimension of 1 to 16", value);
  }

  void space(std::string_view value) {
    static constexpr std::array<std::string_view, 4> kFour{"time", "rast", "last", "lpst"};
    const std::string name = lower(value);
    const bool with_time =
        std::ranges::any_of(kFour, [&](std::string_view end) { return name.ends_with(end); });
    set_space_dimension(with_time ? 4 : 3, value);
  }
  void space_dimension(std::string_view value) {
    const auto dimension = number<std::size_t>(value, "a space dimension of 1 to 16");
    if (dimension < 1 || dimension > kMaximumDimension) fail("a space dimension of 1 to 16", value);
    set_space_dimension(dimension, value);
  }
  void set_space_dimension(std::size_t dimension, std::string_view value) {
    if (header_.space_dimension.value_or(dimension) != dimension)
      fail(fmt::format("a space of dimension {}, as before", *header_.space_dimension), value);
    header_.space_dimension = dimension;
  }

  void type(std::string_view value) {
    const auto type = stored_type(lower(value));
    if (!type) fail("an integer type, float or double", value);
    header_.type = *type;
    header_.type_name = value;
  }

  std::vector<std::string_view> words_of_axes(std::string_view value) const {
    auto words = words_of(value);
    if (words.size() != axes_)
      fail(fmt::format("{} values, one per axis, after the field 'dimension'", axes_), value);
    return words;
  }

  void sizes(std::string_view value) {
    for (const std::string_view word : words_of_axes(value))
      header_.sizes.push_back(number<std::uint64_t>(word, "a size"));
  }

  void encoding(std::string_view value) {
    static const std::map<std::string_view, ArrayEncoding> kEncodings{
        {"raw", ArrayEncoding::kPlain}, {"gz", ArrayEncoding::kGzip},
        {"gzip", ArrayEncoding::kGzip}, {"hex", ArrayEncoding::kHex},
        {"txt", ArrayEncoding::kText},  {"text", ArrayEncoding::kText},
        {"ascii", ArrayEncoding::kText}};
    const auto found = kEncodings.find(lower(value));
    if (found == kEncodings.end())
      fail("encoding raw, gzip, hex or ascii (others are rewritten by 'unu save -f nrrd -e gzip')",
           value);
    header_.encoding = found->second;
  }

  void endian(std::string_view value) {
    const std::string name = lower(value);
    if (name != "little" && name != "big") fail("endian little or big", value);
    header_.big_endian = name == "big";
  }

  void data_file(std::string_view value) {
    const auto words = words_of(value);
    const bool list = !words.empty() && words.size() <= 2 && words[0] == "LIST";
    const std::size_t percent = value.find('%');
    const std::size_t conversion = percent == std::string_view::npos
                                       ? percent
                                       : value.find_first_not_of("0123456789", percent + 1);
    const bool pattern =
        words.size() >= 4 && conversion != std::string_view::npos && value[conversion] == 'd';
    if (value.empty() || list || pattern)
      fail("the name of one data file (join several with 'unu join' or 'unu save')", value);
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
    for (const std::string_view word : words_of_axes(value))
      header_.spacings.push_back(spacing(number<double>(word, "a spacing"), word));
  }

  /// The numbers of "(a,b,c)", of which all vectors of a header have equally many.
  std::vector<double> vector_of(std::string_view text, std::string_view value) {
    std::string inner(text);
    std::replace(inner.begin(), inner.end(), ',', ' ');
    std::vector<double> numbers;
    for (const std::string_view word : words_of(inner))
      numbers.push_back(number<double>(word, "a number"));
    if (std::ranges::any_of(numbers, [](double n) { return std::isinf(n); }))
      fail("finite numbers", value);
    const std::size_t dimension = header_.space_dimension.value_or(numbers.size());
    if (numbers.empty() || numbers.size() != dimension)
      fail(fmt::format("vectors of {} numbers, as the space has axes", dimension), value);
    header_.space_dimension = dimension;
    return numbers;
  }

  void space_directions(std::string_view value) {
    const std::string expected = fmt::format("{} vectors (a,b,c) or none, one per axis", axes_);
    for (std::size_t at = value.find_first_not_of(" \t"); at != std::string_view::npos;) {
      const bool vector = value[at] == '(';
      const std::size_t end =
          vector ? value.find(')', at) : std::min(value.find_first_of(" \t(", at), value.size());
      if (end == std::string_view::npos) fail(expected, value);
      if (!vector && lower(value.substr(at, end - at)) != "none") fail(expected, value);
      std::vector<double> direction;
      if (vector) direction = vector_of(value.substr(at + 1, end - at - 1), value);
      header_.directions.push_back(std::move(direction));
      at = value.find_first_not_of(" \t", end + (vector ? 1 : 0));
    }
    if (header_.directions.size() != axes_) fail(expected, value);
  }

  void space_origin(std::string_view value) {
    if (!value.starts_with('(') || !value.ends_with(')')) fail("one vector (a,b,c)", value);
    header_.space_origin = vector_of(value.substr(1, value.size() - 2), value);
  }

  void units(std::string_view value) {
    header_.units = quoted_of(value);
    if (header_.units.size() != axes_)
      fail(fmt::format("{} units in quotation marks, one per axis", axes_), value);
  }
  void space_units(std::string_view value) {
    header_.space_units = quoted_of(value);
    if (header_.space_units.size() != header_.space_dimension.value_or(header_.space_units.size()))
      fail(fmt::format("{} units in quotation marks, one per axis of the space",
                       *header_.space_dimension),
           value);
  }

  void kinds(std::string_view value) {
    for (const std::string_view word : words_of_axes(value)) header_.kinds.push_back(lower(word));
  }

  /// Errors about the header as a whole name its last line.
  void finish() const {
    for (const char* name : {"dimension", "type", "sizes", "encoding"}) {
      if (!header_.lines.contains(name))
        fail(fmt::format("the field '{}' before the end of the header", name), line_);
    }
    const bool ordered = size_of(header_.type.type) > 1 && header_.encoding != ArrayEncoding::kText;
    if (ordered && !header_.lines.contains("endian")) fail("the field 'endian'", line_);
    const bool text =
        header_.encoding == ArrayEncoding::kText || header_.encoding == ArrayEncoding::kHex;
    if (header_.byte_skip < 0 && text) fail("byte skip -1 only with raw and gzip", "hex or ascii");
  }

  const std::string& file_;
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t number_ = 0;
  std::string_view line_;
  std::map<std::string, std::size_t, std::less<>> keys_;
  std::size_t axes_ = 0;
  NrrdHeader header_;
};

}  // namespace

std::string NrrdHeader::line_of(const std::string& field) const {
  const auto line = lines.find(field);
  return line == lines.end() ? field : fmt::format("line {}", line->second);
}

NrrdHeader parse_nrrd_header(const std::string& file, std::string_view text) {
  return HeaderParser(file, text).parse();
}

}  // namespace cvr::volumes
