// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <hdf5.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

/// A thin layer over the C interface of HDF5: handles that close themselves, and failures as Error(io) with the library's own words.
namespace stiffront::hdf5 {

/// Stops the library from printing to stderr; errors are reported by check() instead. Cheap, call it before the first use.
void silence();

/// Throws Error(io): what failed, then the innermost description on HDF5's error stack.
[[noreturn]] void fail(const std::string& what);

/// Passes a non-negative result on. @throws Error(io) otherwise.
template <class T>
T check(T result, const std::string& what) {
  if (result < 0) fail(what);
  return result;
}

/// Owns an identifier of HDF5. The destructor ignores failures; where they matter, close() reports them.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);

  Handle() = default;
  /// @throws Error(io) if id is negative.
  Handle(hid_t id, Close close, const std::string& what) : id_(check(id, what)), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }

  operator hid_t() const { return id_; }  // NOLINT: stands for the identifier in every call of the library
  void close(const std::string& what) {
    if (id_ >= 0) check(close_(std::exchange(id_, H5I_INVALID_HID)), what);
  }

 private:
  hid_t id_ = H5I_INVALID_HID;
  Close close_ = nullptr;
};

/// File access properties, with the oldest format that serves (a superblock without checksum: H5Fget_file_image of HDF5 1.10 spoils a
/// newer one).
Handle file_access();
Handle simple_space(const std::vector<hsize_t>& extent);
/// UTF-8 of variable length: what h5py gives back as str, and no limit of 64 KiB on an attribute.
Handle string_type();

void write_attribute(hid_t object, const std::string& name, const std::string& text);
void write_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts);
void write_attribute(hid_t object, const std::string& name, double value);
void write_attribute(hid_t object, const std::string& name, std::int64_t value);
void write_attribute(hid_t object, const std::string& name, const std::vector<double>& values);
void write_attribute(hid_t object, const std::string& name, const std::vector<std::int64_t>& values);

/// @throws Error(io) if the attribute is not there or of another class. Strings may be of fixed or variable length.
std::string read_text(hid_t object, const std::string& name);
std::vector<std::string> read_texts(hid_t object, const std::string& name);
std::vector<double> read_numbers(hid_t object, const std::string& name);
std::vector<std::int64_t> read_integers(hid_t object, const std::string& name);
bool has_attribute(hid_t object, const std::string& name);

/// Opens an existing file on this process alone, if it is as it was sealed (seal.hpp). @throws Error(io)
Handle open_file(const std::string& path);
bool has_dataset(hid_t file, const std::string& name);
std::vector<hsize_t> extent_of(hid_t dataset);

}  // namespace stiffront::hdf5
