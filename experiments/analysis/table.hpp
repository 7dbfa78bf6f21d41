// A table as data: columns, lines of cells, notes. It is built once (tables.hpp, claims.hpp);
// Markdown, CSV, LaTeX and JSON are written from it (table_formats.hpp).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/analysis/reading.hpp"

namespace cvr::experiments {

enum class Align : std::uint8_t { kLeft, kRight };
/// "left", "right".
std::string_view name_of(Align align);

struct TableColumn {
  std::string name;         ///< of the label or metric as configurations know it
  std::string heading;      ///< with the unit
  std::string unit;         ///< as the heading spells it; "" where it has none
  std::string description;  ///< what its cells are, for who sees them for the first time
  Align align = Align::kRight;
};

/// What a publication states.
struct PublishedValue {
  std::string text;
  std::optional<double> number;
};

struct TableCell {
  std::string text;  ///< as all formats show it
  /// That the text begins with, not rounded; infinity for the PSNR of what is exact.
  std::optional<double> number;
  std::optional<Interval> interval;         ///< of a time that was measured often enough
  std::optional<PublishedValue> published;  ///< beside the measured figure
};

struct LineOfCells {
  std::vector<TableCell> cells;  ///< one a column
  /// Metrics that mark it as lying on a front; none in tables whose lines have no such marks.
  std::optional<std::vector<std::string>> fronts;
};

/// A part of a note: a word that the note explains, text of the program itself, or text from
/// outside, whose characters mean nothing in any format.
struct NotePart {
  enum class Kind : std::uint8_t { kTerm, kOwn, kGiven };
  Kind kind;
  std::string text;
};

/// A sentence below a table.
class Note {
 public:
  Note& term(std::string text) { return add(NotePart::Kind::kTerm, std::move(text)); }
  Note& own(std::string text) { return add(NotePart::Kind::kOwn, std::move(text)); }
  Note& given(std::string text) { return add(NotePart::Kind::kGiven, std::move(text)); }

  const std::vector<NotePart>& parts() const { return parts_; }
  /// Without marks, control characters made visible.
  std::string plain() const;

 private:
  Note& add(NotePart::Kind kind, std::string text) {
    parts_.push_back({kind, std::move(text)});
    return *this;
  }
  std::vector<NotePart> parts_;
};

/// Where published figures come from.
struct PublishedOrigin {
  std::string citation, title;
  std::string hardware;  ///< "" where it is not stated
};

struct Table {
  std::string name, title;
  std::vector<TableColumn> columns;
  std::size_t labels = 0;  ///< leading columns that say what a line is about
  std::vector<LineOfCells> lines;
  std::vector<Note> notes;  ///< what columns mean, machines, stand-ins, statuses
  std::optional<PublishedOrigin> published;

  /// A column that labels lines; its heading is its name.
  void add_label(std::string name, std::string description = "");
  void add_line(std::vector<std::string> texts);
};

/// The unit that a heading names, for instance "ns" of "access ns, level 3"; "" where it names none.
std::string_view unit_in(std::string_view heading);

}  // namespace cvr::experiments
