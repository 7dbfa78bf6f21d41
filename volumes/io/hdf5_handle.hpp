// The HDF5 C library as this folder uses it: handles that close themselves, silence, and one lock.
//
// Debian's serial libhdf5 is not thread safe, so every use of it, over all files, happens below one
// Hdf5Session or in a child process (hdf5_process.hpp), which has one thread and takes no session.
// The session also switches off the library's printing of errors and keeps what it had to say for
// our own messages.
#pragma once

#include <hdf5.h>

#include <mutex>
#include <string>
#include <utility>

#include "volumes/volume.hpp"

namespace cvr::volumes {

class Hdf5Session {
 public:
  Hdf5Session();
  ~Hdf5Session();
  Hdf5Session(const Hdf5Session&) = delete;
  Hdf5Session& operator=(const Hdf5Session&) = delete;

 private:
  std::scoped_lock<std::recursive_mutex> lock_;
  H5E_auto2_t print_ = nullptr;
  void* print_data_ = nullptr;
};

/// What the library says about its last failure: the system's words where they are quoted ("No
/// space left on device"), else the innermost description, or "an unknown failure".
std::string hdf5_reason();

/// The type as files hold it, little endian.
hid_t hdf5_file_type(VoxelType type);

/// Owns one identifier and closes it with the function given.
class Hdf5Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Hdf5Handle() = default;
  Hdf5Handle(hid_t id, Close close) : id_(id), close_(close) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept
      : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    reset();
    id_ = std::exchange(other.id_, H5I_INVALID_HID);
    close_ = other.close_;
    return *this;
  }
  ~Hdf5Handle() { reset(); }

  hid_t get() const { return id_; }
  bool valid() const { return id_ >= 0; }
  void reset() {
    if (id_ >= 0) close_(std::exchange(id_, H5I_INVALID_HID));
  }

 private:
  hid_t id_ = H5I_INVALID_HID;
  Close close_ = nullptr;
};

}  // namespace cvr::volumes
