// What an object of an HDF5 file is, checked before anything of it is used: a file may come from anywhere,
// and HDF5 itself follows links into other files, loads filters from folders, and reads as many values as the
// file says, whatever room the caller has.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>

#include "hdf5_file.hpp"

namespace phynness::hdf5 {

/// Opens the object at an absolute path ("/mesh/nodes", "/") if all on the way are groups that the file
/// itself holds. No link to another path or file is followed.
/// @returns a handle that is negative, with `defect` set, if there is none
Handle open_own_object(hid_t file, const std::string& path, std::string& defect);

/// @returns whether the path has an object of the file's own; `defect` is set if it has a link of another
/// kind
bool has_own_object(hid_t file, const std::string& path, std::string& defect);

/// What is wrong with how a dataset is stored; empty if nothing is. Good is: in this file, filtered by
/// nothing but shuffle, deflate and fletcher32, written completely, and stored in as many bytes as its shape
/// can have.
std::string storage_defect(hid_t dataset, const Shape& shape, std::size_t bytes_per_value, std::uint64_t bytes_of_file);

/// The shape of a dataset or attribute with one value or an array of them.
/// @returns false if it has none (a null dataspace)
bool read_shape(hid_t space, Shape& shape);

/// The product of the extents; the largest number there is if it is larger.
std::uint64_t number_of_values(const Shape& shape);
/// "[6, 3]"
std::string text(const Shape& shape);
/// "int32", "float64", "text" or the class of any other type, for messages.
std::string name_of_type(hid_t type);
/// An integer of 1, 2, 4 or 8 bytes, all of whose bits count.
bool is_plain_integer(hid_t type);

}  // namespace phynness::hdf5
