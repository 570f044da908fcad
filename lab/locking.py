"""How much too large the forces of elements are: those of round tools over those of Taylor-Hood on the same mesh.

Usage: lab/study locking FOLDER SCENE ...     databases in FOLDER are used again

A scene gives mesh, fixed nodes and tool radius r. Five places farther than r from fixed nodes move along x, y and z to
0.45 r in seven increments. For each element and K/mu the ratio of the sums of |f| at the first and at the last increment
is printed, as the geometric mean over the scenes, and the smallest and largest ratio of a single force. The table of
docs/theory.md is of scenes/demo.toml, lab/gallbladder.toml, and a pancreas (r = 18 mm) and a left kidney (r = 21 mm) of
OpenHELP, of which the least fifth of x is fixed; its figures are the geometric means of first and last.
"""

import pathlib
import re
import sys

import h5py
import numpy as np
from commands import run

MU_PA, RATIOS = 500.0, (2, 10, 50, 200)
ELEMENTS = ("taylor-hood", "P1", "P2", "p1-p1", "es-p1-p1")  # the first is the reference
INCREMENTS = 7


def varied(scene, element, ratio):
    """The scene with this element and K/mu, five places, three directions and depths to about an edge."""
    text = re.sub(r"\n\[(validation|training)\][^\[]*", "\n", scene.read_text())
    radius = float(re.search(r"^tool_radius_m *= *(\S+)", text, re.M)[1])
    text = re.sub(r'^file *= *"(.+)"', lambda m: f'file = "{(scene.parent / m[1]).resolve()}"', text, flags=re.M)
    text = re.sub(r"^(c10_Pa|shear_modulus_Pa|bulk_modulus_Pa|tools|elsewhere) *=.*\n", "", text, flags=re.M)
    text = re.sub(r"^active *=.*?(?=^output)", f"active = {{ count = 5, from_fixed_m = {radius} }}\n", text, flags=re.M | re.S)
    for key, value in (("target_nodes", 300), ("element", f'"{element}"'), ("directions", 3), ("increments", INCREMENTS),
                       ("max_displacement_m", radius / 2.2)):
        text = re.sub(rf"^{key} *=.*$", f"{key} = {value}", text, flags=re.M)
    text = text.replace("[material]\n", f"[material]\nshear_modulus_Pa = {MU_PA}\nbulk_modulus_Pa = {ratio * MU_PA}\n")
    return text.replace("[probe]\n", '[probe]\nelsewhere = "none"\n')


def forces(folder, scene, element, ratio):
    """|f| [N] of each place, direction and increment; NaN where a solve did not converge."""
    made = folder / f"{scene.stem}_{element}_{ratio}"
    if not made.with_suffix(".h5").exists():
        made.with_suffix(".toml").write_text(varied(scene, element, ratio))
        run("precompute", made.with_suffix(".toml"), "-o", made.with_suffix(".h5"))
    with h5py.File(made.with_suffix(".h5")) as database:
        responses = database["responses"]
        converged = responses["status"][:] == 0
        return np.where(converged, np.linalg.norm(responses["force"][:], axis=-1), np.nan)


def main(folder, *scenes):
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    print("K/mu  element    first  last  single forces")
    for ratio in RATIOS:
        for element in ELEMENTS[1:]:
            logs, single = [], []
            for scene in map(pathlib.Path, scenes):
                f, of_reference = (forces(folder, scene, e, ratio)[:, :, [0, -1]] for e in (element, ELEMENTS[0]))
                known = np.isfinite(f) & np.isfinite(of_reference)
                sums = [np.sum(x, axis=(0, 1), where=known) for x in (f, of_reference)]
                logs.append(np.log(sums[0] / sums[1]))
                single += list((f / of_reference)[known])
            first, last = np.exp(np.mean(logs, axis=0))
            print(f"{ratio:4}  {element:9}  {first:5.3f} {last:5.3f}  {min(single):.2f} to {max(single):.2f}", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 3 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    main(*sys.argv[1:])
