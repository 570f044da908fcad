"""Claim: the recipe "Add a material" of CONTRIBUTING.md holds: in a copy of laws/ and precompute_dolfinx/forms one new file is
enough for the tables, the parser, the hash, the page of keys and, where UFL is there, the forms.

Usage: recipe_in_a_scratch_copy.py SOURCE COMPILER EIGEN FORMATS_LIBRARY [PYTHON_WITH_UFL]
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

# Demiray 1972, doi 10.1016/0021-9290(72)90047-4: soft tissue that stiffens exponentially.
LAW = '''"""W = mu / (2 b) (exp(b (I1bar - 3)) - 1) + K/2 (J - 1)^2."""

from law import BULK, Quantity, det, exp, ln, modulus, tr

name = "demiray"
parameters = (modulus("mu", "shear_modulus_Pa", "mu"), Quantity("b", "stiffening", "b", high=100, low_open=True), BULK)
kappa = "K"
formulas = {"shape": "mu / (2 b) (exp(b (I1bar - 3)) - 1)", "volumetric": "J - 1", "equation": "Demiray 1972"}


def shear_modulus(mu):
    return mu


def bulk_modulus(K):
    return K


def example(K):
    return {"mu": 1.0, "b": 0.5, "K": K}


def shape(F, mu, b):
    return mu / (2 * b) * (exp(b * (exp(-2 / 3 * ln(det(F))) * tr(F.T * F) - 3)) - 1)


def volumetric(F):
    return det(F) - 1
'''

PROGRAM = r"""
#include <cstdio>
#include <phynness/formats/scene.hpp>
int main(int, char** arguments) {
  try {
    std::fputs(phynness::physics_summary(phynness::parse_scene(arguments[1], "recipe.toml", ".")).c_str(), stdout);
  } catch (const std::exception& error) {
    std::puts(error.what());
  }
}
"""

SCENE = """[mesh]
shape = "block"
[material]
law = "demiray"
shear_modulus_Pa = 500
stiffening = 0.7
d1_per_Pa = 2e-4
[nodes]
fixed = { nodes = [0] }
[probe]
max_displacement_m = 0.01
"""


# What a law file may have wrong: (text, replacement, words of the message).
WRONG_LAWS = [
    ("exp(-2 / 3 * ln(det(F)))", "det(F) ** (-2 / 3)", ["demiray.py:24", "shape", "-0.66", "exp(a * ln(x))"]),
    ("import BULK, ", "import BULK, cos, ", ["demiray.py:3", "cos", "laws/tables/law.py"]),
    ("def shape(F, mu, b):", "def shape(F, mu, b):\n    return F @ F", ["demiray.py:24", "shape", "@"]),
    ('Quantity("b", "stiffening", "b", high=100', 'Quantity("b", "poisson_ratio", "nu", high=0.5',
     ["poisson_ratio", "demiray.py", "linear.py", "hooke.py"]),
]  # fmt: skip


def run(*command, status=0, **options):
    done = subprocess.run([str(c) for c in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options)
    assert done.returncode == status, f"{command}\n{done.stdout}"
    return done.stdout


def expect(text, words):
    for word in words:
        assert word in text, f"no {word!r} in\n{text}"


def main(source, compiler, eigen, libraries, python_with_ufl=None):
    source = Path(source)
    with tempfile.TemporaryDirectory() as temporary:
        copy = Path(temporary)
        for folder in ("precompute_dolfinx/forms", "laws"):
            shutil.copytree(source / folder, copy / folder)
        for page in ("formats/scene.md", "docs/theory.md"):
            (copy / page).parent.mkdir(exist_ok=True)
            shutil.copy(source / page, copy / page)
        (copy / "laws" / "demiray.py").write_text(LAW)
        tables, forms = copy / "laws" / "tables", copy / "precompute_dolfinx" / "forms"

        listed = run(sys.executable, tables / "tables.py", copy / "made")
        expect(listed, ["demiray", "mooney_rivlin"])
        expect((copy / "made" / "compiled_forms.cpp").read_text(), ["form_demiray_p1p1_tangent"])
        expect((copy / "made" / "declared_laws.cpp").read_text(), ["energy_of_demiray"])

        # Its own table comes first: the library's is then left out by the linker.
        (copy / "main.cpp").write_text(PROGRAM)
        run(compiler, "-std=c++20", "-I", source / "formats" / "include", "-I", source / "runtime" / "include", "-isystem", eigen, copy / "main.cpp", copy / "made" / "tables.cpp",
            *libraries.split(), "-o", copy / "recipe")  # fmt: skip
        # K = 1 / D1, and every parameter is in what the hash is made of.
        expect(run(copy / "recipe", SCENE), [
            "material.law = demiray\nmaterial.shear_modulus_Pa = 500\nmaterial.stiffening = 0.7\nmaterial.bulk_modulus_Pa = 5000\n",
        ])  # fmt: skip
        expect(run(copy / "recipe", SCENE.replace("stiffening = 0.7", "stiffenin = 0.7")), ["did you mean stiffening?"])
        expect(run(copy / "recipe", SCENE.replace("= 0.7", "= 700")), ["recipe.toml:6", "stiffening", "700"])

        run(sys.executable, tables / "doc_tables.py", "--write", cwd=copy)
        assert run(sys.executable, tables / "doc_tables.py", cwd=copy) == ""
        expect((copy / "formats" / "scene.md").read_text(), ["| `stiffening` | number | > 0; b no unit |"])

        if python_with_ufl:
            # Of each element of tetrahedra energy, residual, tangent, the fields, and J.
            made = run(python_with_ufl, "-c", "import sys, runpy; names = runpy.run_path(sys.argv[1]);"
                       "print(len(names['forms']), len(names['expressions']))",
                       copy / "made" / "forms" / "demiray.py",
                       env={**os.environ, "PYTHONPATH": f"{forms}:{tables}", "PYTHONDONTWRITEBYTECODE": "1"})  # fmt: skip
            sys.path.insert(0, str(tables))
            from element_table import FIELDS, JACOBIANS, SOLIDS

            expect(made, [f"{len(SOLIDS) * (3 + len(FIELDS)) + 3} {len(JACOBIANS)}"])

        for text, replacement, words in WRONG_LAWS:
            assert text in LAW
            (copy / "laws" / "demiray.py").write_text(LAW.replace(text, replacement))
            message = run(sys.executable, tables / "tables.py", copy / "wrong", status=1)
            expect(message, words)
            assert "Traceback" not in message, message


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    main(*sys.argv[1:])
