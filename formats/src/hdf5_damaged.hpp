// The remedy for damaged files.
#pragma once

namespace phynness::hdf5 {

inline constexpr const char* damaged = "the file is damaged: restore it from a copy, or compute the database again";

}  // namespace phynness::hdf5
