//! Whole docking tests with a late robot, for the tests of laws.

use super::spacecraft::{CYCLE_S, Spacecraft};
use super::status::{LawFlags, LawStatus};
use super::{DelaySettings, Law, LawInput, LawName};
use crate::fault::Fault;
use crate::frames::{Pose, Wrench};
use nalgebra::{UnitQuaternion, Vector3};
use softdock_delay_plants::{
    Actuator, Contact, ForceLaw, Measurement, Plant, PlantSettings, Sample, Wall,
};

/// Cycles of the start ramp.
const RAMP: usize = 25;

/// A spacecraft of 500 kg that flies between walls, the robot that moves it, and the law.
pub(super) struct Docking {
    pub(super) law: Law<f64>,
    pub(super) plant: Plant,
    pub(super) spacecraft: Spacecraft,
    pub(super) sample: Sample,
    pub(super) commanded: Vector3<f64>,
    pub(super) cycle: usize,
    pub(super) status: LawStatus,
    pub(super) fault: Option<Fault>,
    /// Flags of all cycles so far.
    pub(super) seen: LawFlags,
}

/// A robot of 32 ms, which stands still for 16 ms where it turns.
pub(super) fn robot() -> Actuator {
    Actuator {
        delay_s: 0.032,
        pause_s: 0.016,
        ..Actuator::ideal()
    }
}

/// The settings of a law that knows this robot.
pub(super) fn believed(law: LawName, actuator: &Actuator) -> DelaySettings {
    let mut settings = DelaySettings {
        law,
        ..DelaySettings::default()
    };
    settings.actuator.delay_s = actuator.delay_s;
    settings.actuator.pause_s = actuator.pause_s;
    settings
}

/// Stiffness of the walls, N/m: 441/s² times 500 kg.
pub(super) const STIFFNESS: f64 = 220_500.0;

/// Walls across x at these places, m, facing the origin.
pub(super) fn walls(places: &[f64], damping: f64) -> Contact {
    let wall = |x: &f64| Wall {
        point: [*x, 0.0, 0.0],
        normal: [-x.signum(), 0.0, 0.0],
        law: ForceLaw::linear(STIFFNESS, damping),
    };
    Contact {
        probes: vec![[0.0; 3]],
        surfaces: places.iter().map(|x| wall(x).into()).collect(),
    }
}

impl Docking {
    pub(super) fn new(settings: &DelaySettings, plant: &PlantSettings, speed: f64) -> Self {
        let mut plant = Plant::new(plant);
        Self {
            law: Law::new(settings, CYCLE_S),
            sample: plant.first_sample(),
            plant,
            spacecraft: Spacecraft::before_a_wall([speed, 0.0, 0.0]),
            commanded: Vector3::zeros(),
            cycle: 0,
            status: LawStatus::default(),
            fault: None,
            seen: LawFlags::default(),
        }
    }

    pub(super) fn speed(&self) -> f64 {
        self.spacecraft.state.k.velocity.linear.x
    }

    /// One cycle as on the board: the model moves under the wrench that the law lets it feel, and the robot is sent what the law
    /// asks for.
    pub(super) fn step(&mut self) {
        let at =
            |position: Vector3<f64>| Pose::from_parts(position.into(), UnitQuaternion::identity());
        let [x, y, z, ..] = self.sample.position;
        let (measured, commanded) = (at(Vector3::new(x, y, z)), at(self.commanded));
        let wrench = Wrench::of(&self.sample.wrench);
        let share = (self.cycle as f64 / RAMP as f64).min(1.0);
        self.spacecraft.measured = measured;
        fn seen<'a>(
            of: LawInput<'a, f64>,
            commanded: &'a Pose<f64>,
            released: bool,
        ) -> LawInput<'a, f64> {
            LawInput {
                commanded,
                released,
                ..of
            }
        }
        if share >= 1.0 {
            let input = seen(self.spacecraft.input(&wrench), &commanded, true);
            let felt = self.law.condition(&input);
            self.spacecraft.state = self.spacecraft.bodies.step(&self.spacecraft.state, &felt).0;
        }
        let input = seen(self.spacecraft.input(&wrench), &commanded, share >= 1.0);
        let output = self.law.step(&input);
        let sent = output.command * share;
        self.spacecraft.sent.write(sent);
        let command = sent.linear;
        self.commanded += command * CYCLE_S;
        self.sample = self
            .plant
            .step([command.x, command.y, command.z, 0.0, 0.0, 0.0]);
        (self.status, self.cycle) = (output.status, self.cycle + 1);
        self.fault = self.fault.or(output.fault);
        self.seen.set(self.status.flags);
    }

    pub(super) fn run(&mut self, cycles: usize) {
        (0..cycles).for_each(|_| self.step());
    }

    /// Runs until the next contact is over, and some cycles more. Returns the speed after it over the speed before it.
    pub(super) fn bounce(&mut self) -> f64 {
        let before = self.speed();
        while !self.status.flags.has(LawFlags::CONTACT) {
            assert!(
                self.cycle < 5000 && self.fault.is_none(),
                "{:?}",
                self.fault
            );
            self.step();
        }
        while self.status.flags.has(LawFlags::CONTACT) {
            self.step();
        }
        self.run(30);
        -self.speed() / before
    }
}

/// Two walls 7.5 mm apart.
pub(super) fn between_walls(
    actuator: Actuator,
    damping: f64,
    measurement: Measurement,
) -> PlantSettings {
    PlantSettings {
        actuator,
        contact: walls(&[0.0045, -0.003], damping),
        measurement,
        ..PlantSettings::default()
    }
}
