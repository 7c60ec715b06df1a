"""Head to head: softdock, PySINDy and SysIdentPy look for missing effects in the same logs.

    identify.py CASES SOFTDOCK.json [EMPS]

CASES: folder of docking-rig-log/1 cases with truth.json; SOFTDOCK.json: `softdock bench diagnose
--folder CASES --json`; EMPS: folder with train.csv, test.csv and softdock.json. Prints Markdown.
"""

import json
import statistics
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from time import perf_counter

import numpy as np

import emps
from rig_log import Case, levels
from terms import library, named, specific
from tools import frols_terms, pysindy_terms

FROLS_INPUTS = ["v", "x", "u"]
"""Velocity, position and command of the axis."""


def by_pysindy(case):
    """Effects of the selected terms of all outputs, the best first, and what is left on test."""
    train, test = case.train, case.test
    residual, unseen, scales = train.residuals(), test.residuals(), train.scales()
    found, left = [], {}
    for channel, target in residual.items():
        columns = library(train, channel, train)
        on_test = library(test, channel, train)
        left[channel] = unseen[channel].copy()
        for output in range(target.shape[1]):
            scale = scales[channel][output]
            terms, predicted = pysindy_terms(columns, target[:, output] / scale, on_test)
            left[channel][:, output] -= scale * predicted
            found += [(gain, named(specific(label, channel, output))) for gain, label in terms]
    return ranked(found), levels(left, test.scales())


def ranked(found):
    """Answers, the best first: of each set of effects the best term of an output counts once.

    A term that stands for no effect is no answer, unless there is no other.
    """
    best = {}
    for gain, effects in found:
        key = frozenset(effects)
        best[key] = max(best.get(key, 0.0), gain)
    order = sorted(best, key=best.get, reverse=True)
    return [set(key) for key in order if key] or [set(key) for key in order]


def frols_name(channel, regressor):
    """Effects that a polynomial of lagged signals stands for; generous."""
    powers = sorted(FROLS_INPUTS[i] for i, _ in regressor)
    if channel == "A":
        return {"actuation_delay", "actuation_lag"} if set(powers) <= {"u"} and powers else set()
    if channel == "B":
        return {
            ("v",): {"guide_viscous", "contact_damping"},
            ("x",): {"cable_stiffness"},
            ("v", "x"): {"hunt_crossley", "contact_damping"},
            ("x", "x"): {"contact_cubic"},
            ("x", "x", "x"): {"contact_cubic"},
        }.get(tuple(powers), set())
    if channel == "C":
        return {"manipulator_resistance"} if powers == ["v"] else set()
    return set()


def by_sysidentpy(case):
    """The same with SysIdentPy."""
    train, test = case.train, case.test
    residual, unseen, scales = train.residuals(), test.residuals(), train.scales()
    found, left = [], {}
    for channel, target in residual.items():
        left[channel] = unseen[channel].copy()
        axes = range(6) if channel == "B" else np.flatnonzero(train.active)
        for output in range(target.shape[1]):
            axis, scale = list(axes)[output], scales[channel][output]
            terms, predicted = frols_terms(
                frols_inputs(train, axis), target[:, output] / scale, frols_inputs(test, axis), 2
            )
            before = np.sum(left[channel][:, output] ** 2)
            left[channel][:, output] -= scale * predicted
            gone = (before - np.sum(left[channel][:, output] ** 2)) / scale**2
            # The order of selection stands for the share of each regressor.
            found += [(max(gone, 0.0) / (1 + k), frols_name(channel, t)) for k, t in enumerate(terms)]
    return ranked(found), levels(left, test.scales())


def frols_inputs(log, axis):
    """Velocity, position and command of an axis; along x for an axis that does not move."""
    axis = axis if log.active[axis] else 0
    position = log.position[:, axis % 3]
    return np.column_stack([log.executed[:, axis], position, log.sent[:, axis]])


TOOLS = {"PySINDy": by_pysindy, "SysIdentPy": by_sysidentpy}


def judge(job):
    """One case with one tool."""
    folder, truth, tool = job
    case = Case(folder, truth)
    began = perf_counter()
    ranked, level = TOOLS[tool](case)
    return tool, {
        "effects": ranked,
        "found": bool(ranked),
        "gone": case.error_gone(level),
        "seconds": perf_counter() - began,
        "truth": truth,
    }


def from_softdock(document, truths):
    """softdock's own answers in the same shape."""
    return [
        {
            "effects": [{effect} for effect in row["effects"]],
            "found": row["verdict"] == "named",
            "unexplained": row["verdict"] == "unexplained",
            "gone": row["drop_percent"],
            "seconds": row["seconds"],
            "truth": truths[row["name"]],
        }
        for row in document["rows"]
    ]


def hits_first(row):
    """The first answer names the one hidden effect."""
    return bool(row["effects"]) and row["truth"]["effects"][0] in row["effects"][0]


def hits_pair(row):
    """The first two answers name both hidden effects."""
    first, second = row["truth"]["effects"]
    two = row["effects"][:2]
    return len(two) == 2 and (
        (first in two[0] and second in two[1]) or (second in two[0] and first in two[1])
    )


def cells(rows):
    """The scores of a tool as cells of the table."""
    of = lambda expected, count: [
        r
        for r in rows
        if r["truth"]["expected"] == expected and len(r["truth"]["effects"]) == count
    ]
    singles, pairs, nulls = of("named", 1), of("named", 2), of("nothing_missing", 0)
    outside = [r for r in rows if r["truth"]["expected"] == "unexplained"]
    gone = [
        r["gone"] if r["gone"] is not None else 0.0
        for r in rows
        if r["truth"]["expected"] == "named" and removable(r["truth"])
    ]
    share = lambda part, whole, test: f"{sum(map(test, part))}/{len(whole)}"
    return [
        share(singles, singles, hits_first),
        share(pairs, pairs, hits_pair),
        share(nulls, nulls, lambda r: r["found"] or r.get("unexplained", False)),
        share(outside, outside, lambda r: r.get("unexplained", False)),
        f"{statistics.median(gone):.1f} %" if gone else "-",
        f"{sum(g >= 90 for g in gone)}/{len(gone)}",
        f"{statistics.median(r['seconds'] for r in rows):.2f} s",
    ]


def removable(truth):
    """Whether the hidden effect makes an error that can be seen on the unseen log."""
    size = lambda z: sum(v * v for v in z.values()) ** 0.5
    return size(truth["test"]["z_nominal"]) - size(truth["test"]["z_oracle"]) > 0.02


def table(header, rows):
    """A Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def hidden_effects(folder, document):
    """The table of the hidden-effect logs."""
    truths = json.loads((folder / "truth.json").read_text())
    jobs = [(folder / name, truth, tool) for tool in TOOLS for name, truth in truths.items()]
    results = {"softdock": from_softdock(document, truths)}
    with ProcessPoolExecutor(max_workers=2) as pool:
        for tool, row in pool.map(judge, jobs):
            results.setdefault(tool, []).append(row)
    header = ["tool", "single effect first", "pair exact", "false alarms", "unexplained"]
    header += ["error gone, median", "at least 90 % gone", "time per log pair"]
    return table(header, [[tool, *cells(rows)] for tool, rows in results.items()])


def real_axis(folder):
    """The table of EMPS."""
    header = ["tool", "error train", "error test", "dry and viscous friction named", "says", "time"]
    rows = []
    for tool, r in emps.compare(folder).items():
        errors = [f"{r['train']:.2f} %", f"{r['test']:.2f} %"]
        rows.append([tool, *errors, "yes" if r["named"] else "no", r["says"], f"{r['seconds']:.1f} s"])
    return table(header, rows)


def main():
    """Prints all tables."""
    cases, document = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text())
    if len(sys.argv) > 3:
        print("Inverse force error of a real axis with friction (EMPS):\n")
        print(real_axis(Path(sys.argv[3])), end="\n\n")
    print(f"Hidden effects in {len(document['rows'])} pairs of logs of a docking rig:\n")
    print(hidden_effects(cases, document))


if __name__ == "__main__":
    main()
