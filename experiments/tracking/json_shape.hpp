// JSON that somebody else may have written: what is missing or of another type is an InputError,
// never undefined behaviour. Code below `expecting_shape` reads constant rows by at(), not by [].
#pragma once

#include <fmt/format.h>

#include <string>

#include "experiments/results/rows.hpp"
#include "volumes/error.hpp"

namespace cvr::experiments {

/// What `read` returns. Throws InputError "WHERE: expected WHAT, found ..." where it meets JSON of
/// another shape.
template <class Read>
auto expecting_shape(const std::string& where, const char* what, Read&& read) {
  try {
    return read();
  } catch (const nlohmann::json::exception& error) {
    const std::string text = error.what();
    const std::size_t code = text.find("] ");
    throw volumes::InputError(
        fmt::format("{}: expected {}, found JSON of another shape ({})", where, what,
                    code == std::string::npos ? text : text.substr(code + 2)));
  }
}

}  // namespace cvr::experiments
