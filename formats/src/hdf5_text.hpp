// Texts of variable length, read without HDF5's code for them (hdf5_heapless_driver.hpp says why). What is
// stored for such a text is its length, the address of a global heap and an index into that; see
// "Global Heap" in HDF5's file format specification.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "durable_file.hpp"
#include "hdf5_file.hpp"

namespace phynness::hdf5 {

/// Where a file keeps a text of variable length.
struct TextPlace {
  std::uint32_t length = 0;
  std::uint64_t heap = 0;   ///< address in the file
  std::uint32_t index = 0;  ///< of an object of that heap
};

/// The bytes that stand for one such text in an attribute or a dataset.
inline constexpr std::size_t text_place_bytes = 16;

/// More than any scene that is read (scene.cpp), with what HDF5 puts around it.
inline constexpr std::uint64_t most_text_bytes = 32 << 20;

/// A memory type: reading a text of variable length into it gives the bytes of its place.
/// @returns a handle that is negative if HDF5 refuses
Handle text_place_type();
TextPlace text_place(const unsigned char (&bytes)[text_place_bytes]);

/// Reads the text, after everything that leads to it has been checked against the file.
/// @param bytes_of_file  of `file`
/// @param defect         what is wrong, if the text cannot be had
/// @returns false with `defect` set
bool read_text_at(const Descriptor& file, const std::filesystem::path& path, std::uint64_t bytes_of_file,
                  const TextPlace& place, std::string& text, std::string& defect);

}  // namespace phynness::hdf5
