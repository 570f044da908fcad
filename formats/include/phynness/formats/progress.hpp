// How work that takes long tells of itself and is ended.
#pragma once

#include <cstdint>
#include <functional>

namespace phynness {

using OnProgress = std::function<void(std::int64_t, std::int64_t)>;  ///< receives what is done, and of how much
using ShouldStop = std::function<bool()>;                            ///< asked between steps; true ends the work early

}  // namespace phynness
