"""The figures of the paper with the measurements of a run: titles, panels of lines, and tables."""

from findings import *  # noqa: F403

PAPER_LEVELS = [(596, 1188, 0.00936), (2378, 4752, 0.03748), (9506, 19008, 0.15), (38018, 76032, 0.5994)]  # Table 2


def curve_error(said, curves, measured):
    """Mean |prediction - finite elements| over the largest finite element force, to R and beyond; None where the finite elements
    found no equilibrium. With it, whether there is an equilibrium at every depth."""
    points, factor = measured["sizes"]["curve_points"], measured["outside_factor"]
    to_range = int(points / factor + 1e-9)
    for inside, needed in ((True, to_range), (False, points - to_range)):
        rows = [(s, f) for s, f, depth in zip(said, curves["finite_elements"], curves["depth_m"])
                if (depth <= measured["range_m"] * (1 + 1e-9)) == inside]
        top = largest([abs(f) for _, f in rows])
        yield sum(abs(s - f) for s, f in rows) / (len(rows) * top) if rows and top > 0 else None, len(rows) >= needed


def median_of_those(errors):
    """Median of the nodes with a number, with the number of nodes that have a number for every depth."""
    known, whole = [e for e, _ in errors if e is not None], sum(w for _, w in errors)
    if not known:
        return "no equilibrium"
    return percent(median(known)) + ("" if whole == len(errors) else f" ({whole} of {len(errors)} whole)")


def scaled(values, factor):
    return [factor * v for v in values]


def curve_panel(case, node):
    c, measured = node["curves"], case["measured"]
    # Forces are drawn in mN, or in uN if they are always below 0.1 mN.
    label, unit = ("force, uN", 1e6) if largest(map(abs, c["finite_elements"])) < 1e-4 else ("force, mN", 1e3)
    x, solved = scaled(c["depth_m"], 1e3), scaled(c["finite_elements"], unit)
    top, bottom, at = max([0.0, *solved]), min([0.0, *solved]), 1e3 * measured["range_m"]
    beside = " (beside fixed)" if node["beside_fixed"] else ""
    return panel(f"{title(case)}, node {node['node']}{beside}", "depth, mm", label, [
        series("finite elements", "points", 2, x, solved),
        *(series(f"{neurons} neurons", "line", (5, 3, 0)[n % 3], x, scaled(values, unit))
          for n, (neurons, values) in enumerate(zip(measured["sizes"]["curve_neurons"], c["networks"]))),
        series(measured["ours"], "dashes", 6, x, scaled(c["ours"], unit)),
        series("linear predictor", "dashes", 1, x, scaled(c["linear"], unit)),
        series("trained to", "dotted", 7, [at, at], [bottom, top]),
    ], limits=(bottom - 0.25 * (top - bottom), top + 0.5 * (top - bottom)))  # networks can have very large errors


def figure_6(study):
    fig = figure("6", "Force against depth, beyond the calibrated range", "With training to 2.8 cm, predictions to 4 cm compare well "
                 "with finite elements in Cases 1 to 3, better with more neurons, but for Case 2, where 100 are worse than 75.", head=[
                     "case; mean error % (17) along the curve, median of nodes", "50 neurons: to R", "beyond", "75: to R", "beyond",
                     "100: to R", "beyond", "our family: to R", "beyond", "linear: to R", "beyond"])
    said, cases = [], ran(study)
    for case in cases:
        fig["conditions"] += conditions(case) + ". "
        measured, nodes = case["measured"], case["measured"]["nodes"]
        for beside in (False, True):
            node = next((n for n in nodes if n["beside_fixed"] == beside), None)
            if node and node["curves"]["depth_m"]:
                fig["panels"].append(curve_panel(case, node))
        row, to_range = [title(case)], []
        for of in (*(lambda c, n=n: c["networks"][n] if n < len(c["networks"]) else [] for n in range(3)),
                   lambda c: c["ours"], lambda c: c["linear"]):
            inside, beyond = zip(*(curve_error(of(node["curves"]), node["curves"], measured) for node in nodes)) if nodes else ((), ())
            known = [e for e, _ in inside if e is not None]
            to_range.append(median(known) if known else None)
            row += [median_of_those(inside), median_of_those(beyond)]
        fig["table"].append(row)
        sizes = measured["sizes"]["curve_neurons"]
        last = [to_range[n] if n < len(to_range) else None for n in (len(sizes) - 1, len(sizes) - 2)] if len(sizes) > 1 else [None]
        if None not in last:
            said.append((title(case), against(f"{sizes[-1]} neurons", last[0], f"{sizes[-2]} neurons", last[1])))
    fig["found"] = finding("Mean error to R, median of nodes", said)
    if cases:
        m = cases[0]["measured"]
        fig["conditions"] += (
            f"Force along the inward normal, trained on all increments; {m['sizes']['curve_points']} points to "
            f"{1e3 * m['outside_factor'] * m['range_m']:.1f} mm. Drawn: a node beside the fixed nodes and another node. Table: the "
            "median of the nodes, each up to its last equilibrium (whole: at all depths). The three solves per node of Case 1 are "
            "superposed to the 26 directions, because networks need points.")
    return fig


def force_panel(case, y, curves, levels):
    nodes = case["measured"]["nodes"]
    lines = [over_nodes(nodes, curve, error, combine, name, color) for name, color, curve, error, combine in curves]
    return panel(title(case), "neurons", y, lines + [level(*of, lines[-1]) for of in levels], log_y=True)


def figure_11(study):
    cases = ran(study, networks_only=True)
    fig = figure("11", "Mean error of the force against neurons", "100 pairs for training and 30 others for the test; the error falls "
                 "with neurons (no number in the text).", "".join(conditions(case) + ". " for case in cases),
                 fresh_against_held(cases, "force_as_paper", "force"), [
                     "case", "neurons asked for", "trained, median: as the paper, on all",
                     "as the paper: mean %, median of nodes (range)", "the same, fresh", "trained on all: fresh", "beyond R"])
    fig["conditions"] += ("Lines: the median over the nodes of each node's mean. 'All': trained on every increment. Training ends if "
                          "further neurons would depend linearly on the present ones. ")
    for case in cases:
        measured, nodes = case["measured"], case["measured"]["nodes"]
        fig["conditions"] += f"Spread {measured['force_spread']:.2f}, found by search. "
        fig["panels"].append(force_panel(case, "mean relative error, %", [
            ("networks, as the paper", 0, "force_as_paper", "held_mean", median), ("fresh", 4, "force_as_paper", "fresh_mean", median),
            ("all increments, fresh", 3, "force_all", "fresh_mean", median),
        ], [("linear predictor, fresh", "dashes", 1, 100 * median(over(nodes, "linear", "force"))),
            (measured["ours"] + ", fresh", "dashes", 6, 100 * median(over(nodes, "ours", "force")))]))
        for asked in measured["sizes"]["force_neurons"]:
            of = lambda curve, key: [row[key] for node in nodes for row in node[curve] if int(row["x"]) == asked]
            errors = lambda curve, key: spread(of(curve, key)) if of(curve, key) else "-"
            if asked % 10 == 0 and of("force_all", "x"):
                fig["table"].append([title(case), str(asked), ", ".join(f"{median(of(c, 'neurons')):g}" for c in ("force_as_paper", "force_all")),
                                     errors("force_as_paper", "held_mean"), errors("force_as_paper", "fresh_mean"),
                                     errors("force_all", "fresh_mean"), errors("force_all", "beyond_mean")])
    return fig


def figure_12(study):
    cases = ran(study, networks_only=True)
    fig = figure("12", "Largest error of the force against neurons, and the just noticeable difference", "The largest error is below "
                 "the just noticeable difference, 10 %, with 87 neurons for the liver and 63 for the drain.",
                 "".join(conditions(case) + ". " for case in cases), never_enough(cases), [
                     "case", "neurons needed, as the paper: median of nodes", "range", "never (of nodes)",
                     "trained on all, fresh: median", "range", "never", "largest error of our family %: median of nodes", "worst node",
                     "linear predictor, worst node"])
    for case in cases:
        measured, nodes = case["measured"], case["measured"]["nodes"]
        ours, linear = over(nodes, "ours", "force_max"), over(nodes, "linear", "force_max")
        fig["panels"].append(force_panel(case, "largest relative error, %", [
            ("as the paper, median node", 0, "force_as_paper", "held_max", median),
            ("as the paper, worst node", 5, "force_as_paper", "held_max", largest),
            ("all increments, fresh, median", 3, "force_all", "fresh_max", median),
        ], [("just noticeable", "dotted", 2, 100 * NOTICEABLE), (measured["ours"] + ", fresh, median", "dashes", 6, 100 * median(ours))]))
        row = [title(case)]
        for fresh in (False, True):
            found = [n for n in neurons_needed(measured, fresh) if n > 0]
            row += [needed_words(measured, fresh), f"{min(found):g} to {max(found):g}" if found else "none",
                    f"{len(nodes) - len(found)} of {len(nodes)}"]
        fig["table"].append(row + [percent(median(ours)), percent(largest(ours)), percent(largest(linear))])
    return fig


def test_words(case):
    sizes = case["measured"]["sizes"]
    return (f" Each network is trained on {sizes['training_pairs']} pairs of one node. 'As the paper': {sizes['test_pairs']} other pairs "
            f"of the same database, with the same 26 directions. 'Fresh': {sizes['probes_per_node']} new solves per node in random "
            "directions and depths, at all output nodes. Lines: the median over the nodes of the mean of each node.")


def studied(study):
    """Cases whose deformation networks are studied, in the order of the paper, and their conditions."""
    cases = [case for case in (the(study, id) for id in ("3", "3-p1-p1", "4")) if case]
    return cases, ". ".join(map(conditions, cases)) + "." + test_words(cases[0]) if cases else "Case 3 and Case 4 were not run."


def swept(study, number, name, curve, x, at, paper):
    cases, said = studied(study)
    fig = figure(number, name, paper, said, head=["case", x, "as the paper: mean %, median of nodes (range)", "fresh", "beyond R"])
    for case in cases:
        nodes = case["measured"]["nodes"]
        lines = [over_nodes(nodes, curve, f"{error}_mean", name=label, color=color) for error, label, color in (
            ("held", "networks, as the paper", 0), ("fresh", "fresh", 3), ("beyond", "beyond R", 5))]
        lines += [level(f"{label}, fresh", "dashes", color, 100 * median(over(nodes, of, "displacement")), lines[0])
                  for of, label, color in (("linear", "linear predictor", 1), ("ours", case["measured"]["ours"], 6))]
        fig["panels"].append(panel(title(case), x, "mean relative error, %", lines, log_y=True))
        for value in at:
            rows = [row for node in nodes for row in node[curve] if row["x"] == value]
            if rows:
                fig["table"].append([title(case), f"{value:g}", *(spread([row[f"{error}_mean"] for row in rows])
                                                                  for error in ("held", "fresh", "beyond"))])
    return fig


def figure_7(study):
    cases, said = studied(study)
    fig = figure("7", "Histograms of the displacement's error", "Case 3, 3,000 pairs: the peak lies at 5 % with 20 neurons, at 2 % with "
                 "100 and below 2 % with 300, where very few errors are beyond 6 %.", said, peaks_of_histograms(cases),
                 ["case", "neurons", "as the paper: below 2 %", "below 6 %", "fresh: below 2 %", "below 6 %"])
    for case in cases:
        nodes, lines = case["measured"]["nodes"], {"held": [], "fresh": []}
        for h, of in enumerate(nodes[0]["histograms"] if nodes else []):
            row = [title(case), str(of["neurons"])]
            for kind in lines:
                counts = added(node["histograms"][h][kind] for node in nodes)
                lines[kind].append(steps(f"{of['neurons']} neurons", (5, 0, 3)[h % 3], counts))
                row += [below(counts, 0.02), below(counts, 0.06)]
            fig["table"].append(row)
        for kind, words in (("held", "as the paper"), ("fresh", "fresh directions")):
            fig["panels"].append(panel(f"{title(case)}: {words}", "relative error, %", "share of pairs, %", lines[kind]))
    return fig


def figure_8(study):
    fig = swept(study, "8", "Mean error of the displacement against neurons", "by_neurons", "neurons", [20, 50, 100, 200, 300],
                "100 to 300 neurons: 2 to 3 % for the liver (text); the curve falls steeply, then slowly.")
    return {**fig, "found": fresh_against_held(studied(study)[0], "by_neurons", "displacement")}


def figure_9(study):
    fig = swept(study, "9", "Mean error against the spread", "by_spread", "spread (scaled inputs)",
                [0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0, 1.25, 1.5, 2.0, 3.0], "A spread of about 0.75 is best for the liver, 1 for the drain.")
    return {**fig, "found": best_x(studied(study)[0], "by_spread", "spread")}


def figure_10(study):
    fig = swept(study, "10", "Mean error against the number of training pairs", "by_samples", "training pairs",
                [500, 1000, 2000, 4000, 5000, 8000],
                "More pairs reduce the error, ever less so; for the drain it rises slightly beyond 4,000 pairs.")
    cases, _ = studied(study)
    if cases:
        fig["conditions"] += f" {cases[0]['measured']['sizes']['study_neurons']} neurons."
    return {**fig, "found": last_against_first(cases, "by_samples", "training pairs")}


def figure_13(study):
    fig, liver = figure("13", "The liver's surface, subdivided", "Four meshes by Loop's scheme, 596 to 38,018 vertices.",
                        "Case 3 was not run."), the(study, "3")
    if liver:
        fig["conditions"] = "At rest, seen from above."
        fig["table"] = [["level", "vertices", "triangles"]] + [
            [str(l), str(len(s["points"])), str(len(s["triangles"]))] for l, s in enumerate(liver["surfaces"])]
    return fig


def straight_line(x, y):
    """Constant and slope by least squares with relative weights, because otherwise the largest values would dominate."""
    w = [1 / (v * v) for v in y]
    s, sx, sxx = sum(w), sum(a * b for a, b in zip(w, x)), sum(a * b * b for a, b in zip(w, x))
    sy, sxy = sum(a * b for a, b in zip(w, y)), sum(a * b * c for a, b, c in zip(w, x, y))
    slope = (s * sxy - sx * sy) / (s * sxx - sx * sx)
    return (sy - slope * sx) / s, slope


def figure_14(study):
    fig, liver = figure("14", "Time of a deformation against vertices", "The time grows in a straight line with vertices: 9.36, 37.5, 150 "
                        "and 599 ms, 15.8 us a vertex.", "Case 3 was not run."), the(study, "3")
    if not liver or not liver.get("runtime"):
        return fig
    times = liver["runtime"]
    fig["found"] = slopes(times)
    fig["conditions"] = f"{conditions(liver)}; networks of {times['neurons']} neurons; medians on one core of: {study['machine']}."
    vertices = [row["vertices"] for row in times["levels"]]
    ours = lambda name, color, key: series(name, "points", color, vertices, [1e-3 * row[key] for row in times["levels"]])
    lines = []
    fig["table"] = [["", "constant, us", "per vertex, us", "farthest point from the line, %"]]
    for of in (series("paper, Pentium 4", "points", 2, [v for v, _, _ in PAPER_LEVELS], [1e3 * s for _, _, s in PAPER_LEVELS]),
               ours("network at every vertex", 5, "every_vertex_us"), ours("networks, then Loop's weights", 0, "network_us"),
               ours(liver["measured"]["ours"] + ", then Loop's weights", 3, "ours_us")):
        lines.append(of)
        if len(of["x"]) < 2:
            continue
        constant, slope = straight_line(of["x"], of["y"])
        lines.append(series("", "line", of["color"], of["x"], [constant + slope * x for x in of["x"]]))
        farthest = max(abs(a / b - 1) for a, b in zip(lines[-1]["y"], of["y"]))
        fig["table"].append([of["name"], f"{1e3 * constant:.3g}", f"{1e3 * slope:.3g}", f"{100 * farthest:.1f}"])
    fig["panels"].append(panel("Time against vertices", "vertices", "time, ms", lines, log_x=True, log_y=True))
    return fig


def figure_15(study):
    fig = figure("15", "Two tools at once", "The error grows with depth; the maximum error for the majority of the points is within 2 to 4 %.",
                 head=["case; mean % (median of pairs)", "depth, mm", "pairs", "(15)-(16)", "below 2 %", "below 4 %", "coupled",
                       "below 2 %", "linear", "force: coupled", "each tool alone", "linear"])
    for case in ran(study):
        pairs = case["measured"]["pairs"]
        if not pairs:
            continue
        distances = [1e3 * pair["distance_m"] for pair in pairs]
        fig["conditions"] += (
            f"{conditions(case)}: {len(pairs)} pairs of random nodes {min(distances):.0f} to {max(distances):.0f} mm apart, two of the "
            "exploratory directions, the shallower tool at a random share of the deeper one's depth; against solves with both nodes "
            "held; errors at all output nodes but these two, over the largest displacement of that pair. ")
        by_depth = {}  # in tenths of a millimetre
        for depth in (depth for pair in pairs for depth in pair["depths"]):
            by_depth.setdefault(int(1e4 * depth["depth_m"] + 0.5), []).append(depth)
        lines = {"paper": [], "coupled": []}
        for n, (depth, rows) in enumerate(sorted(by_depth.items())):
            of = lambda key: f"{percent(mean([row[key] for row in rows]))} ({percent(median([row[key] for row in rows]))})"
            counts = {kind: added(row[kind] for row in rows) for kind in lines}
            for kind in lines:
                lines[kind].append(steps(f"{depth / 10:.1f} mm", (7, 3, 6, 0, 4, 5)[n % 6], counts[kind]))
            fig["table"].append([title(case), f"{depth / 10:.1f}", str(len(rows)), of("paper_mean"), below(counts["paper"], 0.02),
                                 below(counts["paper"], 0.04), of("coupled_mean"), below(counts["coupled"], 0.02), of("linear_mean"),
                                 of("coupled_force"), of("alone_force"), of("linear_force")])
        for kind, words in (("paper", "weights (15)-(16)"), ("coupled", "coupled")):
            fig["panels"].append(panel(f"{title(case)}: {words}", "relative error, %", "share of nodes, %", lines[kind]))
        fig["found"] += deepest_pairs(case)
    fig["conditions"] = fig["conditions"] or "Case 3 was not run."
    return fig


def figure_locking(study):
    fig = figure("P1 and p1-p1", "Effect of locking on the force", "The paper does not mention locking; its elements are linear tetrahedra.",
                 "Not run: needs Case 3 with both elements (--cases 3,3-p1-p1).")
    locked, free = the(study, "3"), the(study, "3-p1-p1")
    if not locked or not free:
        return fig
    fig["conditions"] = (f"{conditions(locked)}. {conditions(free)}. The mesh and the nodes are the same. Stiffness at rest and curves "
                         "are along the inward normal.")
    fig["table"], ratios = [["node", "P1, N/m", "p1-p1, N/m", "P1 over p1-p1"]], []
    for a in locked["measured"]["nodes"]:
        for b in (b for b in free["measured"]["nodes"] if a["node"] == b["node"] and b["stiffness_N_per_m"] > 0):
            ratios.append(a["stiffness_N_per_m"] / b["stiffness_N_per_m"])
            fig["table"].append([f"{a['node']}{' (beside fixed)' if a['beside_fixed'] else ''}", f"{a['stiffness_N_per_m']:.2f}",
                                 f"{b['stiffness_N_per_m']:.2f}", f"{ratios[-1]:.2f}"])
            if not a["beside_fixed"] and len(fig["panels"]) < 2:
                fig["panels"].append(panel(f"Node {a['node']}", "depth, mm", "force, mN", [
                    series(name, "joined", color, scaled(n["curves"]["depth_m"], 1e3), scaled(n["curves"]["finite_elements"], 1e3))
                    for name, color, n in (("P1, as the paper", 5, a), ("p1-p1", 0, b))]))
    fig["found"] = locking(locked, free, ratios)
    if ratios:
        fig["table"].append(["median", "", "", f"{median(ratios):.2f}"])
    return fig
