// Checks of datasets and attributes of an HDF5 file before they are read. HDF5 itself reads values from other files,
// loads filters from folders, reads what was never written as zeros, and reads as many values as the file specifies,
// independently of the size of the caller's memory.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>

#include "hdf5_file.hpp"

namespace phynness::hdf5 {

/// The defect of a dataset's storage, or empty. A valid dataset is stored in this file, has no filters except shuffle,
/// deflate and fletcher32, and is written completely.
std::string storage_defect(hid_t dataset, const Shape& shape, std::size_t bytes_per_value);

/// The shape of a dataset or attribute with one value or an array of them.
/// @return false if it has no shape (a null dataspace)
bool read_shape(hid_t space, Shape& shape);

/// The product of the extents, limited to the largest number of the type.
std::uint64_t number_of_values(const Shape& shape);
/// "[6, 3]"
std::string text(const Shape& shape);
/// Name of a type for messages: "int32", "float64", "text".
std::string name_of_type(hid_t type);

}  // namespace phynness::hdf5
