// Texts of variable length, read without HDF5's own code (for the reason see hdf5_heapless_driver.hpp). A file stores
// the length of such a text, the address of a global heap, and an index in this heap; see "Global Heap" in HDF5's file
// format specification.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "durable_file.hpp"
#include "hdf5_file.hpp"

namespace phynness::hdf5 {

/// Position of a text of variable length in a file.
struct TextPlace {
  std::uint32_t length = 0;
  std::uint64_t heap = 0;   ///< address in the file
  std::uint32_t index = 0;  ///< of an object in this heap
};

/// Bytes of such a position in an attribute or a dataset.
inline constexpr std::size_t text_place_bytes = 16;

/// More than any scene that is read (scene.cpp), with what HDF5 puts around it.
inline constexpr std::uint64_t most_text_bytes = 32 << 20;

/// A memory type for texts of variable length; reading into it gives the bytes of the text's position.
/// @return a handle, negative on failure
Handle text_place_type();
TextPlace text_place(const unsigned char (&bytes)[text_place_bytes]);

/// Reads the text after all addresses and sizes have been checked.
/// @param bytes_of_file  size of `file`
/// @param defect         output, what is wrong if the text cannot be read
/// @return false, with `defect` set, if the text cannot be read
bool read_text_at(const Descriptor& file, const std::filesystem::path& path, std::uint64_t bytes_of_file,
                  const TextPlace& place, std::string& text, std::string& defect);

}  // namespace phynness::hdf5
