// HDF5 files made by plain calls of the library, so that no code under test writes them.
#pragma once

#include <hdf5.h>

#include "tests/unit/volumes/io/io_fixture.hpp"

namespace cvr::volumes {

/// An HDF5 file made by plain calls of the library, so that no code under test writes it.
class Hdf5File {
 public:
  explicit Hdf5File(std::string name)
      : name_(std::move(name)),
        file_(H5Fcreate(name_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)) {}
  ~Hdf5File() { close(); }

  template <class T>
  Hdf5File& dataset(const char* name, hid_t type, const std::vector<hsize_t>& size,
                    const std::vector<T>& values, const std::vector<hsize_t>& chunk = {}) {
    const hid_t space = H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr);
    const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
    if (!chunk.empty()) H5Pset_chunk(layout, static_cast<int>(chunk.size()), chunk.data());
    const hid_t data = H5Dcreate2(file_, name, type, space, H5P_DEFAULT, layout, H5P_DEFAULT);
    H5Pclose(layout);
    const hid_t memory = H5Tget_native_type(type, H5T_DIR_DEFAULT);
    if (!values.empty()) H5Dwrite(data, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Tclose(memory);
    H5Dclose(data);
    H5Sclose(space);
    return *this;
  }

  Hdf5File& numbers(const char* object, const char* name, const std::vector<double>& values) {
    return attribute(object, name, H5Tcopy(H5T_NATIVE_DOUBLE), list_of(values.size()),
                     values.data());
  }

  /// A text of the attribute's own length, without room for a terminator.
  Hdf5File& fixed_text(const char* object, const char* name, const std::string& text) {
    const hid_t type = text_type(text.size());
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    return attribute(object, name, type, H5Screate(H5S_SCALAR), text.data());
  }

  /// A text of variable length, as h5py writes them.
  Hdf5File& text(const char* object, const char* name, const std::string& text) {
    const char* value = text.c_str();
    return attribute(object, name, text_type(H5T_VARIABLE), H5Screate(H5S_SCALAR), &value);
  }

  /// A list of texts of variable length, as the dimension scales' labels are.
  Hdf5File& texts(const char* object, const char* name, const std::vector<const char*>& values) {
    return attribute(object, name, text_type(H5T_VARIABLE), list_of(values.size()), values.data());
  }

  hid_t id() const { return file_; }

  const std::string& close() {
    if (file_ >= 0) H5Fclose(std::exchange(file_, -1));
    return name_;
  }

 private:
  static hid_t text_type(std::size_t size) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, size);
    return type;
  }
  static hid_t list_of(hsize_t count) { return H5Screate_simple(1, &count, nullptr); }

  /// Takes over the type and the space.
  Hdf5File& attribute(const char* object, const char* name, hid_t type, hid_t space,
                      const void* data) {
    const hid_t attribute =
        H5Acreate_by_name(file_, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, data);
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
    return *this;
  }

  std::string name_;
  hid_t file_;
};

template <class T>
inline std::vector<T> counting(std::size_t count) {
  std::vector<T> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<T>(i);
  return values;
}

}  // namespace cvr::volumes
