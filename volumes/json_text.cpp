#include "volumes/json_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <vector>

#include "volumes/error.hpp"
#include "volumes/io/file.hpp"

namespace cvr::volumes {

namespace {

using Json = nlohmann::ordered_json;

/// "DOCUMENT:LINE:COLUMN" of a byte.
std::string place_of(std::string_view text, std::size_t at, const std::string& document,
                     std::size_t line) {
  const std::string_view before = text.substr(0, std::min(at, text.size()));
  const auto lines = static_cast<std::size_t>(std::ranges::count(before, '\n'));
  const std::size_t newline = before.rfind('\n');
  const std::size_t column =
      newline == std::string_view::npos ? before.size() + 1 : before.size() - newline;
  return fmt::format("{}:{}:{}", document, line + lines, column);
}

/// The library's message without its number and its position, which is ours.
std::string reason_of(const Json::exception& error) {
  std::string reason = error.what();
  for (const std::string_view prefix : {"] ", "syntax error while parsing "}) {
    if (const std::size_t at = reason.find(prefix); at != std::string::npos)
      reason.erase(0, at + prefix.size());
  }
  constexpr std::size_t kLongest = 200;
  return reason.size() <= kLongest ? reason : reason.substr(0, kLongest) + " ...";
}

/// Byte where nesting first exceeds kMaxJsonDepth, or npos. Brackets within strings do not count.
std::size_t too_deep_at(std::string_view text) {
  std::size_t depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') ++i;
      quoted = c != '"';
    } else if (c == '"') {
      quoted = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxJsonDepth) return i;
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return std::string_view::npos;
}

}  // namespace

Json parse_json(std::string_view text, const std::string& document, std::size_t line) {
  if (const std::size_t at = too_deep_at(text); at != std::string_view::npos) {
    throw InputError(fmt::format(
        "{}: expected JSON of at most {} levels of lists and objects, found a deeper one",
        place_of(text, at, document, line), kMaxJsonDepth));
  }
  // The parser does not say where a key stands; a line is place enough.
  const bool is_line = text.find('\n') == std::string_view::npos;
  std::vector<std::set<std::string>> keys;
  const auto keys_once = [&](int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key &&
        !keys.back().insert(parsed.get<std::string>()).second) {
      throw InputError(fmt::format("{}: expected each key once, found {} again",
                                   is_line ? fmt::format("{}:{}", document, line) : document,
                                   parsed.dump(-1, ' ', true)));
    }
    return true;
  };
  try {
    return Json::parse(text.begin(), text.end(), keys_once);
  } catch (const Json::parse_error& error) {
    const std::size_t at = error.byte == 0 ? 0 : error.byte - 1;
    throw InputError(fmt::format("{}: expected JSON, found: {}", place_of(text, at, document, line),
                                 reason_of(error)));
  } catch (const Json::exception& error) {  // a number beyond a double's range
    throw InputError(fmt::format("{}: expected JSON, found: {}", place_of(text, 0, document, line),
                                 reason_of(error)));
  }
}

Json read_json_file(const std::string& path) { return parse_json(MappedFile(path).text(), path); }

}  // namespace cvr::volumes
