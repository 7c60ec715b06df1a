"""The same delay and gain, from the same log, by softdock and by mujoco.sysid.

    sysid.py SOFTDOCK WORK

SOFTDOCK: the program. A simulated rig hides a delay and a gain of the robot's velocity; `softdock fit`
and MuJoCo's toolbox of system identification estimate both. Prints Markdown, and fails if one of
the four 95 % intervals leaves the truth out.
"""

import json
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
from mujoco import sysid

SCENARIO = Path("host-tools/scenarios/diagnosis.toml")
NOMINAL = Path("host-tools/scenarios/diagnosis.model.toml")
DELAY_S = 0.012
"""Of the scenario's robot; its lag is left out, which MuJoCo's toolbox has no parameter for."""
HIDDEN = {"velocity_gain": ("gain_error", 0.031), "actuation_delay": ("extra_delay_s", 0.0043)}
NOISE_M = 1e-6
CYCLE_S = 0.004
COUNT_M = 1e-7
"""Least digit of a correction."""
# An integrator of the commanded velocity, in steps of the rig's cycle.
XML = """
<mujoco>
  <option timestep="0.004" gravity="0 0 0"/>
  <worldbody>
    <body><joint name="x" type="slide" axis="1 0 0"/><geom size="0.1" mass="1"/></body>
  </worldbody>
  <actuator>
    <general name="path" joint="x" dyntype="integrator" gainprm="0"/>
  </actuator>
  <sensor><actuatorfrc name="force" actuator="path"/></sensor>
</mujoco>
"""


def without_lag(text, key):
    assert f"{key} = 0.006" in text, f"expected the lag of 6 ms as {key}"
    return text.replace(f"{key} = 0.006", f"{key} = 0.0")


def recorded(softdock, work):
    """The rig's log, as a recording and as columns."""
    scenario = without_lag(SCENARIO.read_text(), "lag_s")
    for effect, (parameter, value) in HIDDEN.items():
        scenario += f'\n[[rig.hidden]]\nid = "{effect}"\nparameters = {{ {parameter} = {value} }}\n'
    (work / "scenario.toml").write_text(scenario)
    model = without_lag(NOMINAL.read_text(), "lag_s")
    for effect, (parameter, _) in HIDDEN.items():
        model += f'\n[[effect]]\nid = "{effect}"\nparameters = {{ {parameter} = 0.0 }}\n'
    # The nominal delay is known: one delay is to be found, not two.
    model += "\n[tolerance]\ntransport_delay_s = 0.0\nlag_s = 0.0\n"
    (work / "model.toml").write_text(model)
    log = work / "log.mcap"
    run = [softdock, "run", work / "scenario.toml", "-o", log, "--force"]
    subprocess.run(run, check=True, stdout=subprocess.DEVNULL)
    table = work / "log.csv"
    subprocess.run([softdock, "export", log, "-o", table, "--force"], check=True, stdout=subprocess.DEVNULL)
    return log, np.genfromtxt(table, delimiter=",", names=True, deletechars="", dtype=None, encoding="utf-8")


def by_softdock(softdock, work, log):
    """Value and both ends of its 95 % interval, of each hidden parameter."""
    fit = [softdock, "fit", work / "model.toml", log, "--json"]
    said = json.loads(subprocess.run(fit, check=True, capture_output=True, text=True).stdout)
    fitted = {p["name"]: p for p in said["parameters"]}
    names = [f"{effect}.{parameter}" for effect, (parameter, _) in HIDDEN.items()]
    return [[fitted[name][key] for key in ("value", "low", "high")] for name in names]


def by_mujoco(table):
    """The same by mujoco.sysid: the path of the commanded velocity, with a gain and late."""
    times = table["status_time_s"]
    sent = table["output_correction_x_counts"] * COUNT_M / CYCLE_S
    position = table["inputs_robot_position_x_m"]
    spec = mujoco.MjSpec.from_string(XML)
    model = spec.compile()
    params = sysid.ParameterDict({
        "gain": sysid.Parameter("gain", 1.0, min_value=0.5, max_value=1.5),
        "delay": sysid.Parameter("delay", DELAY_S, min_value=0.0, max_value=0.05),
        "start": sysid.Parameter("start", position[0], min_value=0.0, max_value=3.0),
    })
    control = sysid.TimeSeries(times, sent[:, None], {"path": (sysid.SignalType.MjSensor, np.array([0]))})
    measured = sysid.TimeSeries(times, position[:, None], {"force": (sysid.SignalType.MjSensor, np.array([0]))})
    initial = sysid.create_initial_state(model, np.zeros(1), np.zeros(1), np.zeros(1))

    def late(params, predicted, measured, model, return_all, state, **_):
        # Time, position and velocity of the joint, then the integral of the command, which is straight
        # between two steps.
        path = np.interp(times - params["delay"].value, state[:, 0], state[:, 3])
        known = params["start"].value + params["gain"].value * path
        return (position - known)[:, None] / NOISE_M, predicted, measured

    residual = sysid.build_residual_fn(
        models_sequences=[sysid.ModelSequences("rig", spec, "log", initial, control, measured)],
        modify_residual=late,
        # A command is held for its cycle, and not interpolated.
        resample_true=False,
    )
    found, result = sysid.optimize(params, residual, verbose=False)
    left, _, _ = residual(result.x, found)
    _, half = sysid.calculate_intervals(left, result.jac)
    values = found.as_vector()
    both = [(values[0] - 1.0, half[0]), (values[1] - DELAY_S, half[1])]
    return [[value, value - reach, value + reach] for value, reach in both]


def main():
    softdock, work = sys.argv[1], Path(sys.argv[2])
    work.mkdir(parents=True, exist_ok=True)
    log, table = recorded(softdock, work)
    answers = {"softdock fit": by_softdock(softdock, work, log), "mujoco.sysid": by_mujoco(table)}
    print("## The same delay and gain\n")
    print("| | hidden | " + " | ".join(answers) + " |\n" + "|---" * (2 + len(answers)) + "|")
    missed = []
    for k, (effect, (parameter, truth)) in enumerate(HIDDEN.items()):
        cells = []
        for tool, estimates in answers.items():
            value, low, high = estimates[k]
            cells.append(f"{value:.6f} ({low:.6f} to {high:.6f})")
            missed += [f"{tool}: {effect}"] if not low <= truth <= high else []
        print(f"| {effect}.{parameter} | {truth} | " + " | ".join(cells) + " |")
    if missed:
        sys.exit("these intervals leave the truth out: " + ", ".join(missed))


main()
