#include "experiments/rows.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <sstream>
#include <system_error>

#include "volumes/error.hpp"

namespace cvr::experiments {

namespace {

[[noreturn]] void fail_with_errno(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

std::string read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (in) text << in.rdbuf();
  return text.str();
}

}  // namespace

double whole_over_part(const Row& row) {
  const Row& dataset = row.at("dataset");
  const double voxels = dataset.value("voxels", 1.0);
  return dataset.value("original_voxels", voxels) / voxels;
}

std::vector<Row> load_rows(const std::string& path) {
  const std::string text = read_text(path);
  std::vector<Row> rows;
  std::size_t line = 1;
  for (std::size_t at = 0; at < text.size(); ++line) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string::npos) break;
    Row row = Row::parse(text.substr(at, end - at), nullptr, false);
    const bool whole =
        row.is_object() && row.contains("cell") && row.contains("key") && row.contains("status");
    if (!whole) {
      throw volumes::InputError(
          fmt::format("{}:{}: expected a row (a JSON object with cell, key and status), found '{}'", path,
                      line, text.substr(at, std::min<std::size_t>(end - at, 40))));
    }
    rows.push_back(std::move(row));
    at = end + 1;
  }
  return rows;
}

std::map<std::string, Row> latest_by(const std::vector<Row>& rows, const std::string& field) {
  std::map<std::string, Row> latest;
  for (const Row& row : rows) {
    if (row.contains(field) && row[field].is_string()) latest[row[field].get<std::string>()] = row;
  }
  return latest;
}

RowWriter::RowWriter(const std::string& path)
    : descriptor_(open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644)) {
  if (descriptor_ < 0) fail_with_errno(path);
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    close(descriptor_);
    throw volumes::InputError(
        fmt::format("{}: expected to be the only run that writes here, found another one", path));
  }
  const std::string text = read_text(path);
  const std::size_t newline = text.rfind('\n');
  const std::size_t whole = newline == std::string::npos ? 0 : newline + 1;
  if (whole != text.size() && ftruncate(descriptor_, static_cast<off_t>(whole)) != 0) fail_with_errno(path);
}

RowWriter::~RowWriter() { close(descriptor_); }

void RowWriter::append(const Row& row) {
  const std::string line = row.dump(-1, ' ', false, Row::error_handler_t::replace) + "\n";
  const ssize_t written = write(descriptor_, line.data(), line.size());
  if (written != static_cast<ssize_t>(line.size())) {
    if (written >= 0) errno = ENOSPC;
    fail_with_errno("rows.jsonl");
  }
  if (fsync(descriptor_) != 0) fail_with_errno("rows.jsonl");
}

}  // namespace cvr::experiments
