// SPDX-License-Identifier: BSD-3-Clause
#include "hdf5.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "seal.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront::hdf5 {
namespace {

herr_t keep_innermost(unsigned, const H5E_error2_t* entry, void* text) {
  // The stack is walked from the call we made inwards: the last entry is the cause.
  if (entry->desc != nullptr && *entry->desc != '\0') *static_cast<std::string*>(text) = entry->desc;
  return 0;
}

template <class T>
void write_array(hid_t object, const std::string& name, hid_t type, const std::vector<hsize_t>& extent, const T* values) {
  const Handle space = extent.empty() ? Handle(H5Screate(H5S_SCALAR), H5Sclose, name) : simple_space(extent);
  const Handle attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                         fmt::format("cannot create the attribute '{}'", name));
  check(H5Awrite(attribute, type, values), fmt::format("cannot write the attribute '{}'", name));
}

Handle open_attribute(hid_t object, const std::string& name) {
  return Handle(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, fmt::format("no attribute '{}'", name));
}

std::size_t count_of(const Handle& attribute, const std::string& name) {
  const Handle space(H5Aget_space(attribute), H5Sclose, name);
  return static_cast<std::size_t>(check(H5Sget_simple_extent_npoints(space), name));
}

template <class T>
std::vector<T> read_array(hid_t object, const std::string& name, hid_t type) {
  const Handle attribute = open_attribute(object, name);
  std::vector<T> values(count_of(attribute, name));
  check(H5Aread(attribute, type, values.data()), fmt::format("cannot read the attribute '{}'", name));
  return values;
}

}  // namespace

void silence() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

void fail(const std::string& what) {
  std::string cause;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, &keep_innermost, &cause);
  H5Eclear2(H5E_DEFAULT);
  throw Error(ErrorKind::io, cause.empty() ? what : fmt::format("{} ({})", what, cause));
}

Handle file_access() { return Handle(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "HDF5 property list"); }

Handle simple_space(const std::vector<hsize_t>& extent) {
  return Handle(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose, "HDF5 data space");
}

Handle string_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "HDF5 string type");
  check(H5Tset_size(type, H5T_VARIABLE), "HDF5 string type");
  check(H5Tset_cset(type, H5T_CSET_UTF8), "HDF5 string type");
  return type;
}

void write_attribute(hid_t object, const std::string& name, const std::string& text) {
  const char* pointer = text.c_str();
  write_array(object, name, string_type(), {}, &pointer);
}

void write_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts) {
  std::vector<const char*> pointers;
  for (const std::string& t : texts) pointers.push_back(t.c_str());
  write_array(object, name, string_type(), {texts.size()}, pointers.data());
}

void write_attribute(hid_t object, const std::string& name, double value) { write_array(object, name, H5T_NATIVE_DOUBLE, {}, &value); }

void write_attribute(hid_t object, const std::string& name, std::int64_t value) { write_array(object, name, H5T_NATIVE_INT64, {}, &value); }

void write_attribute(hid_t object, const std::string& name, const std::vector<double>& values) {
  write_array(object, name, H5T_NATIVE_DOUBLE, {values.size()}, values.data());
}

void write_attribute(hid_t object, const std::string& name, const std::vector<std::int64_t>& values) {
  write_array(object, name, H5T_NATIVE_INT64, {values.size()}, values.data());
}

std::string read_text(hid_t object, const std::string& name) {
  const std::vector<std::string> texts = read_texts(object, name);
  return texts.empty() ? std::string() : texts[0];
}

std::vector<std::string> read_texts(hid_t object, const std::string& name) {
  const Handle attribute = open_attribute(object, name);
  const Handle type(H5Aget_type(attribute), H5Tclose, name);
  if (H5Tget_class(type) != H5T_STRING) throw Error(ErrorKind::io, fmt::format("the attribute '{}' is no text", name));
  std::vector<std::string> texts(count_of(attribute, name));
  if (H5Tis_variable_str(type) > 0) {
    std::vector<char*> pointers(texts.size(), nullptr);
    check(H5Aread(attribute, type, pointers.data()), fmt::format("cannot read the attribute '{}'", name));
    for (std::size_t n = 0; n < texts.size(); ++n) {
      if (pointers[n] != nullptr) texts[n] = pointers[n];
      H5free_memory(pointers[n]);
    }
    return texts;
  }
  const std::size_t length = H5Tget_size(type);
  std::vector<char> block(length * texts.size());
  check(H5Aread(attribute, type, block.data()), fmt::format("cannot read the attribute '{}'", name));
  for (std::size_t n = 0; n < texts.size(); ++n) {
    const char* p = block.data() + n * length;
    texts[n].assign(p, strnlen(p, length));
  }
  return texts;
}

std::vector<double> read_numbers(hid_t object, const std::string& name) { return read_array<double>(object, name, H5T_NATIVE_DOUBLE); }

std::vector<std::int64_t> read_integers(hid_t object, const std::string& name) {
  return read_array<std::int64_t>(object, name, H5T_NATIVE_INT64);
}

bool has_attribute(hid_t object, const std::string& name) { return H5Aexists(object, name.c_str()) > 0; }

Handle open_file(const std::string& path) {
  silence();
  std::error_code failed;
  const auto status = std::filesystem::status(path, failed);
  if (status.type() == std::filesystem::file_type::not_found) throw Error(ErrorKind::io, fmt::format("{}: no such file", path));
  if (std::filesystem::is_directory(status)) throw Error(ErrorKind::io, fmt::format("{}: is a folder, not a file", path));
  seal::check(path);
  const Handle access = file_access();
  return Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose, fmt::format("{}: cannot be opened as an HDF5 file", path));
}

bool has_dataset(hid_t file, const std::string& name) {
  if (H5Lexists(file, name.c_str(), H5P_DEFAULT) <= 0) return false;
  const hid_t object = H5Oopen(file, name.c_str(), H5P_DEFAULT);
  if (object < 0) return false;
  const bool is_dataset = H5Iget_type(object) == H5I_DATASET;
  H5Oclose(object);
  return is_dataset;
}

std::vector<hsize_t> extent_of(hid_t dataset) {
  const Handle space(H5Dget_space(dataset), H5Sclose, "HDF5 data space");
  const int rank = check(H5Sget_simple_extent_ndims(space), "HDF5 data space");
  std::vector<hsize_t> extent(static_cast<std::size_t>(rank));
  check(H5Sget_simple_extent_dims(space, extent.data(), nullptr), "HDF5 data space");
  return extent;
}

}  // namespace stiffront::hdf5
