"""Draws the table of `phynness check SCENE --trade --json FILE`: error against core-hours, with the rows that no other
row beats in both.

Usage: lab/study trade FILE.json ... -o OUT.svg     one panel for each file; needs gnuplot
"""
import argparse
import json
import subprocess

COLORS = {"P1": "#000000", "P2": "#0072b2", "taylor-hood": "#009e73", "p1-p1": "#e69f00", "es-p1-p1": "#d55e00"}


def rows_of(path):
    with open(path, encoding="utf-8") as file:
        rows = json.load(file)["rows"]
    return [row for row in rows if row["mean"] is not None]


def block(rows):
    """A data block of gnuplot: core-hours, error in %, nodes."""
    lines = [f"{row['core_hours']!r} {100 * row['mean']!r} {row['nodes']}" for row in rows]
    return "\n".join(lines) + "\nEOD\n"


def panel(k, path):
    """The data of a panel, and the lines that draw it."""
    rows = rows_of(path)
    front = sorted((row for row in rows if row["on_front"]), key=lambda row: row["core_hours"])
    data = f"$front{k} << EOD\n" + block(front)
    curves = [f"$front{k} using 1:2 with lines lw 1.5 dt 2 lc rgb '#555555' title 'Pareto front'"]
    for i, (element, color) in enumerate(COLORS.items()):
        own = [row for row in rows if row["element"] == element]
        if not own:
            continue
        data += f"$e{k}_{i} << EOD\n" + block(own)
        curves.append(f"$e{k}_{i} using 1:2 with points pt 7 ps 0.7 lc rgb '{color}' title '{element}'")
        curves.append(f"$e{k}_{i} using 1:2:3 with labels font ',9' offset 0,0.7 notitle")
    title = path.rsplit("/", 1)[-1].removesuffix(".json")
    return data, f"set title '{title}' noenhanced\nplot " + ", \\\n  ".join(curves) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+")
    parser.add_argument("-o", "--output", required=True)
    given = parser.parse_args()
    n = len(given.files)
    columns, rows = min(n, 2), -(-n // 2)
    data, plots = zip(*(panel(k, path) for k, path in enumerate(given.files)))
    program = "".join(data) + f"""set terminal svg size {500 * columns},{430 * rows} font 'sans-serif,12' background 'white'
set output '{given.output}'
set multiplot layout {rows},{columns}
set logscale xy
set xlabel 'core-hours of the database'
set ylabel 'mean error of the force (%)'
set bmargin 8
set key below noenhanced
set grid lc rgb '#dddddd'
"""
    program += "".join(plots) + "unset multiplot\n"
    subprocess.run(["gnuplot", "-d"], input=program, text=True, check=True)


if __name__ == "__main__":
    main()
