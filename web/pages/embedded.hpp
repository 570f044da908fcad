// The page of `phynness view`, which web/build.mjs writes into a C++ source.
#pragma once

namespace phynness {

extern const char* const embedded_page_chunks[];  ///< parts of the text in order; nullptr ends the list

}  // namespace phynness
