//! The motion of a log with all quantities on which effects of the sensor's load depend.

use super::column::Column;
use super::guided::Guided;
use super::touch::Touch;
use super::turns::{Followed, angle_about, angles, pose_of, positions};
use super::{Docked, LoadModel, tip_motion};
use crate::model::prediction::signals::Step;
use crate::model::{Model, WrenchMeaning};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use softdock_control::frames::{self, Pose, Wrench, orientation_from_abc};
use softdock_control::wrench::Motion;
use softdock_io::recording::Beginning;
use softdock_mechanism::DockingSettings;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Motion, contact and nominal reading of every cycle of a log. What no effect changes is shared among copies.
#[derive(Clone)]
pub struct Scene {
    /// Cycle time, s.
    pub cycle_s: f64,
    /// Time of each cycle, s.
    pub time_s: Arc<[f64]>,
    /// Beginning of the log of which this is all or a part.
    began: Beginning,
    /// Pose of M in C.
    pub pose: Arc<[Pose<f64>]>,
    /// Velocity and acceleration of M.
    pub motion: Arc<[Motion<f64>]>,
    /// Orientation of C in M.
    pub m_from_c: Arc<[Matrix3<f64>]>,
    /// How each cycle follows the one before; empty if each is the next.
    steps: Arc<[Step]>,
    /// Contact with each wall.
    pub touches: Arc<[Touch]>,
    /// Wrench of the nominal docking mechanisms at M, in axes of M; empty without one.
    pub docked: Arc<[Wrench<f64>]>,
    /// Reading in S with the nominal parameters alone.
    nominal: Arc<Column>,
    /// Load of the sensor: the same with all known effects except those that act on the whole reading.
    pub(super) load: Column,
    /// Reading in S with the nominal parameters and all known effects.
    pub reading: Column,
    /// Zero of the sensor.
    pub bias: [f64; 6],
    /// Position of S in M.
    pub m_from_s: Pose<f64>,
    /// Origin of S in M, m.
    pub sensor: Vector3<f64>,
    /// Orientation of M in S.
    pub s_from_m: Matrix3<f64>,
    /// Free direction of the guide, in C; for a bearing its axis, in M.
    pub axis: Vector3<f64>,
    /// The log is of a rig, not of any machine.
    pub of_a_rig: bool,
    /// Axes of the reading that were measured.
    measured: [bool; 6],
    /// The wrench of the log changes: if it never does, its timing cannot be known.
    pub(super) wrench_changes: bool,
    /// Position along the guide, m; for a bearing the angle, rad.
    pub position: Arc<[f64]>,
    /// Acceleration along the guide, m/s² or rad/s².
    pub acceleration: Arc<[f64]>,
    /// The guided point, or the one that touches the first wall, in M, m.
    pub tip: Vector3<f64>,
    /// Motion along the guide of each point of action: M, tip, origin of the sensor.
    guided: Arc<[Guided; 3]>,
    /// The nominal model.
    pub model: Model,
}

/// The matrix of the inverse of a rotation.
fn turned_back(rotation: &UnitQuaternion<f64>) -> Matrix3<f64> {
    rotation.inverse().to_rotation_matrix().into_inner()
}

/// Point of action of forces, in M, and axis of the guide: of the guide, of the only axis that moves, of what docks, else x.
fn guided_by(model: &Model, load: &LoadModel) -> (Vector3<f64>, Vector3<f64>) {
    let docking = model.contact.docking.first();
    let tip = load.guide.as_ref().map(|guide| guide.tip);
    let tip = tip.or(load.walls.first().map(|wall| wall.tip));
    let tip = tip.or(docking.map(|docking| docking.tip_m.into()));
    let alone = match model.rig.active_axes[..] {
        [one] => Some(Vector3::ith(one.index() % 3, 1.0)),
        _ => None,
    };
    let axis = match (&load.guide, alone, docking) {
        (Some(guide), ..) => guide.axis,
        (None, Some(axis), _) => axis,
        (None, None, Some(docking)) => {
            orientation_from_abc::<f64>(&docking.orientation_abc_rad) * Vector3::x()
        }
        (None, None, None) => Vector3::x(),
    };
    (tip.unwrap_or_default(), axis)
}

impl Scene {
    /// Whether anything touches a wall at any time.
    pub fn touches_anything(&self) -> bool {
        let mut depths = self.touches.iter().flat_map(|touch| &touch.penetration);
        depths.any(|depth| *depth > 0.0)
    }

    /// Adds what the poses of a log do not contain. `by_velocity`: the rotation of a cycle since the one before by the velocity,
    /// rad; `wrench_changes`: the wrench of the log is not constant.
    pub fn of_log(
        mut self,
        of_a_rig: bool,
        whole_turns: i32,
        by_velocity: impl Fn(usize) -> Vector3<f64>,
        wrench_changes: bool,
        began: &Beginning,
    ) -> Self {
        self.of_a_rig = of_a_rig;
        self.began = *began;
        self.wrench_changes = wrench_changes;
        if self.model.bearing().is_some() {
            let turned = self.pose.iter().enumerate();
            let turned = turned.map(|(n, pose)| Followed {
                pose: *pose,
                by_velocity: by_velocity(n),
            });
            self.position = angles(turned, &self.axis, whole_turns).into();
        }
        self
    }

    /// Whether the axis of the bearing is parallel to gravity, so that nothing that turns about it is lifted.
    pub fn turns_upright(&self) -> bool {
        /// Largest sine of the angle between them: no log shows so small a share of a weight.
        const UPRIGHT: f64 = 1e-3;
        let gravity = Vector3::from(self.model.sensor.gravity_m_s2);
        let lifts = |pose: &Pose<f64>| (pose.rotation * self.axis).cross(&gravity).norm();
        let all = UPRIGHT * gravity.norm();
        self.model.bearing().is_some()
            && all > 0.0
            && self.pose.first().is_some_and(|pose| lifts(pose) < all)
    }

    /// Time of a cycle since the log began, s.
    pub fn since_began(&self, n: usize) -> f64 {
        self.time_s[n] - self.began.time_s
    }

    /// Position of a point of M at the beginning of the log, in C, m.
    pub(super) fn first_place_of(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let first = pose_of(&self.began.pose);
        first.translation.vector + first.rotation * point
    }

    /// Position along the guide, m, or about the bearing, rad, at the beginning of the log.
    pub fn first_position(&self) -> f64 {
        match self.model.bearing() {
            Some(_) => self.first_angle(),
            None => self.axis.dot(&self.first_place_of(&Vector3::zeros())),
        }
    }

    /// Angle of a bearing at the beginning of the log, rad.
    pub(super) fn first_angle(&self) -> f64 {
        let first = pose_of(&self.began.pose);
        angle_about(&first, &self.axis) + TAU * f64::from(self.began.whole_turns)
    }

    /// From a motion without gaps.
    pub fn new(
        model: &Model,
        cycle_s: f64,
        time_s: Vec<f64>,
        pose: Vec<Pose<f64>>,
        motion: Vec<Motion<f64>>,
    ) -> Self {
        Self::of_steps(model, cycle_s, time_s, pose, motion, Vec::new())
    }

    /// From a motion, and how its cycles follow each other.
    pub fn of_steps(
        model: &Model,
        cycle_s: f64,
        time_s: Vec<f64>,
        pose: Vec<Pose<f64>>,
        motion: Vec<Motion<f64>>,
        steps: Vec<Step>,
    ) -> Self {
        let load = LoadModel::new(model);
        let walls = load.walls.iter().zip(1..);
        let touches = walls
            .map(|(wall, number)| Touch::of(wall, number, &pose, &motion))
            .collect();
        let m_from_c = pose.iter().map(|p| turned_back(&p.rotation)).collect();
        let docked = Docked::along(&model.contact.docking, cycle_s, &pose, &motion, &steps);
        let nominal = Column::of(pose.len(), |n| {
            (load.wrench(&pose[n], &motion[n]) + load.docked(&docked, n)).get()
        });
        let (tip, axis) = guided_by(model, &load);
        let began = Beginning {
            time_s: time_s.first().copied().unwrap_or(0.0),
            pose: pose.first().map_or([0.0; 7], frames::pose_components),
            whole_turns: 0,
        };
        let scene = Self {
            cycle_s,
            touches,
            steps: steps.into(),
            docked: docked.into(),
            m_from_c,
            reading: nominal.clone(),
            load: nominal.clone(),
            nominal: nominal.into(),
            bias: model.sensor.bias,
            of_a_rig: true,
            measured: [true; 6],
            wrench_changes: true,
            m_from_s: load.m_from_s,
            sensor: load.m_from_s.translation.vector,
            s_from_m: turned_back(&load.m_from_s.rotation),
            tip,
            axis,
            position: Arc::default(),
            acceleration: Arc::default(),
            guided: Arc::default(),
            model: model.clone(),
            time_s: time_s.into(),
            began,
            pose: pose.into(),
            motion: motion.into(),
        };
        scene.along_guide()
    }

    /// Adds the motion along the guide, or about the bearing.
    fn along_guide(mut self) -> Self {
        self.position = match self.model.bearing() {
            Some(_) => angles(self.pose.iter().copied().map(Followed::from), &self.axis, 0).into(),
            None => positions(&self.pose, &self.axis).into(),
        };
        self.acceleration = self.accelerations();
        self.guided = Arc::new(std::array::from_fn(|choice| self.guided_at(choice as f64)));
        self
    }

    /// The same motion with a model that differs only in effects on the reading and in the zero of the sensor.
    pub fn with_model(&self, model: &Model) -> Self {
        let by = std::array::from_fn(|axis| model.sensor.bias[axis] - self.bias[axis]);
        let mut scene = Self {
            model: model.clone(),
            bias: model.sensor.bias,
            ..self.clone()
        };
        let count = scene.len();
        let nominal = Arc::make_mut(&mut scene.nominal);
        for column in [nominal, &mut scene.load, &mut scene.reading] {
            column.shift(count, by);
        }
        scene
    }

    /// Sets the axes that the sensor measures; the reading of the others is zero, whatever loads them.
    pub fn with_sensor(mut self, measured: [bool; 6]) -> Self {
        self.measured = measured;
        self
    }

    /// The reading on the measured axes alone.
    pub fn on_measured_axes(&self, mut reading: Column) -> Column {
        let hidden = reading.0.iter_mut().zip(self.measured);
        hidden
            .filter(|(_, measured)| !measured)
            .for_each(|(series, _)| series.clear());
        reading
    }

    fn accelerations(&self) -> Arc<[f64]> {
        let along = |motion: &Motion<f64>| match self.model.bearing() {
            Some(_) => self.axis.dot(&motion.acceleration.angular),
            None => self.axis.dot(&motion.acceleration.linear),
        };
        self.motion.iter().map(along).collect()
    }

    fn guided_at(&self, acts_at: f64) -> Guided {
        if self.model.bearing().is_some() {
            let along = |motion: &Motion<f64>| self.axis.dot(&motion.velocity.angular);
            let torque = self.s_from_m * self.axis;
            let unit = Column::of(self.len(), |_| {
                [0.0, 0.0, 0.0, torque.x, torque.y, torque.z]
            });
            let velocity = self.motion.iter().map(along).collect();
            return Guided::new(velocity, unit, self.cycle_s);
        }
        let at = self.point_of_action(acts_at);
        let along = |n| self.axis.dot(&self.point(n, &at).1);
        let unit = Column::of(self.len(), |n| self.reading_of(n, &at, &self.axis));
        Guided::new((0..self.len()).map(along).collect(), unit, self.cycle_s)
    }

    fn guided(&self, acts_at: f64) -> &Guided {
        let [centre, tip, sensor] = &*self.guided;
        match acts_at as i64 {
            1 => tip,
            2 => sensor,
            _ => centre,
        }
    }

    /// Motion of a point of M in C per motion along the guide; for a bearing per angle, m/rad.
    pub(super) fn way_of(&self, n: usize, point: &Vector3<f64>) -> Vector3<f64> {
        match self.model.bearing() {
            Some(_) => self.pose[n].rotation * self.axis.cross(point),
            None => self.axis,
        }
    }

    /// Number of cycles.
    pub fn len(&self) -> usize {
        self.pose.len()
    }

    /// Whether there are no cycles.
    pub fn is_empty(&self) -> bool {
        self.pose.is_empty()
    }

    /// Whether the nominal parameters alone load the sensor: its zero is no load.
    pub fn has_nominal_load(&self) -> bool {
        let axes = self.nominal.0.iter().zip(self.bias).zip(self.measured);
        let loaded = |axis: &[f64], zero: f64| axis.iter().any(|r| (r - zero).abs() > 0.0);
        axes.into_iter()
            .any(|((axis, zero), measured)| measured && loaded(axis, zero))
    }

    /// Change of the reading by the effects of the model file.
    pub fn change_by_known_effects(&self) -> Column {
        self.on_measured_axes(self.reading.clone().minus(&self.nominal))
    }

    /// Reading of a force in C on a point of M.
    pub fn reading_of(&self, n: usize, point: &Vector3<f64>, force_c: &Vector3<f64>) -> [f64; 6] {
        let force = self.m_from_c[n] * force_c;
        let torque = (point - self.sensor).cross(&force);
        let (force, torque) = (self.s_from_m * force, self.s_from_m * torque);
        [force.x, force.y, force.z, torque.x, torque.y, torque.z]
    }

    /// A point of M: 0 its origin, 1 the tip, 2 the origin of the sensor.
    pub fn point_of_action(&self, choice: f64) -> Vector3<f64> {
        match choice as i64 {
            1 => self.tip,
            2 => self.sensor,
            _ => Vector3::zeros(),
        }
    }

    /// Velocity along the guide of the point where its force acts, m/s.
    pub fn along(&self, n: usize, acts_at: f64) -> f64 {
        self.guided(acts_at).velocity[n]
    }

    /// The largest rms velocity along the guide of any possible point of action, m/s.
    pub fn rms_speed(&self) -> f64 {
        self.guided
            .iter()
            .map(|at| at.rms_speed)
            .fold(0.0, f64::max)
    }

    /// The largest usual stroke of any possible point of action, m or rad.
    pub fn usual_stroke(&self) -> f64 {
        let each = self.guided.iter().map(|at| at.usual_stroke);
        each.fold(0.0, f64::max)
    }

    /// Whether the log alone determines the amounts of effects. Under a load that never changes, a friction in one direction
    /// equals it, whatever other effects there are.
    pub fn tells_amounts(&self) -> bool {
        self.wrench_changes || self.model.sensor.wrench == WrenchMeaning::Free
    }

    /// Column of a force along the guide, N in its positive direction, that acts at point `acts_at`.
    pub fn guide_force(&self, acts_at: f64, force: impl FnMut(usize) -> f64) -> Column {
        let sizes: Vec<f64> = (0..self.len()).map(force).collect();
        if sizes.iter().all(|size| *size == 0.0) {
            return Column::default();
        }
        let unit = &self.guided(acts_at).unit;
        let times = |series: &Vec<f64>| series.iter().zip(&sizes).map(|(u, s)| u * s).collect();
        Column(unit.0.each_ref().map(times))
    }

    /// Column of a force out of every wall on the tip, given touch and cycle.
    pub fn wall_force(&self, mut force: impl FnMut(&Touch, usize) -> f64) -> Column {
        self.force_of_walls(|touch, n| touch.normal * force(touch, n))
    }

    /// Column of any force of every wall on the tip, in C, given touch and cycle.
    pub fn force_of_walls(&self, mut force: impl FnMut(&Touch, usize) -> Vector3<f64>) -> Column {
        Column::of(self.len(), |n| {
            let mut sum = [0.0; 6];
            for touch in self.touches.iter() {
                let force = force(touch, n);
                if force != Vector3::zeros() {
                    let reading = self.reading_of(n, &touch.tip, &force);
                    sum.iter_mut().zip(reading).for_each(|(s, r)| *s += r);
                }
            }
            sum
        })
    }

    /// Change of the nominal reading if the model had other parameters.
    pub fn change(&self, model: &Model, factor: f64) -> Column {
        let (load, docked) = (LoadModel::new(model), self.docked_of(model));
        Column::of(self.len(), |n| {
            let other = load.wrench(&self.pose[n], &self.motion[n]) + load.docked(&docked, n);
            let mut six = other.get();
            for (axis, value) in six.iter_mut().enumerate() {
                *value = factor * (*value - self.nominal.at(axis, n));
            }
            six
        })
    }

    /// Difference of the readings of two models.
    pub fn difference(&self, from: &Model, to: &Model, factor: f64) -> Column {
        let of = |model: &Model| (LoadModel::new(model), self.docked_of(model).into_owned());
        let (from, to) = (of(from), of(to));
        Column::of(self.len(), |n| {
            let reading = |(load, docked): &(LoadModel, Vec<Wrench<f64>>)| {
                (load.wrench(&self.pose[n], &self.motion[n]) + load.docked(docked, n)).get()
            };
            let (a, b) = (reading(&from), reading(&to));
            std::array::from_fn(|axis| factor * (b[axis] - a[axis]))
        })
    }

    /// Wrench of the docking mechanisms of another model at M; it is recomputed only if they differ.
    fn docked_of(&self, model: &Model) -> Cow<'_, [Wrench<f64>]> {
        if model.contact.docking == self.model.contact.docking {
            return Cow::Borrowed(&self.docked);
        }
        let docking = &model.contact.docking;
        Cow::Owned(Docked::along(
            docking,
            self.cycle_s,
            &self.pose,
            &self.motion,
            &self.steps,
        ))
    }

    /// Change of the reading with other docking mechanisms.
    pub fn docked_change(&self, settings: &[DockingSettings]) -> Column {
        if settings == self.model.contact.docking {
            return Column::default();
        }
        let s_from_m = self.m_from_s.inverse();
        let other = Docked::along(
            settings,
            self.cycle_s,
            &self.pose,
            &self.motion,
            &self.steps,
        );
        Column::of(self.len(), |n| match (other.get(n), self.docked.get(n)) {
            (Some(other), Some(nominal)) => (*other - *nominal).transferred(&s_from_m).get(),
            _ => [0.0; 6],
        })
    }

    /// Position and velocity of a point of M in C.
    pub fn point(&self, n: usize, point: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        tip_motion(&self.pose[n], &self.motion[n].velocity, point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::load::effects::LoadEffect;
    use softdock_control::frames::Twist;
    use std::f64::consts::PI;

    /// A flange that points down and turns about its z: friction opposes the velocity, a spring the angle.
    #[test]
    fn a_bearing_of_a_flange_that_hangs_down_has_its_velocity_its_angle_and_its_torque_alike() {
        let mut model = Model::default();
        model.rig.active_axes = vec![crate::model::Axis::Rz];
        let down = UnitQuaternion::from_scaled_axis(Vector3::new(PI, 0.0, 0.0));
        let pose = (0..10).map(|n| {
            let turn =
                UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, 0.01 * f64::from(n)));
            Pose::from_parts(Vector3::zeros().into(), down * turn)
        });
        let motion = Motion {
            velocity: Twist::of(&[0.0, 0.0, 0.0, 0.0, 0.0, 2.5]),
            acceleration: Twist::zero(),
        };
        let time_s = (0..10).map(|n| 0.004 * f64::from(n)).collect();
        let scene = Scene::new(&model, 0.004, time_s, pose.collect(), vec![motion; 10]);
        let torque = scene.guide_force(0.0, |n| scene.along(n, 0.0));
        assert!((scene.position[9] - scene.position[0] - 0.09).abs() < 1e-12);
        assert!((torque.at(5, 5) - 2.5).abs() < 1e-12);
    }

    /// About an upright axis nothing is lifted; about a horizontal one, or where the model has no gravity, a weight may be.
    #[test]
    fn a_weight_is_looked_for_unless_the_axis_stands_upright() {
        let is_tried = |gravity_m_s2: [f64; 3]| {
            let mut model = Model::default();
            model.rig.active_axes = vec![crate::model::Axis::Rx];
            model.sensor.gravity_m_s2 = gravity_m_s2;
            let motion = Motion {
                velocity: Twist::of(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
                acceleration: Twist::zero(),
            };
            let pose = (0..3).map(|n| {
                let turn = UnitQuaternion::from_scaled_axis(0.3 * f64::from(n) * Vector3::x());
                Pose::from_parts(Vector3::zeros().into(), turn)
            });
            let time_s = (0..3).map(|n| 0.3 * f64::from(n)).collect();
            let scene = Scene::new(&model, 0.3, time_s, pose.collect(), vec![motion; 3]);
            let weight = LoadEffect::find(&model, "bearing_gravity").unwrap();
            assert!(weight.acts(&scene), "what is in a model acts");
            weight.is_tried_on(&scene)
        };
        assert!(is_tried([0.0, 0.0, -9.81]) && is_tried([0.0; 3]));
        assert!(!is_tried([-9.81, 0.0, 0.0]));
    }

    /// Twice the gain with half the inertia and half the friction reads the same, unless something is known.
    #[test]
    fn a_gain_is_looked_for_where_a_load_is_known() {
        let is_tried = |mass_kg: f64| {
            let mut model = Model::default();
            model.tool.mass_kg = mass_kg;
            model.sensor.bias[0] = 3.0;
            let rest = Motion {
                velocity: Twist::zero(),
                acceleration: Twist::zero(),
            };
            let scene = Scene::new(
                &model,
                0.3,
                vec![0.0, 0.3],
                vec![Pose::identity(); 2],
                vec![rest; 2],
            );
            let gain = LoadEffect::find(&model, "ft_scale").unwrap();
            let crosstalk = LoadEffect::find(&model, "ft_crosstalk").unwrap();
            assert!(gain.acts(&scene), "what is in a model acts");
            assert!(
                crosstalk.is_tried_on(&scene),
                "other axes do not make up for it"
            );
            gain.is_tried_on(&scene)
        };
        assert!(is_tried(2.0) && !is_tried(0.0));
    }

    /// An arm of half a metre that turns against a wall: a push of 1 N has half a newton metre about the bearing, and the wall
    /// stands across the way of the tip.
    #[test]
    fn a_wall_before_an_arm_that_turns_stands_in_the_way_of_its_tip() {
        let text = "[rig]\nactive_axes = [\"rz\"]\n[[contact.walls]]\npoint_m = [0.0, 0.0, 0.0]\nnormal = [0.0, -1.0, 0.0]\n\
                    tip_m = [0.5, 0.0, 0.0]\nstiffness_n_per_m = 1e4\n";
        let model = Model::from_toml(text, "model").unwrap();
        let pose = |n: i32| {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * (0.001 * f64::from(n)));
            Pose::from_parts(Vector3::zeros().into(), turn)
        };
        let motion = Motion {
            velocity: Twist::of(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.25]),
            acceleration: Twist::zero(),
        };
        let time_s = (0..10).map(|n| 0.004 * f64::from(n)).collect();
        let scene = Scene::new(
            &model,
            0.004,
            time_s,
            (0..10).map(pose).collect(),
            vec![motion; 10],
        );
        let touch = &scene.touches[0];
        let torque = touch.force[9] * touch.normal.dot(&scene.way_of(9, &touch.tip));
        assert!(
            (torque - scene.reading.at(5, 9)).abs() < 1e-9 && torque < -10.0,
            "{torque}"
        );
        let shifted = LoadEffect::find(&model, "wall_position").unwrap();
        let part = shifted.contribution(&scene, &[("shift_m".to_owned(), 0.001)].into());
        assert!(part.at(5, 9) > 4.9, "{}", part.at(5, 9));
    }
}
