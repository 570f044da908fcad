"""The study of the paper as paper.json and as blocks of paper.html."""

import math

from figures import *  # noqa: F403


def in_bytes(n):
    return f"{n / 1e3:.0f} kB" if n < 1e6 else f"{n / 1e6:.1f} MB" if n < 1e9 else f"{n / 1e9:.2f} GB"


def in_seconds(s):
    return f"{s:.2g} s" if s < 100 else f"{s / 60:.0f} min" if s < 5400 else f"{s / 3600:.1f} h"


def in_microseconds(us):
    return f"{us:.2f} us" if us < 1000 else f"{us / 1e3:.2f} ms"


def rate(us):
    if not us > 0:
        return ""
    fps = 1e6 / us
    return f"{fps:.3g} fps" if fps < 1e4 else f"{fps / 1e3:.0f},000 fps" if fps < 1e6 else f"{fps / 1e6:.1f} million fps"


def summary(study):
    table, liver = [["", "paper", "ours", "our default family", "linear predictor"]], the(study, "3")
    if liver:
        nodes = liver["measured"]["nodes"]
        by_family, by_linear = (percent(median(over(nodes, of, "displacement"))) + " %" for of in ("ours", "linear"))
        for neurons in (100, 200, 300):
            def errors_at(error):
                values = [row[error] for node in nodes for row in node["by_neurons"] if row["x"] == neurons]
                return percent(median(values)) + " %" if values else "-"

            table.append([f"liver, Case 3: mean error of the displacement, {neurons} neurons (median of nodes)",
                          "between 2 and 3 %" if neurons != 200 else "", f"{errors_at('held_mean')}; fresh {errors_at('fresh_mean')}",
                          by_family, by_linear])
    for id, name, neurons in (("3", "liver", "87"), ("4", "drain", "63")):
        if case := the(study, id):
            ours, linear = (percent(median(over(case["measured"]["nodes"], of, "force_max"))) for of in ("ours", "linear"))
            table.append([f"{name}: neurons for forces within 10 %", neurons, needed_words(case["measured"], False),
                          f"largest error {ours} %, median node", f"{linear} %"])
    if liver and liver["measured"]["pairs"]:
        depths = [depth for pair in liver["measured"]["pairs"] for depth in pair["depths"]]
        paper, coupled, linear = (below(added(d[kind] for d in depths), 0.04) for kind in ("paper", "coupled", "linear"))
        table.append(["two tools: nodes off by less than 4 %", "the majority", f"{paper} %", f"{coupled} % (coupled)", f"{linear} %"])
    if liver and (times := liver.get("runtime")):
        us = lambda key: in_microseconds(times[key])
        table.append([f"deformation of the free nodes, {times['neurons']} neurons", "6.5 ms", us("deformation_us"), us("ours_deformation_us"), ""])
        table.append(["force", "1.5 us", us("force_us"), us("ours_force_us"), ""])
    return table


def table_1(study):
    def training(case):
        return mean([node["training_cpu_s"] for node in case["measured"]["nodes"]])

    def timed(words):
        return lambda c: words(c["runtime"]) if c.get("runtime") else "-"

    fact = lambda key: lambda c: str(c["facts"][key])
    kind = lambda c: "3D tetrahedra" if c["facts"]["corners"] == 4 else "triangular shell elements"
    numbers_of_a_pair, size_of_number = 9, 8
    rows = [
        ("machine", "Pentium 4, 3 GHz, 2 GB, one core", "the same", lambda c: study["machine"]),
        ("number of nodes", "739", "239", fact("nodes")),
        ("free nodes (touched and reconstructed)", "486", "181", fact("free_nodes")),
        ("type of element", "3D tetrahedra", "triangular shell elements", lambda c: f"{kind(c)} ({c['measured']['element']})"),
        ("number of elements", "2341", "436", fact("cells")),
        ("precomputation cases (rays)", "12636", "4706", lambda c: "{rays}; {increments} increments, {failed} of them without "
         "equilibrium".format(**c["facts"])),
        ("CPU time of the automated script", "15 s", "8 s",
         lambda c: in_seconds(c["facts"]["setup_s"]) if c["facts"]["setup_s"] > 0 else "not recorded"),
        ("data points, one network", "75660", "23520", lambda c: str(c["measured"]["data_points"])),
        ("neurons", "200", "100", timed(lambda t: str(t["neurons"]))),
        ("training samples", "5000", "5000", fact("samples")),
        ("CPU time to train a network, data extraction included", "280 s", "170 s",
         lambda c: in_seconds(training(c)) + " (and its force network)"),
        ("total pre-computation, data and training", "87 h", "18 h",
         lambda c: (lambda solve, train: f"{in_seconds(solve + train)} of one core: {in_seconds(solve)} of solving, {in_seconds(train)} "
                    "of training")(c["facts"]["solve_cpu_s"], training(c) * c["facts"]["networks"])),
        ("size of the data recorded", "8 GB", "6 GB", lambda c: in_bytes(c["facts"]["database_bytes"])),
        ("size of the data extracted for training", "501 MB", "170 MB", lambda c: in_bytes(
            c["facts"]["networks"] * c["facts"]["samples"] * numbers_of_a_pair * size_of_number) + ", never written"),
        ("size of the networks", "5.4 MB", "2.02 MB",
         lambda c: f"{in_bytes(c['facts']['model_bytes'])} as text; default family {in_bytes(c['facts']['ours_bytes'])}"),
        ("deformation of the free nodes", "6.5 ms (154 fps)", "2.9 ms (345 fps)", timed(
            lambda t: f"{in_microseconds(t['deformation_us'])} ({rate(t['deformation_us'])}); straight loop "
            f"{in_microseconds(t['deformation_plain_us'])}; default family {in_microseconds(t['ours_deformation_us'])}")),
        ("force", "1.5 us", "1.5 us", timed(lambda t: f"{in_microseconds(t['force_us'])} ({t['force_neurons']} neurons); default family "
                                            f"{in_microseconds(t['ours_force_us'])}")),
    ]
    columns = [the(study, "3"), the(study, "4")]
    ours = lambda case, of: of(case) if case else "not run"
    return [["parameter", "liver, paper", "liver, ours", "Penrose drain, paper", "Penrose drain, ours"]] + [
        [what, liver, ours(columns[0], of), drain, ours(columns[1], of)] for what, liver, drain, of in rows]


def table_2(study):
    table = [["level", "vertices, paper", "ours", "triangles, paper", "ours", "time, paper", "ours: networks",
              "at every vertex (the paper's way)", "default family"]]
    liver = the(study, "3")
    levels = liver["runtime"]["levels"] if liver and liver.get("runtime") else []
    for l, (vertices, triangles, seconds) in enumerate(PAPER_LEVELS):
        found = levels[l] if l < len(levels) else None
        ours = lambda key: str(found[key]) if found else "not run"
        table.append([str(l), str(vertices), ours("vertices"), str(triangles), ours("triangles"), f"{seconds:.5f} s", *(
            in_microseconds(found[key]) if found else "" for key in ("network_us", "every_vertex_us", "ours_us"))])
    return table


def mesh_picture(points, triangles):
    """Shaded triangles of a surface with their edges, as SVG, seen along the shortest axis of the body. There is one path for each of
    some shades, which keeps tens of thousands of triangles below a megabyte."""
    width, margin, n_shades = 4600, 60, 12  # tenths of a point, so that coordinates are integers
    low, high = ([f(p[k] for p in points) for k in range(3)] for f in (min, max))
    u, v, w = sorted(range(3), key=lambda a: low[a] - high[a])
    scale = (width - 2 * margin) / max(1e-300, high[u] - low[u])
    height = int(scale * (high[v] - low[v])) + 2 * margin
    rounded = lambda x: math.floor(x + 0.5)
    places = [(margin + rounded(scale * (p[u] - low[u])), height - margin - rounded(scale * (p[v] - low[v]))) for p in points]
    paths = [""] * n_shades
    for t in triangles:
        x, y, z = (points[i] for i in t)
        a, b = ([q[k] - x[k] for k in range(3)] for q in (y, z))
        normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        facing = normal[w] / max(1e-300, math.sqrt(sum(n * n for n in normal)))
        if facing > 0:
            p, q, r = (places[i] for i in t)
            paths[min(n_shades - 1, int(n_shades * facing))] += (
                f"M{p[0]} {p[1]}l{q[0] - p[0]} {q[1] - p[1]} {r[0] - q[0]} {r[1] - q[1]}z")
    # Lines are limited to a fifth of the mean edge length, because they would cover a fine mesh.
    line = min(8.0, 0.06 * width / math.sqrt(len(triangles)))
    grey = lambda s: 110 + 130 * s // (n_shades - 1)
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}">\n' + "".join(
        f'<path d="{path}" fill="#{grey(s) - 20:02x}{grey(s) - 10:02x}{grey(s):02x}" stroke="#234" stroke-width="{line:.1f}" '
        'stroke-linejoin="round"/>\n' for s, path in enumerate(paths)) + "</svg>"


def rounded(x):
    """Six digits, which is more than a picture shows."""
    if x == 0:
        return x
    unit = 10.0 ** (math.floor(math.log10(abs(x))) - 5)
    return math.copysign(math.floor(abs(x) / unit + 0.5), x) * unit


def drawn(of):
    curves = []
    for line in of["series"]:
        at = [(x, y) for x, y in zip(line["x"], line["y"]) if math.isfinite(x) and math.isfinite(y) and (y > 0 or not of["log_y"])]
        if at:
            curves.append({"title": line["name"], "mark": line["mark"], "color": line["color"], "x": [rounded(x) for x, _ in at],
                           "y": [rounded(y) for _, y in at]})
    limits = {"range": list(of["limits"])} if of["limits"] and of["limits"][1] > of["limits"][0] else {}
    return {"title": of["title"], "x": of["x"], "y": of["y"], "curves": curves, "log_x": of["log_x"], "log_y": of["log_y"], **limits}


def section(title, blocks):
    return {"title": title, "blocks": [block for block in blocks if block]}


def said(who, what):
    return {"text": f"{who} {what}"} if what else None


def words_table(rows):
    return {"table": rows, "words": True} if len(rows) > 1 else None


def figure_section(study, fig):
    blocks = [said("Paper:", fig["paper"])]
    if fig["panels"]:
        blocks.append({"charts": [drawn(of) for of in fig["panels"]]})
    liver = the(study, "3")
    if fig["number"] == "13" and liver and liver["surfaces"]:
        blocks.append({"pictures": [{"svg": mesh_picture(s["points"], s["triangles"]),
                                     "caption": f"Level {l}: {len(s['points'])} vertices, {len(s['triangles'])} triangles"}
                                    for l, s in enumerate(liver["surfaces"])]})
    blocks += [words_table(fig["table"]), said("This run:", fig["found"])]
    if fig["conditions"]:
        blocks.append({"remark": "Conditions: " + fig["conditions"]})
    return section(("Figure " if fig["number"].isdigit() else "") + f"{fig['number']}: {fig['title']}", blocks)


def validations(study):
    """Results of phynness validate for both models of a case."""
    rows = [["case, error % (17)", "model", "force: mean", "p95", "max", "displacement: mean", "p95", "beyond R: force", "displacement",
             "solved: inside, beyond"]]
    for case in ran(study):
        ours, networks = case["ours_errors"], case["networks_errors"]
        models = [("the paper's networks", networks)] if networks else []
        if ours:
            models += [(case["measured"]["ours"], ours), ("linear predictor", ours["linear"]), ("zero", ours["zero"])]
        solved = f"{ours['solved_inside']}, {ours['solved_outside']} of {ours['probes']}" if ours and "solved_inside" in ours else "-"
        for name, of in models:
            values = [of[group][what][statistic] for group, what, statistic in (
                ("inside", "force", "mean"), ("inside", "force", "p95"), ("inside", "force", "max"), ("inside", "displacement", "mean"),
                ("inside", "displacement", "p95"), ("outside", "force", "mean"), ("outside", "displacement", "mean"))]
            rows.append([title(case), name, *("-" if value is None else percent(value) for value in values), solved])
    return section("Whole models compared with new solves", [
        {"text": "Every free node has its networks. Probes are in random directions, half of them outside of the trained range (phynness "
         "validate). Errors are those of the probes with an equilibrium. The two trivial predictors are listed for comparison."},
        words_table(rows)]) if len(rows) > 1 else None


def what_ran(study):
    rows = [["case", "scene", "rays", "increments", "no equilibrium", "solving, CPU min"]]
    for case in study["cases"]:
        facts = case.get("facts")
        rows.append([title(case), case["of"]["scene"], *(
            [f"not run: {case['missing']}", "", "", ""] if case["missing"] else
            [str(facts["rays"]), str(facts["increments"]), str(facts["failed"]), f"{facts['solve_cpu_s'] / 60:.1f}"])])
    return section("Cases", [words_table(rows), {"remark": f"{study['software']}; {study['machine']}. This run took "
                                                 f"{study['seconds'] / 60:.1f} min; stages that were already finished were kept."}])


FIGURES = (figure_6, figure_7, figure_8, figure_9, figure_10, figure_11, figure_12, figure_13, figure_14, figure_15, figure_locking)
TABLE_1 = ("The 12,636 precomputation cases are rays, 486 nodes x 26 directions, and the 75,660 points belong to one network: 485 nodes x "
           "26 x 6. Table 1 gives 154 frames a second for 200 neurons, the paper's conclusions for 300. The number for the drain, 23,520 "
           "points, is not 180 x 26 x 6 = 28,080.")
TABLE_2 = ("The network is evaluated at every fine vertex. The column 'at every vertex' is this way, written as a plain loop, on our "
           "machine; ours evaluates the network at the nodes of the coarse mesh and subdivides the displacements. Loop's scheme gives V + E "
           "vertices and 4 F triangles a level.")
INTRODUCTION = ("D. Deo and S. De, PhyNNeSS (2011), Cases 1 to 4, computed anew. Errors are the paper's (17): the difference over the largest "
                "finite element response of the same node and group. Two predictors that the paper does not have are shown for comparison: "
                "the linear predictor, which uses three unit responses at rest, and the default family of this software (modal; linear for "
                "the linear case). Figures 1 to 5 of the paper have no measurements.")
ERRATA = ("(9) is printed with a minus sign, with which a positive C01 would soften; its II is tr(C^2). We use the usual nearly incompressible "
          "law.", "(12) sums to m but means the neurons. Algorithm 1 loops while the displacement is at most n times delta.",
          "(17) divides by the network's largest output; we divide by the finite elements'.",
          "Case 1's E = 20 is in kPa. D1 = 1e-5 per Pa is taken as K = 1/D1 = 100 kPa.",
          "The paper's mesh and shell thickness are not published.")


def report(study):
    """(contents of paper.json, sections of paper.html). study: study.json with what was measured of each case."""
    figures, tables = [make(study) for make in FIGURES], {"1": table_1(study), "2": table_2(study)}
    rows, liver = summary(study), the(study, "3")
    times = liver.get("runtime") if liver else None
    quick = study["less_than_full"]
    data = {"study": "paper", "quick": bool(quick), **{k: study[k] for k in ("software", "machine", "seconds")},
            **({"less_than_full": quick} if quick else {}), "summary": rows, "tables": tables, "figures": {}, "cases": {}}
    for fig in figures:
        data["figures"][fig["number"]] = {
            **{k: fig[k] for k in ("title", "conditions", "paper", "found")}, "table": fig["table"],
            "panels": [{**{k: p[k] for k in ("title", "x", "y")}, "series": [{k: s[k] for k in ("name", "x", "y")} for s in p["series"]]}
                       for p in fig["panels"]]}
    for case in study["cases"]:
        data["cases"][case["of"]["id"]] = {"title": title(case), **(
            {"not_run": case["missing"]} if case["missing"] else
            {"facts": case["facts"], "validate": {"networks": case["networks_errors"], "ours": case["ours_errors"]},
             "measured": case["measured"], **({"runtime": case["runtime"]} if case.get("runtime") else {})})}
    warning = {"warning": "Quick study, a check of all parts whose numbers should not be quoted: " + quick +
               ". Without --quick the study has the sizes of the paper."} if quick else None
    sections = [section("", [warning, {"text": INTRODUCTION}]),
                section("The paper's numbers and ours", [words_table(rows)]) if len(rows) > 1 else None, what_ran(study),
                section("Table 1: model data", [said("Paper:", TABLE_1), words_table(tables["1"]),
                                                said("This run:", plain_loop_against_ours(times) if times else "")]),
                validations(study)]
    for fig in figures:
        if fig["number"] == "13":
            sections.append(section("Table 2: successive subdivision", [said("Paper:", TABLE_2), words_table(tables["2"]),
                                                                        said("This run:", finest_level(times) if times else "")]))
        sections.append(figure_section(study, fig))
    sections.append(section("Errata of the paper that matter here", [{"text": text} for text in ERRATA]))
    return data, [of for of in sections if of]
