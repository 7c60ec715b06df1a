//! `softdock calibrate`: the sensor's zero and the tool that it carries.

mod live;

use super::findings::Destination;
use super::{print, print_json, three_numbers};
use anyhow::{Context, Result, ensure};
use clap::{Args, Subcommand};
use serde::Serialize;
use softdock_app::settings::BoardSettings;
use softdock_commissioning::calibrate::plan::{PlannedPose, plan};
use softdock_commissioning::calibrate::source::{Mounting, one_after_the_other, unusable};
use softdock_commissioning::calibrate::{Ask, Calibration, WORST_CONDITION, calibrate, rests};
use softdock_commissioning::input::{Read, read};
use softdock_control::frames::orientation_from_abc;
use softdock_control::settings::SensorSettings;
use softdock_io::input;
use softdock_io::recording::Recording;
use softdock_io::say;
use softdock_report::{Cell, Column, Table, number};
use std::path::{Path, PathBuf};

/// Find out what the sensor carries and reads at rest.
#[derive(Debug, Args)]
pub(super) struct Calibrate {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    Sensor(Box<Sensor>),
}

impl Calibrate {
    pub(super) fn execute(self) -> Result<()> {
        match self.what {
            What::Sensor(sensor) => sensor.execute(),
        }
    }
}

/// Mass and centre of mass of the tool and the sensor's zero, from poses at rest.
///
/// Move the robot to six or more poses in which gravity points in different directions of the
/// sensor, rest for a second in each, and record. Poses in which somebody leaned on the tool are
/// found and left out.
#[derive(Debug, Args)]
#[command(after_help = "\
Example: softdock calibrate sensor --port /dev/ttyACM0 --into board.toml
(says to which pose to move the robot next, takes it when the robot rests there, ends by itself)

softdock calibrate sensor --recording poses.mcap --into board.toml

softdock calibrate sensor --recording pose-*.mcap --into board.toml
(one recording for each pose)

softdock calibrate sensor --plan --settings board.toml
(prints poses to move to, in a safe order, and what each adds)

softdock calibrate sensor --recording log.csv --mapping mapping.toml --report calibration.html
(a table of another program; the mapping says which column is what)

softdock calibrate sensor --recording jog.mcap --inertia -o sensor.toml
(all readings of a motion, for the tool's inertia)")]
struct Sensor {
    /// Recording (MCAP), or a table or folder that `softdock import` reads; several, of a pose each,
    /// count as one
    #[arg(long, value_name = "PATH", num_args = 1..)]
    recording: Vec<PathBuf>,
    /// What the columns of a table are (TOML)
    #[arg(long, value_name = "FILE.toml", requires = "recording")]
    mapping: Option<PathBuf>,
    /// Print poses to move to instead
    #[arg(long, conflicts_with = "recording")]
    plan: bool,
    /// Pose from which the plan starts: A, B, C of the flange, degrees
    #[arg(
        long,
        value_name = "A,B,C",
        value_parser = three_numbers,
        allow_hyphen_values = true,
        requires = "plan"
    )]
    from_abc_deg: Option<[f64; 3]>,
    /// How far a plan tilts the tool, degrees
    #[arg(long, default_value_t = 60.0, conflicts_with = "recording")]
    tilt_deg: f64,
    /// Settings with the sensor's place on the flange and gravity, instead of the recording's
    #[arg(long, value_name = "BOARD.toml")]
    settings: Option<PathBuf>,
    /// Gravity in the robot's base, m/s², instead of the settings'
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = three_numbers,
        allow_hyphen_values = true
    )]
    gravity: Option<[f64; 3]>,
    /// Find the direction of gravity, too: a robot on a tilted base
    #[arg(long)]
    estimate_gravity: bool,
    /// Each row of the recording is a pose at rest, as in a table of means
    #[arg(long)]
    at_rest: bool,
    /// Take all readings with their motion, and find the tool's inertia
    #[arg(long, conflicts_with = "at_rest")]
    inertia: bool,
    #[command(flatten)]
    live: live::Options,
    #[command(flatten)]
    to: Destination,
}

#[derive(Serialize)]
struct Plan {
    poses: Vec<PlannedPose>,
}

impl Sensor {
    fn execute(self) -> Result<()> {
        if self.plan {
            return self.print_plan();
        }
        let inputs: Vec<&Path> = self.recording.iter().map(PathBuf::as_path).collect();
        self.to.check(&inputs)?;
        ensure!(
            !self.recording.is_empty() || self.live.port.is_some(),
            "what shall be calibrated? A sensor that is there: --port /dev/ttyACM0 or --port tcp:127.0.0.1:29537; \
             recorded poses: --recording POSES.mcap; poses to move to: --plan"
        );
        if let Some(port) = &self.live.port {
            return self.calibrate_live(port);
        }
        let found = self.calibrated(&self.read()?)?;
        self.give(&found, &self.origin())
    }

    /// Zero and tool as the recordings determine them.
    fn calibrated(&self, all: &[Read]) -> Result<Calibration> {
        let first = all.first();
        let sensor = self.sensor(first)?;
        let at_rest = |read: &Read| read.model.as_ref().is_some_and(|m| m.sensor.at_rest);
        let ask = Ask {
            gravity_m_s2: sensor.gravity_m_s2,
            estimate_gravity: self.estimate_gravity,
            at_rest: self.at_rest || first.is_some_and(at_rest),
            inertia: self.inertia,
        };
        let readings = one_after_the_other(all.iter().map(|read| &read.recording))?;
        let mut found = calibrate(&readings, &Mounting::new(&sensor), &ask)?;
        for read in all {
            found.notes.extend(unusable(&read.recording)?);
        }
        if all.len() > 1 && !ask.at_rest && !ask.inertia {
            found.notes.extend(self.without_a_pose(all)?);
        }
        let unseen: Vec<&Recording> = all.iter().filter_map(|r| r.unseen.as_ref()).collect();
        if !unseen.is_empty() {
            found.judge(&one_after_the_other(unseen)?, ask.at_rest)?;
        }
        if sensor.gravity_torque_n_m != [0.0; 3] {
            found.notes.push(
                "The settings have a `gravity_torque_n_m` beside the centre of mass: it becomes zero, as the \
                 centre of mass that was found holds it already."
                    .to_owned(),
            );
        }
        Ok(found)
    }

    /// A sentence for each recording in which the robot never rests, where each is meant to hold one pose.
    fn without_a_pose(&self, all: &[Read]) -> Result<Vec<String>> {
        let mut told = Vec::new();
        for (path, read) in self.recording.iter().zip(all) {
            if rests(&one_after_the_other([&read.recording])?).is_empty() {
                told.push(format!("{} holds no pose.", path.display()));
            }
        }
        Ok(told)
    }

    /// Which recordings the answer comes from, in words.
    fn origin(&self) -> String {
        match self.recording.as_slice() {
            [first, .., last] => format!(
                "{} recordings, {} to {}",
                self.recording.len(),
                first.display(),
                last.display()
            ),
            one => one.iter().map(|path| path.display().to_string()).collect(),
        }
    }

    /// Reads all recordings. An error if they differ in the sensor's mounting or in gravity and no settings decide.
    fn read(&self) -> Result<Vec<Read>> {
        let read = |path: &PathBuf| read(path, self.mapping.as_deref());
        let all: Vec<Read> = self.recording.iter().map(read).collect::<Result<_>>()?;
        let place = |read: &Read| -> Result<([f64; 3], [f64; 4], [f64; 3])> {
            let sensor = self.sensor(Some(read))?;
            Ok((
                sensor.position_m,
                sensor.orientation_wxyz,
                sensor.gravity_m_s2,
            ))
        };
        for (path, read) in self.recording.iter().zip(&all) {
            for note in &read.notes {
                say!("warning: {}: {note}", path.display());
            }
            ensure!(
                place(read)? == place(&all[0])?,
                "{} was recorded with another place of the sensor or another gravity than {}: say \
                 with --settings which is right",
                path.display(),
                self.recording[0].display()
            );
        }
        Ok(all)
    }

    /// Writes and prints the calibration.
    fn give(&self, found: &Calibration, origin: &str) -> Result<()> {
        for remark in found.remarks() {
            say!("note: {remark}");
        }
        let text = format!(
            "{}\n\n{}\n\n{}\nCondition number of the poses: {}; at most {WORST_CONDITION:.0} is accepted.\n",
            found.sentence(),
            found.table(),
            found.residual_table(),
            number::significant(found.condition, 2)
        );
        let page = || crate::pages::calibration::page(found, origin);
        self.to.give(found, &found.fragment(origin), page, &text)
    }

    /// The sensor's mounting and gravity: from the settings on the command line, else from the recording, else from the
    /// recording's model.
    fn sensor(&self, read: Option<&Read>) -> Result<SensorSettings> {
        let mut sensor = match (self.settings.as_ref().or(self.to.into.as_ref()), read) {
            (Some(path), _) => {
                let board: BoardSettings = input::load(path)?;
                board
                    .validate()
                    .with_context(|| path.display().to_string())?;
                board.control.sensor
            }
            (None, Some(read)) if !read.recording.header.settings_toml.trim().is_empty() => {
                read.recording.header.control_settings()?.sensor
            }
            (
                None,
                Some(Read {
                    model: Some(model), ..
                }),
            ) => model.sensor_settings(),
            _ => SensorSettings::default(),
        };
        sensor.gravity_m_s2 = self.gravity.unwrap_or(sensor.gravity_m_s2);
        Ok(sensor)
    }

    fn print_plan(&self) -> Result<()> {
        let sensor = self.sensor(None)?;
        let abc = self.from_abc_deg.unwrap_or_default();
        let start = orientation_from_abc::<f64>(&abc.map(f64::to_radians));
        let poses = plan(
            &start,
            &Mounting::new(&sensor),
            sensor.gravity_m_s2,
            self.tilt_deg.to_radians(),
        )?;
        if self.to.json {
            return print_json(&Plan { poses });
        }
        let mut table = Table::new(vec![
            Column::number("Pose", ""),
            Column::number("A", "deg"),
            Column::number("B", "deg"),
            Column::number("C", "deg"),
            Column::text("Down, in the sensor"),
            Column::text("Adds"),
        ]);
        for (n, pose) in poses.iter().enumerate() {
            let mut row = vec![Cell::text((n + 1).to_string())];
            row.extend(pose.abc_deg.map(|a| Cell::text(number::fixed(a, 1))));
            let down = pose.down_in_s.map(|d| number::fixed(d, 2));
            row.push(Cell::text(down.join(", ")));
            row.push(Cell::text(&pose.adds));
            table.push(row);
        }
        print(&format!(
            "{table}\n\nTilts of {}° about horizontal axes, the flange point stays in place. Go there \
             slowly (T1), by way of the first pose where the direct way is not free, with cables and \
             hoses slack. Rest for a second in each pose with the hands off the tool, record all of \
             it, and give the recording to `softdock calibrate sensor --recording`.\n",
            self.tilt_deg
        ))
    }
}
