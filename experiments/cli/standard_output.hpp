// Standard output as a result that can be lost: a full disk behind `> file`, a closed descriptor, a
// reader that went away.
#pragma once

#include <system_error>

namespace cvr::experiments::cli {

/// Writes out what standard output still holds. The exit code of a command that would end with
/// `exit_code`: the same where all of its standard output has arrived. Else 3, with a line on
/// standard error; or 141 and no word where the reader of a pipe went away, as a shell reports
/// programs that the signal SIGPIPE ended. `lost`: why a part of it is known to be lost already; no
/// error: none is.
int finish_standard_output(int exit_code, std::error_code lost);

}  // namespace cvr::experiments::cli
