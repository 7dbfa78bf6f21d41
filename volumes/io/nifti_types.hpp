// What reader and writer of NIfTI-1 share: sizes, type codes and units.
#pragma once

#include <nifti/nifti1.h>

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "volumes/io/format.hpp"

namespace cvr::volumes::nifti {

inline constexpr std::size_t kHeaderBytes = 348;
inline constexpr std::size_t kVoxelOffset = 352;
inline constexpr std::string_view kMagic{"n+1\0", 4};
static_assert(sizeof(nifti_1_header) == kHeaderBytes);

struct TypeCode {
  short code;
  StoredType type;
};
inline constexpr std::array kTypeCodes{
    TypeCode{DT_UINT8, {VoxelType::kU8, false}},
    TypeCode{DT_UINT16, {VoxelType::kU16, false}},
    TypeCode{DT_UINT32, {VoxelType::kU32, false}},
    TypeCode{DT_UINT64, {VoxelType::kU64, false}},
    TypeCode{DT_INT16, {VoxelType::kI16, true}},
    TypeCode{DT_FLOAT32, {VoxelType::kF32, false}},
    TypeCode{DT_INT8, {VoxelType::kU8, true}},
    TypeCode{DT_INT32, {VoxelType::kU32, true}},
    TypeCode{DT_INT64, {VoxelType::kU64, true}},
    TypeCode{DT_FLOAT64, {VoxelType::kU64, false, true}},
};

/// Metres and name of the spatial unit; 0 where the header says none.
inline std::pair<double, std::string> unit_of(char xyzt_units) {
  switch (XYZT_TO_SPACE(xyzt_units)) {
    case NIFTI_UNITS_METER:
      return {1.0, "m"};
    case NIFTI_UNITS_MM:
      return {1e-3, "mm"};
    case NIFTI_UNITS_MICRON:
      return {1e-6, "um"};
    default:
      return {0.0, ""};
  }
}

}  // namespace cvr::volumes::nifti
