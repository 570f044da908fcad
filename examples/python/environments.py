"""Tutorial: the force of a tool in many environments of a simulator: balls fall onto the organ, one in each environment.

Usage: python3 environments.py MODEL_DIR [N]          for example examples/model 4096
"""
import sys
import time
from typing import Tuple

import numpy as np
from numpy.typing import NDArray

import phynness

RADIUS, MASS, SPEED = 0.01, 0.02, 0.1  # m, kg, m/s
SUBSTEP, SUBSTEPS = 0.001, 20          # s of physics, and how many of them in a step of the environment


class Contact:
    """Balls against an organ. A ball holds the place that it touched first until it lets go: it does not slide."""

    def __init__(self, organ: phynness.Organ, n: int) -> None:
        self.organ = organ
        self.places = organ.nearest_batch(np.zeros((n, 3)))
        self.outward = np.zeros((n, 3))
        self.held = np.zeros(n, bool)

    def forces(self, centers: NDArray[np.float64]) -> Tuple[NDArray[np.float64], NDArray[np.int32]]:
        """Forces on the balls, (n, 3) [N], and statuses (n,). centers: (n, 3) [m], in the frame of the mesh."""
        free = np.flatnonzero(~self.held)
        found = self.organ.nearest_batch(centers[free])
        touches = (found["status"] >= 0) & (found["distance"] < RADIUS) & (found["distance"] > 0)
        new, found = free[touches], found[touches]
        self.places[new] = found
        self.outward[new] = (centers[new] - found["position"]) / found["distance"][:, None]
        self.held[new] = True
        d = centers - RADIUS * self.outward - self.places["position"]
        self.held &= (d * self.outward).sum(axis=1) < 0  # an organ does not pull a ball
        force, status = self.organ.hold_batch(self.places, np.where(self.held[:, None], d, 0))
        return np.where(self.held[:, None], -force, 0), np.where(self.held, status, 0)


def main() -> None:
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    organ = phynness.Organ(sys.argv[1])
    n = int(sys.argv[2]) if len(sys.argv) == 3 else 4096
    # Places that are seen from points far outside, and balls 1 mm above them; not those below the fixed part, where the
    # way to the nearest place leads through the body.
    numbers = np.random.default_rng(1)
    middle, size = organ.points.mean(axis=0), np.ptp(organ.points, axis=0).max()
    outside = numbers.normal(size=(2 * n, 3))
    outside = middle + 2 * size * outside / np.linalg.norm(outside, axis=1)[:, None]
    places = organ.nearest_batch(outside)
    outward = (outside - places["position"]) / places["distance"][:, None]
    x, v = places["position"] + (RADIUS + 0.001) * outward, -SPEED * outward
    above = np.flatnonzero(organ.nearest_batch(x)["distance"] > RADIUS)[:n]
    x, v, n = x[above], v[above], len(above)

    contact = Contact(organ, n)
    largest, warned, touched = 0.0, np.zeros(n, bool), np.zeros(n, bool)
    began = time.perf_counter()
    n_steps = 10
    for _ in range(n_steps):                 # a step of the environment: what an agent sees and does goes here
        for _ in range(SUBSTEPS):
            force, status = contact.forces(x)
            v += SUBSTEP / MASS * force
            x += SUBSTEP * v
            largest = max(largest, float(np.linalg.norm(force, axis=1).max()))
            touched |= contact.held
            warned |= status != 0
    took = (time.perf_counter() - began) / n_steps
    away = touched & ~contact.held
    print(f"{n} environments: {1000 * took:.0f} ms for a step of {SUBSTEPS} substeps")
    print(f"  {touched.sum()} balls touched, {away.sum()} left again, {warned.sum()} had a warning; largest force {largest:.2f} N")
    print(f"  speed after contact: {np.linalg.norm(v[away], axis=1).max(initial=0):.3f} m/s at most, {SPEED} m/s before")


if __name__ == "__main__":
    main()
