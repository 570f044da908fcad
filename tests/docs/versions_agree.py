#!/usr/bin/env python3
"""Claim: each file that is used without the rest (packages, CITATION.cff) has the version of CMakeLists.txt.

Usage: versions_agree.py SOURCES
"""
import json
import re
import sys
from pathlib import Path

sources = Path(sys.argv[1])


def found(file, pattern):
    return re.search(pattern, (sources / file).read_text(), re.MULTILINE).group(1)


version = found("CMakeLists.txt", r"project\(phynness VERSION (\S+)")
others = {file: found(file, r"project\(\w+ VERSION (\S+)") for file in ("runtime/CMakeLists.txt",)}
others |= {file: json.loads((sources / file).read_text())["version"] for file in ("web/package.json", "web/runtime/package.json")}
others["CITATION.cff"] = found("CITATION.cff", r"^version: (\S+)")
others["CHANGELOG.md"] = found("CHANGELOG.md", r"^## .*?(\d+\.\d+\.\d+)")
wrong = {file: other for file, other in others.items() if other != version}
sys.exit(f"the version is {version} in CMakeLists.txt, but {wrong}" if wrong else 0)
