// The ways in which this project says that something went wrong.
//
// Expected<T>: decoders and validators return it, since bad bytes are an ordinary input there.
// InputError:  readers of files and configurations throw it; its text names file, position and what
// was expected. OutputError: writers throw it where the machine is at fault, not what was asked
// for.
#pragma once

#include <stdexcept>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace cvr::volumes {

enum class ErrorCode {
  kBadArgument,  ///< a parameter or coordinate outside its range
  kUnsupported,  ///< legal, but this codec cannot do it (the message says why)
  kMalformed,    ///< bytes that no encoder of this format writes
  kTruncated,    ///< the stream ends before what it announces
  kChecksum,     ///< the stored checksum differs from the computed one
  kTooLarge,     ///< exceeds a limit of the format (for instance Neuroglancer's 24-bit offsets)
  kOutOfMemory,  ///< an allocation failed
};

struct Error {
  ErrorCode code;
  std::string message;
};

template <class T>
using Expected = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(ErrorCode code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

/// A file or a configuration that cannot be read or written. `what()` reads "FILE: POSITION:
/// expected ..., found ...".
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An output that cannot be written, whatever its content: no room, no permission, a device that
/// fails. `what()` reads like InputError's.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace cvr::volumes
