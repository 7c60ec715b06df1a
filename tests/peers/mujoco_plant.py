"""A docking plant in MuJoCo: a probe on the robot's flange before a wall or in a cone.

Its physics share nothing with this project. With `--robot` and `--can` it is robot and sensor of a
board, in lock step: time stands still until the board has answered. Without them both spacecraft fly
freely in MuJoCo, and no board is asked: the docking as it should be.

What makes the contact physical, whatever MuJoCo's solver is set to:
- Stiffness is that of explicit springs in N/m between the flange and the head of the probe. MuJoCo's
  contacts are accelerations per metre, scaled by the effective mass; they are kept hard.
- The head has a mass: between two bodies that are only moved there would be no contact force.
- The force on the sensor is stiffness times deflection, not the solver's contact force.

Standard input: one line of JSON, the scene (see `Scene`). Standard output: one JSON document:
    touched, parted   s, of the first contact
    peak              N
    k, q              --free: velocity of both spacecraft at the end, linear (world) and angular (body)
    late              --robot: 0, as no answer can be
"""

import argparse
import json
import math
import socket
import sys
import threading
import xml.etree.ElementTree as ElementTree

import mujoco
import numpy

# Integration step, s; a telegram every 16 steps.
STEP_S = 0.00025
STEPS_PER_CYCLE = 16
CYCLE_S = STEP_S * STEPS_PER_CYCLE
FIRST_IPOC = 1_000_000
PLATES = 24
PLATE_THICKNESS_M = 0.02
# Damping ratio of the head on its spring: it comes to rest between contacts and takes 0.1 % of a bounce.
HEAD_DAMPING = 0.01
HARD = 'solref="0.001 1" solimp="0.99 0.999 0.0001" condim="3"'


class Scene:
    """What is docked. Lengths in m, masses in kg, x is the closing direction of an untouched approach.

    start       X Y Z of the flange, A B C (rad) are 0
    tip         head of the probe in the flange's frame; the sensor is there too
    head        mass_kg, radius_m, stiffness_n_per_m
    friction    coefficient
    wall_x      of a wall across x; or
    cone        seat (X Y Z), half_angle_rad, mouth_radius_m
    bodies      k, q: mass_kg, inertia_kg_m2 (three), velocity_m_s, position_m (from k's; only q)
    cycles      of 4 ms
    """

    def __init__(self, values):
        self.__dict__.update(values)
        self.tip, self.start = numpy.array(values["tip"]), numpy.array(values["start"])
        head = values["head"]
        self.stiffness, self.radius, self.mass = head["stiffness_n_per_m"], head["radius_m"], head["mass_kg"]
        self.damping = 2.0 * HEAD_DAMPING * math.sqrt(self.stiffness * self.mass)

    def surfaces(self, origin):
        """Geoms of the target, places relative to `origin`."""
        if "wall_x" in self.__dict__:
            x = self.wall_x - origin[0] + 0.05
            return f'<geom type="box" pos="{x} {-origin[1]} {-origin[2]}" size="0.05 5 5" {self.contact()}/>'
        return "".join(self.plate(j, origin) for j in range(PLATES))

    def contact(self):
        return f'{HARD} friction="{self.friction} 0 0" mass="0"'

    def plate(self, number, origin):
        """One of the boxes whose inner faces touch the cone along their middle lines."""
        cone, angle = self.cone, 2.0 * math.pi * number / PLATES
        sin, cos = math.sin(cone["half_angle_rad"]), math.cos(cone["half_angle_rad"])
        outwards = numpy.array([0.0, math.cos(angle), math.sin(angle)])
        along = cos * numpy.array([-1.0, 0.0, 0.0]) + sin * outwards
        inwards = -sin * numpy.array([1.0, 0.0, 0.0]) - cos * outwards
        apex = numpy.array(cone["seat"]) + [self.radius / sin, 0.0, 0.0]
        half_length = 0.5 * cone["mouth_radius_m"] / sin
        width = 1.05 * cone["mouth_radius_m"] * math.tan(math.pi / PLATES)
        center = apex + along * half_length - inwards * 0.5 * PLATE_THICKNESS_M - origin
        turned = numpy.column_stack([along, numpy.cross(inwards, along), inwards])
        quaternion = numpy.zeros(4)
        mujoco.mju_mat2Quat(quaternion, turned.flatten())
        place, quaternion = (" ".join(map(str, v)) for v in (center, quaternion))
        size = f"{half_length} {width} {0.5 * PLATE_THICKNESS_M}"
        return f'<geom type="box" pos="{place}" quat="{quaternion}" size="{size}" {self.contact()}/>'

    def spring(self):
        return f'stiffness="{self.stiffness}" damping="{self.damping}"'

    def head_geom(self):
        return (f'<geom name="head" type="sphere" size="{self.radius}" mass="{self.mass}" {HARD} '
                f'friction="{self.friction} 0 0"/>')

    def model(self, target, probe):
        return mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <option timestep="{STEP_S}" gravity="0 0 0" integrator="RK4" cone="elliptic" impratio="10" tolerance="1e-12"/>
  <worldbody>{target}{probe}</worldbody>
</mujoco>""")


def slides(extra):
    return "".join(f'<joint name="{name}" type="slide" axis="{axis}" {extra}/>'
                   for name, axis in zip("xyz", ("1 0 0", "0 1 0", "0 0 1")))


def rotation(abc):
    """KUKA's A, B, C: about z, then the new y, then the new x; rad."""
    (a, b, c), (cos, sin) = abc, (math.cos, math.sin)
    z = [[cos(a), -sin(a), 0], [sin(a), cos(a), 0], [0, 0, 1]]
    y = [[cos(b), 0, sin(b)], [0, 1, 0], [-sin(b), 0, cos(b)]]
    x = [[1, 0, 0], [0, cos(c), -sin(c)], [0, sin(c), cos(c)]]
    return numpy.array(z) @ numpy.array(y) @ numpy.array(x)


class Touch:
    """When the head was first pushed, until when, and how hard."""

    def __init__(self):
        self.touched = self.parted = None
        self.peak, self.impulse = 0.0, numpy.zeros(3)

    def see(self, time_s, force, touching):
        """The spring's force on the flange; it parts when the spring lets go, whatever the light head
        does then."""
        if self.touched is None and touching:
            self.touched = time_s
        if self.touched is None or self.parted is not None:
            return
        self.peak = max(self.peak, numpy.linalg.norm(force))
        self.impulse += force
        if time_s > self.touched + CYCLE_S and force @ self.impulse <= 0.0:
            self.parted = time_s

    def values(self):
        return {"touched": self.touched, "parted": self.parted, "peak": self.peak}


class Rig:
    """The flange is moved; the head hangs on it by three springs."""

    def __init__(self, scene):
        self.scene, self.pose, self.touch = scene, numpy.append(scene.start, [0.0] * 3), Touch()
        # A body of the world whose springs are told where the flange carries their rest.
        self.model = scene.model(scene.surfaces(numpy.zeros(3)), f"<body>{slides(scene.spring())}{scene.head_geom()}</body>")
        self.data = mujoco.MjData(self.model)
        self.data.qpos[:] = self.rest()

    def rest(self):
        return self.pose[:3] + rotation(self.pose[3:]) @ self.scene.tip

    def advance(self, velocity):
        """A cycle with a velocity of X Y Z (m/s) and A B C (rad/s)."""
        for _ in range(STEPS_PER_CYCLE):
            before = self.rest()
            self.pose += STEP_S * velocity
            rest = self.rest()
            moving = (rest - before) / STEP_S
            # The mean rest of the step, for the flange moves while the head does; and a damper that is
            # dragged along, not one to the world.
            self.model.qpos_spring[:] = 0.5 * (before + rest)
            self.data.qfrc_applied[:] = self.scene.damping * moving
            mujoco.mj_step(self.model, self.data)
            force = self.scene.stiffness * (self.data.qpos - rest)
            self.touch.see(self.data.time, force, self.data.ncon > 0)

    def wrench(self):
        """On the sensor, about the head's rest, in axes of the flange: N and N m."""
        force = self.scene.stiffness * (self.data.qpos - self.rest())
        torque = numpy.zeros(3)
        if self.data.ncon:
            places = [contact.pos - self.data.qpos for contact in self.data.contact]
            torque = numpy.cross(numpy.mean(places, axis=0), force)
        flange_from_world = rotation(self.pose[3:]).T
        return [*(flange_from_world @ force), *(flange_from_world @ torque)]


def free(scene):
    """Both spacecraft fly."""
    k, q = scene.bodies["k"], scene.bodies["q"]

    def body(values, place, geoms, inner=""):
        inertia = " ".join(map(str, values["inertia_kg_m2"]))
        place = " ".join(map(str, place))
        return (f'<body pos="{place}"><freejoint/><inertial pos="0 0 0" mass="{values["mass_kg"]}" '
                f'diaginertia="{inertia}"/>{geoms}{inner}</body>')

    tip = " ".join(map(str, scene.tip))
    head = f'<body pos="{tip}">{slides(scene.spring())}{scene.head_geom()}</body>'
    if q is None:
        target = scene.surfaces(numpy.zeros(3))
    else:
        origin = scene.start + q["position_m"]
        target = body(q, origin, scene.surfaces(origin))
    model = scene.model(target, body(k, scene.start, "", head))
    data = mujoco.MjData(model)
    first = 0 if q is None else 6
    data.qvel[first:first + 3] = k["velocity_m_s"]
    touch, joints = Touch(), [model.joint(name) for name in "xyz"]
    for _ in range(scene.cycles * STEPS_PER_CYCLE):
        mujoco.mj_step(model, data)
        stretch = numpy.array([data.qpos[joint.qposadr[0]] for joint in joints])
        touch.see(data.time, scene.stiffness * stretch, data.ncon > 0)
    return touch.values() | {"k": list(data.qvel[first:first + 6]), "q": list(data.qvel[:first])}


class Shown:
    """What the sensor shows, and how often it was asked since."""

    def __init__(self):
        self.changed, self.gauges, self.requests, self.ended = threading.Condition(), [0] * 6, 0, False

    def take(self):
        with self.changed:
            self.requests += 1
            self.changed.notify_all()
            return self.gauges

    def show(self, gauges):
        """Waits until a reading has certainly been taken: the first request may be older."""
        with self.changed:
            self.gauges, self.requests = gauges, 0
            if not self.changed.wait_for(lambda: self.requests >= 2 or self.ended, timeout=60.0) or self.ended:
                sys.exit("mujoco: the board does not ask for readings")


# The sensor's registers: it computes the wrench itself, in N and N m.
COUNTS_PER_UNIT = 50


def sense(channel, shown):
    """Serves the sensor until the board goes."""
    import can  # only where a board is
    import sensor as ati

    ati.MATRIX = [[float(row == column) for column in range(6)] for row in range(6)]
    ati.COUNTS_PER_FORCE = ati.COUNTS_PER_TORQUE = COUNTS_PER_UNIT
    ati.POUND_FORCE_CODE, ati.POUND_FORCE_INCH_CODE = 2, 3  # the codes of N and N m
    device = ati.Sensor(0x20)
    device.reading = shown.take
    ready = threading.Event()

    def serve():
        try:
            with can.Bus(interface="slcan", channel=channel, bitrate=1_000_000, sleep_after_open=0) as bus:
                ready.set()
                ati.serve(device, bus, threading.Event())
        except can.CanError:
            with shown.changed:
                shown.ended = True
                shown.changed.notify_all()

    threading.Thread(target=serve, daemon=True).start()
    ready.wait(60.0)


def axes(tag, pose):
    values = [*(1e3 * pose[:3]), *numpy.degrees(pose[3:])]
    return f"<{tag} " + " ".join(f'{name}="{v:.6f}"' for name, v in zip("XYZABC", values)) + "/>"


def dock(scene, robot, channel):
    """Is robot and sensor of a board."""
    rig, shown = Rig(scene), Shown()
    sense(channel, shown)
    host, port = robot.rsplit(":", 1)
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    line.connect((host, int(port)))
    line.settimeout(60.0)
    start = axes("RSol", rig.pose)
    for cycle in range(scene.cycles):
        ipoc = FIRST_IPOC + 4 * cycle
        shown.show([round(COUNTS_PER_UNIT * value) for value in rig.wrench()])
        telegram = f'<Rob Type="KUKA">{axes("RIst", rig.pose)}{start}<Delay D="0"/><IPOC>{ipoc}</IPOC></Rob>'
        line.send(telegram.encode())
        answer = ElementTree.fromstring(line.recv(2048))
        if int(answer.findtext("IPOC")) != ipoc:
            sys.exit(f"mujoco: expected an answer to {ipoc}, received {answer.findtext('IPOC')}")
        correction = [float(answer.find("RKorr").get(name)) for name in "XYZABC"]
        moved = [1e-3 * v for v in correction[:3]] + [math.radians(v) for v in correction[3:]]
        rig.advance(numpy.array(moved) / CYCLE_S)
    return rig.touch.values() | {"late": 0}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", help="the board's UDP address, such as 127.0.0.1:49152")
    parser.add_argument("--can", help="the board's SLCAN port, such as socket://127.0.0.1:29536")
    arguments = parser.parse_args()
    scene = Scene(json.loads(sys.stdin.readline()))
    board = arguments.robot is not None
    print(json.dumps(dock(scene, arguments.robot, arguments.can) if board else free(scene)), flush=True)


if __name__ == "__main__":
    main()
