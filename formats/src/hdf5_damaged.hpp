// What to do about a file that is not as it was written.
#pragma once

namespace phynness::hdf5 {

inline constexpr const char* damaged = "the file is damaged: restore it from a copy, or compute it again";

}  // namespace phynness::hdf5
