// A valid scene.
#pragma once

#include <string>

namespace phynness::test {

// The lines that the tests replace stand alone, so that the number of each is known: see line_of.
inline const std::string good_scene = R"(title = "test"
[mesh]
shape = "block"
[material]
law = "neo-hookean"
shear_modulus_Pa = 500.0
bulk_modulus_Pa = 5000.0
[solver]
element = "P1"
[nodes]
fixed = { box = { min_fraction = [0, 0, 0], max_fraction = [0.2, 1, 1] } }
active = "free-surface"
[probe]
directions = 26
increments = 4
max_displacement_m = 0.02
[training]
family = "rbfn"
samples = 1000
)";

}  // namespace phynness::test
