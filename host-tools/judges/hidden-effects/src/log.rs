//! One log: its rows, and the text of docking-rig-log/1.

use core::fmt::Write as _;

use nalgebra::{Quaternion, UnitQuaternion, Vector3, Vector6};

/// Column names in the order of the file.
pub const HEADER: &str = "t,mode,fx,fy,fz,tx,ty,tz,vcx,vcy,vcz,wcx,wcy,wcz,vex,vey,vez,\
wex,wey,wez,px,py,pz,qw,qx,qy,qz,vmx,vmy,vmz,wmx,wmy,wmz";

/// One tick of a log.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// Nominal time, s.
    pub(crate) t_s: f64,
    /// Whether the dynamics model closes the loop (mode 1).
    pub(crate) in_loop: bool,
    /// Raw reading in S, N and Nm.
    pub(crate) wrench: Vector6<f64>,
    /// Command, m/s in C and rad/s in M.
    pub(crate) command: Vector6<f64>,
    /// Executed velocity, in the same frames.
    pub(crate) executed: Vector6<f64>,
    /// Position of M in C, m.
    pub(crate) position: Vector3<f64>,
    /// Orientation of M in C, R_CM.
    pub(crate) rotation: UnitQuaternion<f64>,
    /// Output of the dynamics model, 0 in mode 0.
    pub(crate) model: Vector6<f64>,
}

/// Writes the rows with the decimals of the format: time 3, force 4, torque 5, velocity and position 7, quaternion 8.
pub(crate) fn to_csv(rows: &[Row]) -> String {
    let mut text = String::with_capacity(340 * (rows.len() + 1));
    text.push_str(HEADER);
    text.push('\n');
    for row in rows {
        // Writing to a String cannot fail.
        let _ = write!(text, "{:.3},{}", row.t_s, u8::from(row.in_loop));
        for i in 0..6 {
            let digits = if i < 3 { 4 } else { 5 };
            let _ = write!(text, ",{:.*}", digits, row.wrench[i]);
        }
        for block in [&row.command, &row.executed] {
            for value in block {
                let _ = write!(text, ",{value:.7}");
            }
        }
        for value in &row.position {
            let _ = write!(text, ",{value:.7}");
        }
        let q = row.rotation;
        let _ = write!(text, ",{:.8},{:.8},{:.8},{:.8}", q.w, q.i, q.j, q.k);
        for value in &row.model {
            let _ = write!(text, ",{value:.7}");
        }
        text.push('\n');
    }
    text
}

/// Reads the rows from the text of a log.
///
/// # Errors
/// The line and what is wrong with it.
pub(crate) fn from_csv(text: &str) -> Result<Vec<Row>, String> {
    let mut lines = text.lines();
    let header = lines.next().unwrap_or_default();
    if header != HEADER {
        return Err(format!(
            "line 1: expected the header {HEADER}, found {header}"
        ));
    }
    lines
        .enumerate()
        .map(|(i, line)| row(line).map_err(|what| format!("line {}: {what}", i + 2)))
        .collect()
}

fn row(line: &str) -> Result<Row, String> {
    let cells = line
        .split(',')
        .map(|cell| {
            cell.parse::<f64>()
                .map_err(|_| format!("expected a number, found `{cell}`"))
        })
        .collect::<Result<Vec<f64>, String>>()?;
    let found = cells.len();
    let c: [f64; 33] = cells
        .try_into()
        .map_err(|_| format!("expected 33 cells, found {found}"))?;
    let six = |first: usize| Vector6::from_fn(|i, _| c[first + i]);
    Ok(Row {
        t_s: c[0],
        in_loop: c[1] > 0.5,
        wrench: six(2),
        command: six(8),
        executed: six(14),
        position: Vector3::new(c[20], c[21], c[22]),
        rotation: UnitQuaternion::from_quaternion(Quaternion::new(c[23], c[24], c[25], c[26])),
        model: six(27),
    })
}
