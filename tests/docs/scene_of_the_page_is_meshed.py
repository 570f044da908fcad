"""Claim: the scene that docs/howto/own-organ.md makes of scenes/demo.toml, by the first diff in it, is meshed with nothing to
warn of, and the lines that the diff takes away are in the demo.

Usage: scene_of_the_page_is_meshed.py SOURCE PHYNNESS
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path


def main(source, phynness):
    source = Path(source)
    block = re.search(r"^```diff\n(.*?)^```$", (source / "docs/howto/own-organ.md").read_text(), re.M | re.S)[1]
    removed = [line[1:] for line in block.splitlines() if line.startswith("-")]
    added = [line[1:] for line in block.splitlines() if line.startswith("+")]
    scene = (source / "scenes" / "demo.toml").read_text()
    old = "\n".join(removed) + "\n"
    assert old in scene, f"scenes/demo.toml has no lines\n{old}"
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "tests").symlink_to(source / "tests")  # the path in the scene starts at the scene's folder
        (folder / "organ.toml").write_text(scene.replace(old, "\n".join(added) + "\n"))
        done = subprocess.run([phynness, "mesh", "organ.toml", "-o", "mesh.msh"], cwd=folder, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)  # fmt: skip
        print(done.stdout, done.stderr)
        assert done.returncode == 0
        assert "warning: " not in done.stderr


if __name__ == "__main__":
    main(*sys.argv[1:])
