"""Candidate terms for a sparse regression on the residual of a docking rig, and what each names.

The library is a generous one: whoever wrote it knew the catalogue of effects. Every term is a
column; `NAMES` says which effects a term stands for, and a peer gets the point for any of them.
"""

import numpy as np

from rig_log import differences

AXES = ["x", "y", "z", "rx", "ry", "rz"]

NAMES = {
    # Velocity: a delay and a lag have the same first-order term, and a fast mode has its second.
    "d(v_cmd)": {"actuation_delay", "actuation_lag", "rate_limit"},
    "d2(v_cmd)": {"structural_resonance", "actuation_lag", "rate_limit"},
    "v_cmd(|v|>": {"velocity_saturation"},
    "d(v_cmd)(|dv|>": {"rate_limit"},
    "v_cmd(|v|<": {"zero_cross_pause"},
    # Wrench.
    "sign(v)": {"guide_coulomb"},
    "sign(v)exp": {"guide_stribeck"},
    "v": {"guide_viscous"},
    "|v|v": set(),
    "v^3": set(),
    "position": {"cable_stiffness"},
    "depth": {"contact_deadzone"},
    "touch": {"contact_deadzone"},
    "depth^2": {"contact_cubic"},
    "depth^3": {"contact_cubic"},
    "depth rate": {"contact_damping"},
    "depth*rate": {"hunt_crossley", "contact_damping"},
    "own load": {"ft_scale"},
    "load": {"ft_crosstalk"},
    "gravity on force": {"tool_mass_error"},
    "gravity on torque": {"tool_com_error"},
    "acceleration": {"tool_inertia"},
    "t": {"ft_bias_drift"},
    "1-exp(-t/": {"ft_bias_drift"},
    "1": set(),
    # Velocity of the rig's model.
    "v of model": {"manipulator_resistance"},
    "own acceleration": {"sc_mass_error"},
    # Pose: the log has no term for an uncertain clock but the speed itself.
    "speed": {"clock_jitter"},
}


def named(term):
    """Effects that a term stands for; the part of its label in front of a `:` decides."""
    return NAMES[term.split(":")[0]]


def velocity_terms(log, scale):
    """Channel A: per axis, from the nominal velocity, which has no noise."""
    columns = {}
    for axis in np.flatnonzero(log.active):
        v, label = log.predicted_velocity[:, axis], AXES[axis]
        dv, largest, steepest = differences(v), scale["v"][axis], scale["dv"][axis]
        columns[f"v_cmd(|v|>:0,{label}"] = v
        columns[f"d(v_cmd):{label}"] = dv
        columns[f"d2(v_cmd):{label}"] = differences(dv)
        for share in (0.7, 0.8, 0.9):
            over = np.sign(v) * np.maximum(np.abs(v) - share * largest, 0)
            columns[f"v_cmd(|v|>:{share},{label}"] = over
            over = np.sign(dv) * np.maximum(np.abs(dv) - share * steepest, 0)
            columns[f"d(v_cmd)(|dv|>:{share},{label}"] = over
        for share in (0.05, 0.1, 0.2):
            columns[f"v_cmd(|v|<:{share},{label}"] = v * (np.abs(v) < share * largest)
    return columns


def wrench_terms(log, scale):
    """Channel B: loads along x and of the whole tool, sensor errors."""
    columns, t = {"1": np.ones(len(log.mode))}, np.arange(len(log.mode)) * log.step_s
    v = log.predicted_velocity[:, 0] if log.active[0] else log.tip_speed[:, 0]
    columns |= {"sign(v)": np.sign(v), "v": v, "|v|v": np.abs(v) * v, "v^3": v**3}
    for speed in (2e-3, 5e-3, 1e-2):
        columns[f"sign(v)exp:{speed}"] = np.sign(v) * np.exp(-((v / speed) ** 2))
    for axis in range(3):
        columns[f"position:{AXES[axis]}"] = log.position[:, axis]
    touch, depth, rate = log.wall * (log.depth > 0), log.wall * log.depth, log.depth_rate
    columns |= {"touch": touch, "depth": depth, "depth^2": depth * log.depth}
    columns |= {"depth^3": depth * log.depth**2, "depth rate": touch * rate, "depth*rate": depth * rate}
    for axis in range(6):
        columns[f"load:{AXES[axis]}"] = log.load[:, axis]
    for axis in range(3):
        columns[f"gravity:{AXES[axis]}"] = log.gravity[:, axis]
    change = differences(log.predicted_velocity) / log.step_s
    for axis in np.flatnonzero(log.active):
        columns[f"acceleration:{AXES[axis]}"] = change[:, axis]
    columns["t"] = t
    for constant in (1.0, 3.0):
        columns[f"1-exp(-t/:{constant}"] = 1 - np.exp(-t / constant)
    return columns


def model_terms(log, scale):
    """Channel C: what the rig's model may do otherwise than the nominal one."""
    columns = {"1": np.ones(len(log.mode)) * log.modelled}
    for axis in np.flatnonzero(log.active):
        columns[f"own acceleration:{AXES[axis]}"] = log.increment[:, axis] * log.modelled
        columns[f"v of model:{AXES[axis]}"] = log.model[:, axis] * log.modelled
        columns[f"v of model:|v|,{AXES[axis]}"] = (
            np.abs(log.model[:, axis]) * log.model[:, axis] * log.modelled
        )
    return columns


def pose_terms(log, scale):
    """Channel K."""
    columns = {"1": np.ones(len(log.mode))}
    for axis in np.flatnonzero(log.active[:3]):
        columns[f"speed:{AXES[axis]}"] = log.executed[:, axis]
    return columns


BUILDERS = {"A": velocity_terms, "B": wrench_terms, "C": model_terms, "K": pose_terms}


def library(log, channel, fitted_on):
    """Columns of a channel, in a fixed order; sizes of motions are those of the log of the fit."""
    v = fitted_on.predicted_velocity
    scale = {"v": np.abs(v).max(axis=0), "dv": np.abs(differences(v)).max(axis=0)}
    return BUILDERS[channel](log, scale)


def specific(term, channel, output):
    """The label of a term on one output of a channel; the wrench's depend on where they act."""
    if channel == "B" and term.startswith("load:"):
        return f"own {term}" if term == f"load:{AXES[output]}" else term
    if channel == "B" and term.startswith("gravity:"):
        part = "force" if output < 3 else "torque"
        return term.replace("gravity", f"gravity on {part}")
    return term
