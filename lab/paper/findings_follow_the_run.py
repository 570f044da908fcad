#!/usr/bin/python3
"""Claim: the sentences of the page about a run follow from its measurements. Other measurements result in other sentences with
their numbers, and without measurements there is no sentence."""

from report import (best_x, deepest_pairs, finest_level, fresh_against_held, last_against_first, locking, never_enough,
                    plain_loop_against_ours, report, slopes)


def measured(x, held, fresh):
    """Two nodes, the second beside the fixed nodes, with the same errors [fractions] at each x."""
    rows = [{"x": a, "neurons": a, "held_mean": h, "held_max": h, "fresh_mean": f} for a, h, f in zip(x, held, fresh)]
    curves = ("by_neurons", "by_spread", "by_samples", "force_as_paper")
    nodes = [{"beside_fixed": beside, "linear": {"displacement": 0.04}, **{c: [dict(row) for row in rows] for c in curves}}
             for beside in (False, True)]
    return {"of": {"id": "3", "title": "Case 3"}, "measured": {"element": "P1", "nodes": nodes, "pairs": []}}


def expect(sentence, part):
    assert part in sentence, (part, sentence)


falling, rising = (measured([0.5, 1, 2], held, fresh) for held, fresh in (
    ([0.03, 0.02, 0.01], [0.03, 0.01, 0.02]), ([0.01, 0.02, 0.03], [0.03, 0.02, 0.01])))
expect(best_x([falling], "by_spread", "spread"), "as the paper 2 (1.00 %), fresh 1 (1.00 %)")
expect(best_x([rising], "by_spread", "spread"), "as the paper 0.5 (1.00 %), fresh 2 (1.00 %)")

worse, better = measured([100, 300], [0.05, 0.01], [0.05, 0.03]), measured([100, 300], [0.05, 0.04], [0.05, 0.02])
expect(fresh_against_held([worse], "by_neurons", "displacement"),
       "Case 3: fresh 3.00 %, as the paper 1.00 %, ratio 3, the linear predictor 4.00 %")
expect(fresh_against_held([better], "by_neurons", "displacement"), "fresh 2.00 %, as the paper 4.00 %, ratio 0.5")
expect(last_against_first([worse], "by_samples", "training pairs"), "300 training pairs 1.00 %, 100 training pairs 5.00 %, ratio 0.2")

never = measured([10, 20], [0.5, 0.2], [0, 0])
expect(never_enough([never]), "1 of 1 beside the fixed ones, 1 of 1 elsewhere")
never["measured"]["nodes"][0]["force_as_paper"][1]["held_max"] = 0.05
expect(never_enough([never]), "1 of 1 beside the fixed ones, 0 of 1 elsewhere")

empty, times = {**falling, "measured": {"element": "P1", "nodes": [], "pairs": []}}, {"levels": [], "deformation_us": 0}
assert not any((best_x([empty], "by_spread", "spread"), fresh_against_held([], "by_neurons", "force"), deepest_pairs(empty),
                slopes(times), finest_level(times), plain_loop_against_ours(times), locking(empty, empty, [])))
data, sections = report({"less_than_full": "", "software": "", "machine": "", "seconds": 0, "cases": []})
assert not any(figure["found"] for figure in data["figures"].values()) and "This run:" not in str(sections)
