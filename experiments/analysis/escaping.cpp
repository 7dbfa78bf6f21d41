#include "experiments/analysis/escaping.hpp"

#include "volumes/plain_text.hpp"

namespace cvr::experiments {

namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_word(char c) {
  return is_letter(c) || (c >= '0' && c <= '9') || static_cast<unsigned char>(c) >= 0x80;
}
bool is_punctuation(char c) { return c > ' ' && c < 0x7F && !is_word(c); }

/// Whether a character means something in Markdown where it stands; `next` is '\0' at the end.
bool is_markup(char before, char c, char next, bool in_table) {
  switch (c) {
    case '*':
    case '`':
    case '$':
    case '~':
      return true;
    case '|':
      return in_table;
    case '_':  // within a word it is a letter
      return !is_word(before) || !is_word(next);
    case '\\':
      return is_punctuation(next) || next == '\0';
    case '<':
      return is_letter(next) || next == '/' || next == '!' || next == '?';
    case '&':
      return is_letter(next) || next == '#';
    case ']':
      return next == '(' || next == '[' || next == ':';
    default:
      return false;
  }
}

}  // namespace

std::string escape_markdown(std::string_view text, bool in_table) {
  const std::string shown = volumes::printable(text);
  std::string escaped;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const char before = i == 0 ? '\0' : shown[i - 1],
               next = i + 1 < shown.size() ? shown[i + 1] : '\0';
    if (is_markup(before, shown[i], next, in_table)) escaped += '\\';
    escaped += shown[i];
  }
  return escaped;
}

std::string escape_latex(std::string_view text) {
  std::string escaped;
  for (const char c : volumes::printable(text)) {
    switch (c) {
      case '%':
      case '_':
      case '#':
      case '&':
      case '$':
      case '{':
      case '}':
        escaped += '\\';
        escaped += c;
        break;
      case '~':
        escaped += "\\textasciitilde{}";
        break;
      case '^':
        escaped += "\\textasciicircum{}";
        break;
      case '\\':
        escaped += "\\textbackslash{}";
        break;
      case '<':
        escaped += "\\textless{}";
        break;
      case '>':
        escaped += "\\textgreater{}";
        break;
      case '|':
        escaped += "\\textbar{}";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string escape_csv(std::string_view text) {
  const std::string shown = volumes::printable(text);
  const bool blank_end = !shown.empty() && (shown.front() == ' ' || shown.back() == ' ');
  if (!blank_end && shown.find_first_of(",\"") == std::string::npos) return shown;
  std::string quoted(1, '"');
  for (const char c : shown) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

}  // namespace cvr::experiments
