// Texts of variable length, read without HDF5's own code. A file stores the length of such a text, the address of a
// global heap, and an index in this heap; see "Global Heap" in HDF5's file format specification. A heap has no
// checksum, and HDF5 1.10 does not validate it: a zeroed block causes an infinite loop, and wrong sizes cause copies
// beyond buffers.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "durable_file.hpp"
#include "hdf5_file.hpp"

namespace phynness::hdf5 {

/// Bytes in an attribute or a dataset that tell where a text of variable length is.
inline constexpr std::size_t text_place_bytes = 16;

/// More than any scene that is read (scene.cpp), with what HDF5 puts around it.
inline constexpr std::uint64_t most_text_bytes = 32 << 20;

/// A memory type for texts of variable length; reading into it gives the bytes that tell where the text is.
/// @return a handle, negative on failure
Handle text_place_type();

/// Reads the text after all addresses and sizes have been checked.
/// @param bytes_of_file  size of `file`
/// @return what is wrong if the text cannot be read, or empty
std::string read_text_at(const Descriptor& file, const std::filesystem::path& path, std::uint64_t bytes_of_file,
                         const unsigned char (&place)[text_place_bytes], std::string& text);

}  // namespace phynness::hdf5
