"""Tutorial: a probe that is pressed into a trained body: what it feels, how far to trust it, and where the body goes.

Usage: python3 press.py MODEL_DIR          for example examples/model
"""
import sys
import warnings
from typing import Tuple

import numpy as np
from numpy.typing import NDArray

import phynness


def press(model: phynness.Model, node: int, depth_m: float) -> Tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Forces (n, 3) [N] and their bounds (n,) [N] along z into the body, to a depth [m]."""
    d = np.zeros((100, 3))
    d[:, 2] = -np.linspace(0, depth_m, len(d))
    return model.force(node, d), model.bound(node, d)


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    model = phynness.Model(sys.argv[1])
    node = int(model.active_nodes[len(model.active_nodes) // 2])
    down = np.array([0, 0, -1.0])
    depth = 0.999 * float(model.trained_depth(node, down))
    print(f"{model.title}: node {node} is trained to {1000 * depth:.1f} mm")

    forces, bounds = press(model, node, depth)
    for i in (33, 66, 99):
        print(f"  {1000 * depth * i / 99:5.1f} mm: {np.linalg.norm(forces[i]):.3f} N, known to {1000 * bounds[i]:.1f} mN")

    # Beyond the range the answer is an extrapolation, and a warning says so.
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        model.force(node, 2 * depth * down)
    print("  beyond:", "warned" if any(issubclass(w.category, phynness.OutsideWarning) for w in caught) else "silent")

    # A second tool changes what the first one feels. A model of round tools answers one tool.
    above = model.output_points[list(model.output_nodes).index(node)] + [0.03, 0, 0]
    organ = phynness.Organ(model, max_tools=2)
    try:
        pair = organ.hold([node, organ.nearest(above)], [depth / 2 * down, depth / 2 * down])
    except phynness.Error as error:
        sys.exit(f"  two tools: {error}")
    alone = model.force(node, depth / 2 * down)
    print(f"  alone {np.linalg.norm(alone):.3f} N, beside another tool {np.linalg.norm(pair.forces[0]):.3f} N")
    print(f"  the surface moves by at most {1000 * np.linalg.norm(organ.deform(), axis=1).max():.1f} mm")


main()
