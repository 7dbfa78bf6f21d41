// HDF5 files made by plain calls of the library, so that no code under test writes them.
#pragma once

#include <hdf5.h>

#include "io_fixture.hpp"

namespace cvr::volumes {

/// An HDF5 file made by plain calls of the library, so that no code under test writes it.
class Hdf5File {
 public:
  explicit Hdf5File(std::string name)
      : name_(std::move(name)), file_(H5Fcreate(name_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)) {}
  ~Hdf5File() { close(); }

  template <class T>
  Hdf5File& dataset(const char* name, hid_t type, const std::vector<hsize_t>& size,
                    const std::vector<T>& values) {
    const hid_t space = H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr);
    const hid_t data = H5Dcreate2(file_, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t memory = H5Tget_native_type(type, H5T_DIR_DEFAULT);
    if (!values.empty()) H5Dwrite(data, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Tclose(memory);
    H5Dclose(data);
    H5Sclose(space);
    return *this;
  }

  Hdf5File& numbers(const char* object, const char* name, const std::vector<double>& values) {
    const hsize_t count = values.size();
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t attribute = H5Acreate_by_name(file_, object, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT,
                                              H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, H5T_NATIVE_DOUBLE, values.data());
    H5Aclose(attribute);
    H5Sclose(space);
    return *this;
  }

  Hdf5File& fixed_text(const char* object, const char* name, const std::string& text) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, text.size());  // without room for a terminator
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute =
        H5Acreate_by_name(file_, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, text.data());
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
    return *this;
  }

  /// A text of variable length, as h5py writes them.
  Hdf5File& text(const char* object, const char* name, const std::string& text) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute =
        H5Acreate_by_name(file_, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const char* value = text.c_str();
    H5Awrite(attribute, type, &value);
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
    return *this;
  }

  /// A list of texts of variable length, as the dimension scales' labels are.
  Hdf5File& texts(const char* object, const char* name, const std::vector<const char*>& values) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    const hsize_t count = values.size();
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t attribute =
        H5Acreate_by_name(file_, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, values.data());
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
    return *this;
  }

  hid_t id() const { return file_; }

  const std::string& close() {
    if (file_ >= 0) H5Fclose(std::exchange(file_, -1));
    return name_;
  }

 private:
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
