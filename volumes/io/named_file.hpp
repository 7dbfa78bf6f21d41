// Files that a volume's own file names: where they are, and whether they may be read.
#pragma once

#include <string>
#include <string_view>

#include "volumes/io/io.hpp"

namespace cvr::volumes {

/// The path of a file that `file` calls `name`; a relative name starts in the folder of `file`.
/// Throws InputError at `position`, naming the target, if it lies neither in that folder nor below
/// it, with symbolic links followed, unless `options.allow_external`.
std::string named_file(const std::string& file, std::string_view position, std::string_view name,
                       const OpenOptions& options);

}  // namespace cvr::volumes
