#include "volumes/io/hdf5_handle.hpp"

namespace cvr::volumes {

namespace {

std::recursive_mutex& library_mutex() {
  static std::recursive_mutex mutex;  // as global as the library's own state, which it guards
  return mutex;
}

}  // namespace

Hdf5Session::Hdf5Session() : lock_(library_mutex()) {
  H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Hdf5Session::~Hdf5Session() { H5Eset_auto2(H5E_DEFAULT, print_, print_data_); }

std::string hdf5_reason() {
  std::string reason;
  const H5E_walk2_t keep_innermost = [](unsigned, const H5E_error2_t* entry, void* data) -> herr_t {
    auto& text = *static_cast<std::string*>(data);
    if (text.empty() && entry->desc != nullptr) text = entry->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &reason);
  // What the system said stands in the middle of a long line of addresses.
  constexpr std::string_view kSystem = "error message = '";
  if (const std::size_t start = reason.find(kSystem); start != std::string::npos) {
    const std::size_t from = start + kSystem.size();
    return reason.substr(from, reason.find('\'', from) - from);
  }
  return reason.empty() ? "an unknown failure" : reason;
}

hid_t hdf5_file_type(VoxelType type) {
  switch (type) {
    case VoxelType::kU8:
      return H5T_STD_U8LE;
    case VoxelType::kU16:
      return H5T_STD_U16LE;
    case VoxelType::kU32:
      return H5T_STD_U32LE;
    case VoxelType::kU64:
      return H5T_STD_U64LE;
    case VoxelType::kI16:
      return H5T_STD_I16LE;
    case VoxelType::kF32:
      return H5T_IEEE_F32LE;
  }
  return H5I_INVALID_HID;
}

}  // namespace cvr::volumes
