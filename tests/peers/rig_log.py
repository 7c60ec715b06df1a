"""Cases of docking-rig-log/1 and their residuals against the nominal model.

The residuals are those of the format's definition: A executed velocity, B wrench, C velocity of the
rig's model, K pose. All peers start from the same residuals.
"""

import json
from pathlib import Path

import numpy as np

MODEL_DIGITS = 2e-7
"""Scale of channel C: the digits of the log."""


def rotations(quaternion):
    """Rotation matrices R_CM of unit quaternions (w x y z), shape (n, 3, 3)."""
    w, x, y, z = (quaternion / np.linalg.norm(quaternion, axis=1)[:, None]).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def differences(values):
    """Change since the row before; zero in the first row."""
    return np.diff(values, axis=0, prepend=values[:1])


class RigLog:
    """One log with its nominal prediction. Vectors are x y z, sixes x y z rx ry rz, SI."""

    def __init__(self, meta, path):
        table = np.genfromtxt(path, delimiter=",", names=True)
        columns = lambda names: np.stack([table[name] for name in names.split()], axis=1)
        self.meta, self.step_s = meta, meta["sample_time_s"]
        self.mode = table["mode"]
        self.wrench = columns("fx fy fz tx ty tz")
        self.sent = columns("vcx vcy vcz wcx wcy wcz")
        self.executed = columns("vex vey vez wex wey wez")
        self.model = columns("vmx vmy vmz wmx wmy wmz")
        self.position = columns("px py pz")
        self.turn = rotations(columns("qw qx qy qz"))
        self.active = np.array(meta["dof_mask"], dtype=bool)
        self._nominal()

    def to_body(self, vectors):
        """World vectors in body axes."""
        return np.einsum("nji,nj->ni", self.turn, vectors)

    def to_world(self, vectors):
        """Body vectors in world axes."""
        return np.einsum("nij,nj->ni", self.turn, vectors)

    def _nominal(self):
        self.predicted_velocity = self._actuator()
        self._contact()
        tool, sensor = self.meta["tool"], self.meta["ft_sensor"]
        mass, com, bias = tool["mass_kg"], np.array(tool["com_m"]), np.array(sensor["bias"])
        self.gravity = self.to_body(np.tile(self.meta["gravity_m_s2"], (len(self.mode), 1)))
        self.inertial = self._inertial(com)
        weight = np.hstack([mass * self.gravity, np.cross(com, mass * self.gravity)])
        self.load = np.hstack([self.contact_force, np.cross(self.arm, self.contact_force)]) + weight
        if tool["dynamic_compensation"]:
            self.load += mass * self.inertial[0] + self.inertial[1]
        self.predicted_wrench = self.load + bias
        self._body(weight, bias)

    def _actuator(self):
        actuator = self.meta["actuator"]
        delay = actuator["transport_delay_s"] / self.step_s
        kept = np.exp(-self.step_s / actuator["lag_time_constant_s"])
        rows = np.arange(len(self.sent)) - 1 - delay
        low = np.floor(rows).astype(int)
        at = lambda k: np.where((k >= 0)[:, None], self.sent[np.maximum(k, 0)], 0.0)
        late = at(low) + (rows - low)[:, None] * (at(low + 1) - at(low))
        out = np.zeros_like(self.sent)
        for n in range(1, len(out)):
            out[n] = kept * out[n - 1] + (1 - kept) * late[n]
        return out

    def _contact(self):
        contact, geometry = self.meta["contact"], self.meta["geometry"]
        lever, sensor = np.array(geometry["r_tip_m"]), np.array(geometry["r_sensor_m"])
        self.arm = lever - sensor
        tip = self.position + self.to_world(np.tile(lever, (len(self.mode), 1)))
        spin = np.cross(self.executed[:, 3:], lever)
        self.tip_speed = self.executed[:, :3] + self.to_world(spin)
        front, aft = tip[:, 0] - contact["x_front_m"], contact["x_aft_m"] - tip[:, 0]
        self.depth = np.maximum(np.maximum(front, aft), 0.0)
        self.wall = np.where(front > 0, -1.0, np.where(aft > 0, 1.0, 0.0))
        self.depth_rate = -self.wall * self.tip_speed[:, 0]
        damping = contact["c_n_Ns_m"] * np.minimum(1.0, self.depth / contact["delta_c_m"])
        push = np.maximum(0.0, contact["k_n_N_m"] * self.depth + damping * self.depth_rate)
        side = -(contact["k_t_N_m"] * tip[:, 1:] + contact["c_t_Ns_m"] * self.tip_speed[:, 1:])
        self.contact_force = self.to_body(np.column_stack([self.wall * push, side]))

    def _inertial(self, com):
        """Force per kilogram, and torque, with which the tool's inertia loads the sensor."""
        tool, geometry = self.meta["tool"], self.meta["geometry"]
        inertia, spin = np.array(tool["inertia_kg_m2"]), self.executed[:, 3:]
        change = differences(self.executed) / self.step_s
        place = np.array(geometry["r_sensor_m"]) + com
        moved = np.cross(change[:, 3:], place) + np.cross(spin, np.cross(spin, place))
        force = -(self.to_body(change[:, :3]) + moved)
        own = -(change[:, 3:] @ inertia.T + np.cross(spin, spin @ inertia.T))
        torque = own + np.cross(com, tool["mass_kg"] * force)
        zero = np.zeros_like(force)
        return np.hstack([force, zero]), np.hstack([zero, torque])

    def _body(self, weight, bias):
        spacecraft, geometry = self.meta["spacecraft"], self.meta["geometry"]
        inertia = np.array(spacecraft["inertia_kg_m2"])
        net = self.wrench - weight - bias
        torque = net[:, 3:] + np.cross(geometry["r_sensor_m"], net[:, :3])
        spin = self.model[:, 3:]
        turning = np.linalg.solve(inertia, (torque - np.cross(spin, spin @ inertia.T)).T).T
        pushed = self.to_world(net[:, :3]) / spacecraft["mass_kg"]
        self.acceleration = np.hstack([pushed, turning]) * self.active
        before = np.vstack([self.acceleration[:1], self.acceleration[:-1]])
        self.increment = 0.5 * self.step_s * (self.acceleration + before)
        closed = np.flatnonzero(self.mode == 1)
        self.modelled = np.zeros(len(self.mode), dtype=bool)
        self.modelled[closed[2:]] = True

    def residuals(self):
        """Measured minus nominal of channels A, B, C and K, each (n, axes that count)."""
        model = (differences(self.model) - self.increment) * self.modelled[:, None]
        last = np.vstack([self.executed[:1], self.executed[:-1]])
        way = differences(self.position) - 0.5 * self.step_s * (self.executed + last)[:, :3]
        way[0] = 0.0
        return {
            "A": (self.executed - self.predicted_velocity)[:, self.active],
            "B": self.wrench - self.predicted_wrench,
            "C": model[:, self.active],
            "K": way[:, self.active[:3]],
        }

    def scales(self):
        """Noise by data sheet of the columns of `residuals`."""
        noise = self.meta["noise_sigma"]
        velocity = np.repeat([noise["velocity_m_s"], noise["rate_rad_s"]], 3)[self.active]
        return {
            "A": velocity,
            "B": np.repeat([noise["force_N"], noise["torque_Nm"]], 3),
            "C": np.full(self.active.sum(), MODEL_DIGITS),
            "K": np.full(self.active[:3].sum(), np.sqrt(2) * noise["position_m"]),
        }


def levels(residuals, scales):
    """z of each channel: root mean square in units of the data sheet's noise."""
    return {
        channel: float(np.sqrt(np.mean((values / scales[channel]) ** 2))) if values.size else 0.0
        for channel, values in residuals.items()
    }


def total(level):
    """E(z) over the four channels."""
    return float(np.sqrt(sum(z * z for z in level.values())))


class Case:
    """A pair of logs with the truth about them."""

    def __init__(self, folder, truth):
        self.name, self.truth = folder.name, truth
        meta = json.loads((folder / "meta.json").read_text())
        self.train, self.test = (RigLog(meta, folder / f"{log}.csv") for log in ("train", "test"))
        self._check()

    def _check(self):
        """The nominal model here has to be that of the truth file, or the comparison is void."""
        found = levels(self.test.residuals(), self.test.scales())
        for channel in "ABK":
            expected = self.truth["test"]["z_nominal"][channel]
            if abs(found[channel] - expected) > 0.01 * max(1.0, expected):
                raise SystemExit(
                    f"case {self.name}, channel {channel}: the nominal model leaves "
                    f"{found[channel]:.4f}, truth.json says {expected:.4f}; rig_log.py is wrong"
                )

    def error_gone(self, level):
        """Share of the removable error on the unseen log that is gone, %; None if there is none."""
        nominal = levels(self.test.residuals(), self.test.scales())
        oracle = dict(self.truth["test"]["z_oracle"])
        # The digits of the log keep channel C above zero, for every tool alike.
        oracle["C"] = min(max(oracle["C"], 0.16), nominal["C"])
        removable = total(nominal) - total(oracle)
        return 100 * (total(nominal) - total(level)) / removable if removable > 0.02 else None


def cases(folder):
    """All cases of a folder with a truth.json."""
    truths = json.loads((Path(folder) / "truth.json").read_text())
    return [Case(Path(folder) / name, truth) for name, truth in sorted(truths.items())]
