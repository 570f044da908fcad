// Checks of objects of an HDF5 file before they are used, because a file may come from an untrusted source. HDF5 itself
// follows links to other files, loads filters from folders, and reads as many values as the file specifies,
// independently of the size of the caller's memory.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>

#include "hdf5_file.hpp"

namespace phynness::hdf5 {

/// Opens the object at an absolute path ("/mesh/nodes", "/") if its path consists of groups of the same file. No link
/// to another path or file is followed.
/// @return a handle; if there is no such object it is negative, and `defect` is set
Handle open_own_object(hid_t file, const std::string& path, std::string& defect);

/// @return whether the path has an object of the same file; `defect` is set if it has a link instead
bool has_own_object(hid_t file, const std::string& path, std::string& defect);

/// The defect of a dataset's storage, or empty. A valid dataset is stored in this file, has no filters except shuffle,
/// deflate and fletcher32, is written completely, and is stored in a number of bytes that its shape can have.
std::string storage_defect(hid_t dataset, const Shape& shape, std::size_t bytes_per_value, std::uint64_t bytes_of_file);

/// The shape of a dataset or attribute with one value or an array of them.
/// @return false if it has no shape (a null dataspace)
bool read_shape(hid_t space, Shape& shape);

/// The product of the extents, limited to the largest number of the type.
std::uint64_t number_of_values(const Shape& shape);
/// "[6, 3]"
std::string text(const Shape& shape);
/// Name of a type for messages: "int32", "float64", "text", or the class of any other type.
std::string name_of_type(hid_t type);
/// Whether a type is an integer of 1, 2, 4 or 8 bytes that uses all of its bits.
bool is_plain_integer(hid_t type);

}  // namespace phynness::hdf5
