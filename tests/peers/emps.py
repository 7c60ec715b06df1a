"""The prismatic axis EMPS: which forces are missing from mass times acceleration?

All tools get the same rows of the same import (`examples/emps/mapping.toml`) and the same velocity
and acceleration, central differences of the filtered position.
"""

import json

import numpy as np

from tools import frols_terms, pysindy_terms, rms

MASS_KG = 95.11
"""Of the nominal model, `examples/emps/model.toml`."""


class Axis:
    """One log: command force (N), position, velocity and acceleration."""

    def __init__(self, path):
        table = np.genfromtxt(
            path,
            delimiter=",",
            names=True,
            usecols=("inputs_sensor_force_x_n", "motion_position_x_m", "status_time_s"),
        )
        # The mapping records what a sensor would feel: the command with the opposite sign.
        force, position = -table["inputs_sensor_force_x_n"], table["motion_position_x_m"]
        self.step_s = float(np.median(np.diff(table["status_time_s"])))
        velocity = np.gradient(position, self.step_s)
        acceleration = np.zeros_like(position)
        acceleration[1:-1] = np.diff(position, n=2) / self.step_s**2
        self.position, self.velocity, self.acceleration = position, velocity, acceleration
        self.force, self.missing = force, force - MASS_KG * acceleration

    def terms(self):
        """Candidates for a sparse regression; jerk is what a delay of the command would need."""
        v, a, x = self.velocity, self.acceleration, self.position
        columns = {"1": np.ones_like(v), "sign(v)": np.sign(v), "v": v, "|v|": np.abs(v)}
        columns |= {"|v|v": np.abs(v) * v, "v^3": v**3, "x": x, "x^2": x**2, "x^3": x**3}
        columns |= {"a": a, "|a|": np.abs(a), "jerk": np.gradient(a, self.step_s), "xv": x * v}
        for speed in (5e-3, 2e-2):
            columns[f"tanh(v/{speed})"] = np.tanh(v / speed)
            columns[f"sign(v)exp(-(v/{speed})^2)"] = np.sign(v) * np.exp(-((v / speed) ** 2))
        return columns

    def inputs(self):
        """Signals of which SysIdentPy makes its polynomials."""
        return np.column_stack([self.velocity, self.position, self.acceleration])

    def error_percent(self, predicted):
        """Error of the inverse model: what is left of the force over the force."""
        return 100 * rms(self.missing - predicted) / rms(self.force)


def with_pysindy(train, test):
    """Result of PySINDy."""
    columns, unit = train.terms(), rms(train.missing)
    found, on_test = pysindy_terms(columns, train.missing / unit, test.terms())
    _, on_train = pysindy_terms(columns, train.missing / unit, columns)
    labels = [label for _, label in found]
    # Generous: any odd function of the speed beside any dry friction, among the largest three.
    dry = any(label.startswith(("sign(v)", "tanh(v")) for label in labels[:3])
    wet = bool({"v", "|v|v", "v^3"} & set(labels[:3]))
    return {
        "train": train.error_percent(unit * on_train),
        "test": test.error_percent(unit * on_test),
        "named": dry and wet,
        "says": f"{len(labels)} terms: " + ", ".join(labels[:5]) + (", ..." if len(labels) > 5 else ""),
    }


def with_sysidentpy(train, test):
    """Result of SysIdentPy: the best on held-back data of degree 1 to 3 is what a user would keep."""
    unit, names, best = rms(train.missing), ["v", "x", "a"], None
    for degree in (1, 2, 3):
        found, on_test = frols_terms(
            train.inputs(), train.missing / unit, test.inputs(), degree
        )
        _, on_train = frols_terms(train.inputs(), train.missing / unit, train.inputs(), degree)
        result = {
            "train": train.error_percent(unit * on_train),
            "test": test.error_percent(unit * on_test),
            # Dry friction is no polynomial; its library cannot hold the name.
            "named": False,
            "says": f"{len(found)} terms: "
            + ", ".join(
                "·".join(f"{names[i]}(k-{lag})" for i, lag in term) or "1" for term in found[:4]
            )
            + ", ...",
        }
        if best is None or result["train"] < best["train"]:
            best = result
    return best


def with_softdock(report, train, test):
    """Result of `softdock diagnose --json`; its noise unit is 1 N, summed over six readings."""
    last = report["steps"][-1]
    in_percent = lambda level, axis: 100 * level * np.sqrt(6) / rms(axis.force)
    return {
        "train": in_percent(last["train_error"], train),
        "test": in_percent(last["test_error"], test),
        "named": {"guide_viscous"} < set(report["effects"])
        and bool({"guide_coulomb", "guide_asymmetry"} & set(report["effects"])),
        "says": ", ".join(report["effects"]) or report["verdict"],
    }


def compare(folder):
    """Results of all tools on the exported logs in a folder, with the time of each."""
    from time import perf_counter

    train, test = Axis(folder / "train.csv"), Axis(folder / "test.csv")
    report = json.loads((folder / "softdock.json").read_text())
    results = {"softdock": with_softdock(report, train, test) | {"seconds": report["seconds"]}}
    for name, run in (("PySINDy", with_pysindy), ("SysIdentPy", with_sysidentpy)):
        began = perf_counter()
        results[name] = run(train, test)
        results[name]["seconds"] = perf_counter() - began
    return results
