"""Generates the tables of laws and elements in the documentation from the law files and element_table.py. Needs Python's standard library only.

Usage: doc_tables.py [--write]     from the root of the repository; called by tools/check-docs

A table is between <!-- laws: KIND --> and <!-- laws: end -->, where KIND is a key of TABLES. Without --write the script
prints "file:line: what" for every table that is not up to date, and exits with 1 if there is one.
"""

import re
import sys
from pathlib import Path

from element_table import ELEMENTS
from law import D1, LawError, every_law

FILES = ("formats/scene.md", "docs/theory.md")


def _text_of(law, symbol):
    return next(p.text for p in law.parameters if p.symbol == symbol)


def _range(quantity):
    if quantity.meaning:
        return quantity.meaning
    unit = "in Pa" if quantity.is_modulus else "no unit"
    return f"{'>' if quantity.low_open else '>='} {quantity.low:g}; {quantity.text} {unit}"


def keys(laws):
    names = [f'`"{law.name}"`' for law in laws]
    hooke_first = sorted(laws, key=lambda law: law.finite)
    quantities = {q.key: q for law in hooke_first for accepted in law.accepted for q in accepted.given}
    return [
        "| key | type | range, meaning |",
        "|---|---|---|",
        f"| `law` | text | required: {', '.join(names[:-1])} or {names[-1]} |",
        *(f"| `{key}` | number | {_range(q)} |" for key, q in quantities.items()),
    ]


def sets(laws):
    rows = ["| law | sets (K stands for `bulk_modulus_Pa` or `d1_per_Pa`) |", "|---|---|"]
    for law in laws:
        texts = [[q.text for q in a.given] for a in law.accepted if D1 not in a.given]
        given = "; ".join(" and ".join(filter(None, (", ".join(t[:-1]), t[-1]))) for t in texts)
        rows.append(f"| {law.name} | {given} |")
    return rows


def energies(laws):
    rows = ["| `law` | shape(F) | g(F) | kappa | equation | file |", "|---|---|---|---|---|---|"]
    for law in laws:
        f = law.formulas
        rows.append(f"| `{law.name}` | {f['shape']} | {f['volumetric']} | {_text_of(law, law.kappa)} | {f['equation']} | "
                    f"`laws/{law.identifier}.py` |")  # fmt: skip
    return rows


def ratios(_):
    locking = [element for element in ELEMENTS if element.force_ratios]
    heads = [f"{element.name}, {probe}" for element in locking for probe in ("patch", "node")]
    rows = [f"| K/mu | {' | '.join(heads)} |", "|---" * (1 + len(heads)) + "|"]
    for of_elements in zip(*(element.force_ratios for element in locking)):
        cells = [of_elements[0][0], *(x for row in of_elements for x in row[1:])]
        rows.append("| " + " | ".join(f"{x:g}" for x in cells) + " |")
    return rows


TABLES = {"keys": keys, "sets": sets, "energies": energies, "ratios": ratios}


def main(write):
    laws, stale = every_law(), 0
    for file in map(Path, FILES):
        text = file.read_text()

        def renewed(match):
            return f"{match[1]}\n\n" + "\n".join(TABLES[match[2]](laws)) + f"\n\n{match[4]}"

        pattern = re.compile(r"(<!-- laws: (\w+) -->)\n(.*?)\n(<!-- laws: end -->)", re.S)
        if not pattern.search(text):
            stale += 1
            print(f"{file}:1: there is no table of laws; insert <!-- laws: KIND --> and <!-- laws: end -->")
        for match in pattern.finditer(text):
            if renewed(match) != match[0] and not write:
                stale += 1
                line = text[: match.start()].count("\n") + 1
                print(f"{file}:{line}: the table of laws ({match[2]}) is not up to date; run tools/check-docs --write")
        if write:
            file.write_text(pattern.sub(renewed, text))
    return 1 if stale and not write else 0


if __name__ == "__main__":
    try:
        sys.exit(main("--write" in sys.argv[1:]))
    except LawError as error:
        print(error)
        sys.exit(1)
