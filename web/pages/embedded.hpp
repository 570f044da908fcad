// Files that web/build.mjs writes into a C++ source.
#pragma once

namespace phynness {

struct EmbeddedFile {
  const char* name;           ///< nullptr ends the list
  const char* const* chunks;  ///< parts of the text in order; nullptr ends the list
};
extern const EmbeddedFile embedded_files[];

}  // namespace phynness
