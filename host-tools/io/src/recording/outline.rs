//! Header and length of a recording from both ends of its file. To read all cycles of an hour would take seconds and
//! gigabytes.

use super::reader::{Loader, each_record};
use super::{Header, Recording};
use mcap::sans_io::linear_reader::LinearReaderOptions;
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use mcap::{McapError, McapResult, Summary};
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

/// Header and extent of a recording.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Description of the recording.
    pub header: Header,
    /// Why the file ended early; None if it is complete.
    pub cut: Option<String>,
    /// Number of cycles.
    pub cycles: usize,
    /// Largest minus smallest time, s. For a board's recording these are the times of its last and first cycle. In the file's
    /// summary negative times count as zero.
    pub duration_s: f64,
}

impl Outline {
    /// Outline of a recording in memory.
    pub fn of(recording: &Recording) -> Self {
        let mut times = recording.cycles.iter().map(|c| c.trace.time_s);
        let ends = times.clone().next().zip(times.next_back());
        Self {
            header: recording.header.clone(),
            cut: recording.cut.clone(),
            cycles: recording.cycles.len(),
            duration_s: ends.map_or(0.0, |(first, last)| last - first),
        }
    }

    /// Outline of a file that was properly ended. None of any other: reading all of it will show what happened to it.
    pub fn read(path: &Path) -> Option<Self> {
        let mut file = File::open(path).ok()?;
        let length = file.metadata().ok()?.len();
        let summary = summary(&mut file, length).ok()??;
        file.rewind().ok()?;
        let mut loader = Loader::default();
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_record_length_limit(usize::try_from(length).ok()?);
        each_record(options, &mut BufReader::new(file), |opcode, body| {
            loader.file_record(opcode, body)?;
            let enough = loader.header.is_some();
            Ok(enough.then_some(McapError::UnexpectedEof))
        })
        .ok()?;
        loader.outline(&summary)
    }
}

/// The summary section at the end of a file.
fn summary(file: &mut File, length: u64) -> McapResult<Option<Summary>> {
    let options = SummaryReaderOptions::default().with_file_size(length);
    let mut reader = SummaryReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event? {
            SummaryReadEvent::ReadRequest(wanted) => {
                let read = file.read(reader.insert(wanted))?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(file.seek(to)?),
        }
    }
    Ok(reader.finish())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::RecordingWriter;
    use softdock_app::record::CycleRecord;

    #[test]
    fn the_ends_of_a_file_say_what_its_cycles_say() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        let header = Header {
            settings_toml: "a = 1".to_owned(),
            ..Header::default()
        };
        let mut writer = RecordingWriter::create(&path, &header).unwrap();
        for n in 0..100 {
            let mut cycle = CycleRecord::default();
            cycle.trace.time_s = 7.0 + 0.004 * f64::from(n);
            writer.push(&cycle, None).unwrap();
        }
        writer.finish().unwrap();
        let read = Outline::of(&Recording::open(&path).unwrap());
        let outlined = Outline::read(&path).unwrap();
        assert_eq!((outlined.cycles, read.cycles), (100, 100));
        assert!((outlined.duration_s - read.duration_s).abs() < 1e-8);
        assert_eq!(
            (outlined.header, outlined.cut),
            (read.header, None::<String>)
        );

        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 100]).unwrap();
        assert!(Outline::read(&path).is_none());
        std::fs::write(&path, "no recording").unwrap();
        assert!(Outline::read(&path).is_none());
    }
}
