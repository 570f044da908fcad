"""Numbers of a run of the study of the paper, and sentences about them: all numbers and cases in a sentence are computed from the
measurements. Errors are fractions."""

NOTICEABLE = 0.10  # of a force, at human fingertips (paper, section 3)
ERROR_BIN, SHOWN_BINS = 0.005, 40  # of histograms, whose last bin contains all larger errors


def percent(fraction):
    value = 100 * fraction
    return f"{value:.0e}" if 0 < value < 0.005 else f"{value:.2f}"


def median(values):
    v, n = sorted(values), len(values)
    return 0.0 if n == 0 else v[n // 2] if n % 2 else (v[n // 2 - 1] + v[n // 2]) / 2


def mean(values):
    return sum(values) / len(values) if values else 0.0


def largest(values):
    return max(values, default=0.0)


def over(nodes, predictor, error):
    """A number of a predictor at every node."""
    return [node[predictor][error] for node in nodes]


def spread(values):
    return f"{percent(median(values))} ({percent(min(values))} to {percent(largest(values))})"


def added(histograms):
    return [sum(counts) for counts in zip(*histograms)]


def below(counts, error):
    share = sum(n for b, n in enumerate(counts) if (b + 1) * ERROR_BIN <= error + 1e-12)
    return percent(share / sum(counts) if sum(counts) else 0)


def conditions(case):
    """K/mu, element, probe, R, nodes: conditions that every figure must state."""
    m = case["measured"]
    nodes = "".join(f" {node['node']}" for node in m["nodes"])
    locked = " (locked)" if m["element"] == "P1" and m["bulk_to_shear"] > 20 else ""
    return (f"{case['of']['title']}: {m['law']}, {m['element']}{locked}, K/mu = {m['bulk_to_shear']:.3g}, node probes, "
            f"R = {1e3 * m['range_m']:.3g} mm; {len(m['nodes'])} nodes ({sum(n['beside_fixed'] for n in m['nodes'])} beside the "
            f"fixed ones:{nodes})")


def figure(number, title, paper, conditions="", found="", head=None):
    return {"title": title, "conditions": conditions, "paper": paper, "found": found, "panels": [], "table": [head] if head else [],
            "number": number}


def panel(title, x, y, series, log_x=False, log_y=False, limits=None):
    return {"title": title, "x": x, "y": y, "series": series, "log_x": log_x, "log_y": log_y, "limits": limits}


def series(name, mark, color, x, y):
    return {"name": name, "mark": mark, "color": color, "x": x, "y": y}


def level(name, mark, color, value, like):
    """A constant value over the x of another series."""
    ends = [like["x"][0], like["x"][-1]] if like["x"] else []
    return series(name, mark, color, ends, [value] * len(ends))


def steps(name, color, counts):
    """Step curve of counts, in per cent."""
    bins = range(min(SHOWN_BINS, len(counts)) if sum(counts) else 0)
    return series(name, "line", color, [100 * ERROR_BIN * side for b in bins for side in (b, b + 1)],
                  [100 * counts[b] / sum(counts) for b in bins for _ in range(2)])


def over_nodes(nodes, curve, error, combine=median, name="", color=0):
    """A statistic over the nodes, in per cent, at each x that all nodes have."""
    x, y = [], []
    for at in nodes[0][curve] if nodes else []:
        values = [row[error] for node in nodes for row in node[curve] if row["x"] == at["x"]]
        if len(values) >= len(nodes):
            x.append(at["x"])
            y.append(100 * combine(values))
    return series(name, "joined", color, x, y)


def against(a, of_a, b, of_b):
    """'a 1.20 %, b 0.80 %, ratio 1.5'; fractions."""
    return f"{a} {percent(of_a)} %, {b} {percent(of_b)} %" + (f", ratio {of_a / of_b:.2g}" if of_b > 0 else "")


def finding(what, said):
    """'WHAT. Case 3: ...; Case 4: ... .'; empty if there is no case with a result. said: {case title: words}."""
    words = "; ".join(f"{title}: {words}" for title, words in said if words)
    return f"{what}. {words}. " if words else ""


def title(case):
    return case["of"]["title"]


def both(case, curve):
    nodes = case["measured"]["nodes"]
    return over_nodes(nodes, curve, "held_mean"), over_nodes(nodes, curve, "fresh_mean")


def at_smallest(line):
    best = line["y"].index(min(line["y"]))
    return f"{line['x'][best]:g} ({line['y'][best]:.2f} %)"


def peaks_of_histograms(cases):
    def words(nodes):
        for h, of in enumerate(nodes[0]["histograms"] if nodes else []):
            counts = added(node["histograms"][h]["held"] for node in nodes)
            yield f"{of['neurons']} neurons from {100 * ERROR_BIN * counts.index(max(counts)):.1f} %"

    return finding(f"Where most pairs of the paper's test lie, in bins of {100 * ERROR_BIN:g} %",
                   [(title(case), ", ".join(words(case["measured"]["nodes"]))) for case in cases])


def fresh_against_held(cases, curve, error):
    said = []
    for case in cases:
        held, fresh = both(case, curve)
        if fresh["y"]:
            linear = percent(median(over(case["measured"]["nodes"], "linear", error)))
            said.append((title(case), against("fresh", fresh["y"][-1] / 100, "as the paper", held["y"][-1] / 100)
                         + f", the linear predictor {linear} %"))
    return finding("With the most neurons, median of nodes", said)


def best_x(cases, curve, x):
    said = []
    for case in cases:
        held, fresh = both(case, curve)
        if held["y"]:
            said.append((title(case), f"as the paper {at_smallest(held)}, fresh {at_smallest(fresh)}, tried from "
                         f"{held['x'][0]:g} to {held['x'][-1]:g}"))
    return finding(f"Median of nodes, the {x} with the smallest error", said)


def last_against_first(cases, curve, x):
    said = []
    for case in cases:
        held, _ = both(case, curve)
        if len(held["y"]) > 1:
            said.append((title(case), against(f"{held['x'][-1]:g} {x}", held["y"][-1] / 100, f"{held['x'][0]:g} {x}",
                                              held["y"][0] / 100) + ", smallest at " + at_smallest(held)))
    return finding(f"Median of nodes, as the paper, by {x}", said)


def neurons_needed(measured, fresh):
    """Smallest number of neurons for which the largest force error of the paper's test is below the noticeable difference, by
    node; 0: no number is sufficient."""
    curve, error = ("force_all", "fresh_max") if fresh else ("force_as_paper", "held_max")
    return [next((row["neurons"] for row in node[curve] if row[error] <= NOTICEABLE), 0) for node in measured["nodes"]]


def needed_words(measured, fresh):
    needed = neurons_needed(measured, fresh)
    most = max((row["neurons"] for node in measured["nodes"] for row in node["force_all" if fresh else "force_as_paper"]), default=0)
    never, middle = needed.count(0), median([n or most + 1 for n in needed])
    if never == 0:
        return f"{middle:g}"
    if 2 * never >= len(needed):
        return f"none of up to {most} suffices at {never} of {len(needed)} nodes"
    return f"{middle:g} (none suffices at {never} of {len(needed)} nodes)"


def never_enough(cases):
    said = []
    for case in cases:
        nodes, needed = case["measured"]["nodes"], neurons_needed(case["measured"], False)
        of = lambda beside: [n for n, node in zip(needed, nodes) if node["beside_fixed"] == beside]
        said.append((title(case), f"{of(True).count(0)} of {len(of(True))} beside the fixed ones, {of(False).count(0)} of "
                     f"{len(of(False))} elsewhere"))
    return finding(f"Nodes where no size keeps the largest error of the paper's test within {100 * NOTICEABLE:g} %", said)


def slopes(times):
    if len(times["levels"]) < 2:
        return ""
    coarse, fine = times["levels"][0], times["levels"][-1]
    of = lambda key: (fine[key] - coarse[key]) / (fine["vertices"] - coarse["vertices"])
    networks, every = of("network_us"), of("every_vertex_us")
    return (f"From the coarsest to the finest level a vertex more costs {every:.3g} us with a network at every vertex, {networks:.3g} "
            f"us with networks at the nodes and Loop's weights (ratio {every / networks:.3g}), {of('ours_us'):.3g} us with the "
            "default family.")


def deepest_pairs(case):
    deepest = [pair["depths"][-1] for pair in case["measured"]["pairs"] if pair["depths"]]
    if not deepest:
        return ""
    of = lambda key: median([d[key] for d in deepest])
    better = sum(d["coupled_mean"] < d["paper_mean"] for d in deepest)
    words = against("coupled", of("coupled_mean"), "weights (15)-(16)", of("paper_mean"))
    return finding("At the greatest depth that each pair was solved to, median of pairs", [(
        title(case), words + f", the linear predictor {percent(of('linear_mean'))} %, coupled smaller at {better} of {len(deepest)} pairs")])


def locking(locked, free, ratios):
    if not ratios:
        return ""
    a, b = locked["measured"], free["measured"]
    words = (f"At rest {a['element']} is {median(ratios):.2f} times as stiff as {b['element']} (median of {len(ratios)} nodes, "
             f"{min(ratios):.2f} to {max(ratios):.2f}).")
    x, y = (over_nodes(m["nodes"], "by_neurons", "held_mean") for m in (a, b))
    if not x["y"] or not y["y"]:
        return words
    return words + (f" Networks of {x['x'][-1]:g} neurons, mean error of the displacement as the paper: "
                    f"{against(a['element'], x['y'][-1] / 100, b['element'], y['y'][-1] / 100)}.")


def plain_loop_against_ours(times):
    if not times["deformation_us"] > 0:
        return ""
    return (f"On one core of this machine the straight loop takes {times['deformation_plain_us']:.2f} us for a deformation, the "
            f"runtime {times['deformation_us']:.2f} us, ratio {times['deformation_plain_us'] / times['deformation_us']:.2g}.")


def finest_level(times):
    if not times["levels"] or not times["levels"][-1]["network_us"] > 0:
        return ""
    fine = times["levels"][-1]
    return (f"At {fine['vertices']} vertices a network at every vertex takes {1e-3 * fine['every_vertex_us']:.3g} ms, networks at the "
            f"nodes and Loop's weights {1e-3 * fine['network_us']:.3g} ms, ratio {fine['every_vertex_us'] / fine['network_us']:.3g}.")


def ran(study, networks_only=False):
    return [case for case in study["cases"] if not case["missing"] and not (networks_only and (case["of"]["linear"] or case["of"]["id"] == "2"))]


def the(study, id):
    """The case of this name, or None if it was not run."""
    return next((case for case in ran(study) if case["of"]["id"] == id), None)
