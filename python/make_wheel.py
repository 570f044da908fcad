"""Makes a wheel of the Python package, as a build backend of pip (PEP 517): builds the runtime and its bindings, and packs them.

Needs CMake, a compiler, pybind11 and the headers of Python (tools/install-deps --python); nothing is downloaded.
"""
import base64
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent


def pack(package, folder):
    """A wheel of the folder `package` for this interpreter, in `folder`; its name."""
    version = re.search(r"project\(phynness VERSION ([0-9.]+)", (HERE.parent / "CMakeLists.txt").read_text())[1]
    number, platform = "%d%d" % sys.version_info[:2], sysconfig.get_platform().replace("-", "_").replace(".", "_")
    tag = f"cp{number}-cp{number}-{platform}"
    info = f"phynness-{version}.dist-info"
    contents = {f"phynness/{file.name}": file.read_bytes() for file in sorted(package.iterdir()) if file.is_file()}
    contents[f"{info}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: phynness\nVersion: {version}\nLicense: MIT\nRequires-Python: >=3.{number[1:]}\n"
        "Requires-Dist: numpy\nSummary: Forces and deformations of trained soft bodies\n").encode()
    contents[f"{info}/LICENSE"] = (HERE.parent / "LICENSE").read_bytes()
    contents[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: make_wheel\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    record = ""
    for name, data in contents.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(data)}\n"
    contents[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    wheel = folder / f"phynness-{version}-{tag}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in contents.items():
            archive.writestr(zipfile.ZipInfo(name, (2000, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)
    return wheel.name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    with tempfile.TemporaryDirectory(prefix="phynness-wheel-") as build:
        options = [f"-DPHYNNESS_SYSTEM_PYTHON={sys.executable}", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON"]
        subprocess.run(["cmake", "-S", HERE, "-B", build, *options], check=True)
        subprocess.run(["cmake", "--build", build, "--target", "phynness_python", "--parallel", str(os.cpu_count())], check=True)
        return pack(Path(build) / "phynness", Path(wheel_directory))
