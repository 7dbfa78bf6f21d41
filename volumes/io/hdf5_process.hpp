// HDF5 files are read and written by a child process, never in this one: a damaged file makes
// libhdf5 1.10 read and write outside its memory or loop for ever, and a full disk makes it crash
// when its handles close.
//
// The child is a fork of this process that serves one file. Requests and replies are CBOR over a
// socket, voxels lie in memory that both share. The child closes every other descriptor, so that it
// keeps no pipe of its parent open; it ignores SIGINT, since its parent decides what an
// interruption means; it ends when its parent does. Each request may take a bounded time of
// computing (RLIMIT_CPU, so that a busy machine does not count) and a bounded time in all. What the
// library does to the child becomes an Hdf5Failure.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string>

namespace cvr::volumes {

/// The child crashed, ran out of time or memory, or could not be started. what() says which.
class Hdf5Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Hdf5Process {
 public:
  /// Answers one request. Runs in the child; `shared` is the memory that both see. It keeps its
  /// state from one request to the next. An InputError or OutputError that it throws is thrown by
  /// call().
  using Serve =
      std::function<nlohmann::json(const nlohmann::json& request, std::span<std::byte> shared)>;

  /// Starts the child. Throws Hdf5Failure.
  Hdf5Process(std::size_t shared_bytes, Serve serve);
  /// Ends the child, whatever it is doing, and waits for it.
  ~Hdf5Process();
  Hdf5Process(const Hdf5Process&) = delete;
  Hdf5Process& operator=(const Hdf5Process&) = delete;

  std::span<std::byte> shared() const { return shared_; }

  /// Sends a request and waits for its reply, at most `cpu_seconds` of the child's computing.
  /// Throws InputError, OutputError or Hdf5Failure; after the last of these every call throws.
  nlohmann::json call(const nlohmann::json& request, unsigned cpu_seconds) const;

 private:
  std::string end_of_child() const;

  std::span<std::byte> shared_;
  int socket_ = -1;
  mutable pid_t child_ = -1;
};

}  // namespace cvr::volumes
