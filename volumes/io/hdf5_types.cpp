// Stored types: their names in messages, and how voxels of them are read.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <bit>

#include "volumes/io/hdf5_objects.hpp"

namespace cvr::volumes {

namespace {

std::string member_names(hid_t type) {
  std::vector<std::string> names;
  const int count = H5Tget_nmembers(type);
  for (int i = 0; i < count && i < 16; ++i) {
    char* name = H5Tget_member_name(type, static_cast<unsigned>(i));
    if (name == nullptr) continue;
    names.emplace_back(name);
    H5free_memory(name);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

bool is_signed_integer(hid_t type) { return H5Tget_sign(type) == H5T_SGN_2; }

}  // namespace

std::string hdf5_type_name(hid_t type) {
  const std::size_t bits = 8 * H5Tget_size(type);
  switch (H5Tget_class(type)) {
    case H5T_INTEGER:
      return fmt::format("{}{}", is_signed_integer(type) ? "i" : "u", bits);
    case H5T_FLOAT:
      return bits == 64 ? "f64 (float64)" : fmt::format("f{}", bits);
    case H5T_ENUM: {
      const Hdf5Handle base(H5Tget_super(type), H5Tclose);
      return fmt::format("an enumeration of {} ({})", hdf5_type_name(base.get()),
                         member_names(type));
    }
    case H5T_STRING:
      return "text";
    case H5T_BITFIELD:
      return fmt::format("{} bits", bits);
    case H5T_OPAQUE:
      return fmt::format("opaque bytes ({} each)", bits / 8);
    case H5T_COMPOUND:
      return fmt::format("a compound of {}", member_names(type));
    case H5T_REFERENCE:
      return "a reference";
    case H5T_VLEN:
      return "lists of variable length";
    case H5T_ARRAY:
      return "arrays";
    case H5T_TIME:
      return "a time";
    default:
      return "an unknown type";
  }
}

Hdf5Stored hdf5_stored(hid_t type) {
  Hdf5Stored stored{hdf5_type_name(type), false, false, 0};
  const std::size_t size = H5Tget_size(type);
  const H5T_class_t kind = H5Tget_class(type);
  if (size == 0 || size > 8) return stored;
  const auto width = static_cast<unsigned>(std::bit_ceil(size));
  if (kind == H5T_FLOAT) {
    stored.is_float = true;
    stored.width = width <= 4 ? 4 : 8;
  } else if (kind == H5T_INTEGER || kind == H5T_ENUM) {
    const Hdf5Handle base(kind == H5T_ENUM ? H5Tget_super(type) : H5Tcopy(type), H5Tclose);
    if (H5Tget_class(base.get()) != H5T_INTEGER) return stored;
    stored.is_signed = is_signed_integer(base.get());
    stored.width = width;
  } else if (kind == H5T_BITFIELD && size == 1) {
    stored.width = 1;
  }
  return stored;
}

hid_t hdf5_memory_type(const Hdf5Stored& stored) {
  if (stored.is_float) return stored.width == 4 ? H5T_NATIVE_FLOAT : H5T_NATIVE_DOUBLE;
  switch (stored.width) {
    case 1:
      return stored.is_signed ? H5T_NATIVE_INT8 : H5T_NATIVE_UINT8;
    case 2:
      return stored.is_signed ? H5T_NATIVE_INT16 : H5T_NATIVE_UINT16;
    case 4:
      return stored.is_signed ? H5T_NATIVE_INT32 : H5T_NATIVE_UINT32;
    default:
      return stored.is_signed ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT64;
  }
}

}  // namespace cvr::volumes
