// Names and messages that end in tables of several formats. Control characters are made visible
// first in each of them, so that no text begins a line of its own.
#pragma once

#include <string>
#include <string_view>

namespace cvr::experiments {

/// As plain words in Markdown: what would begin emphasis, code, a link, HTML, a formula or an
/// entity stands behind a backslash. `in_table`: a | as well.
std::string escape_markdown(std::string_view text, bool in_table = true);

/// As plain words in LaTeX: no character of it is a command.
std::string escape_latex(std::string_view text);

/// A field of RFC 4180: in quotation marks where it holds a comma, a quotation mark or a blank at
/// an end. The value itself is never changed, so a field may begin with =, +, - or @: programs that
/// take such fields for formulas must be told to import text.
std::string escape_csv(std::string_view text);

}  // namespace cvr::experiments
