// Versions of the libraries that codecs and formats use: as loaded, which may differ from what the
// program was compiled with.
#pragma once

#include <map>
#include <string>

namespace cvr::codecs {

/// By the libraries' own names. A library that cannot be asked is known by the name of its file, or
/// as "unknown".
std::map<std::string, std::string> library_versions();

}  // namespace cvr::codecs
