//! The folder of a campaign, into which other machines and programs write.

use super::Script;
use softdock_experiments::campaign::merge::merge;
use softdock_experiments::campaign::outcome::Outcome;
use softdock_experiments::campaign::place::Place;
use softdock_experiments::campaign::plan::Plan;
use softdock_experiments::campaign::shard::Shard;
use softdock_experiments::campaign::status::progress;
use softdock_experiments::campaign::stored::StoredRow;
use softdock_experiments::campaign::table::table;
use softdock_experiments::scenario::SPRING_ROD;
use std::path::Path;

const CAMPAIGN: &str = r#"
scenario = "spring-rod.toml"
samples = 4
seed = 1

[[factors]]
setting = "board.control.body_k.velocity_m_s[0]"
uniform = [0.002, 0.02]
"#;
const PARTS: [Shard; 2] = [Shard { number: 0, of: 2 }, Shard { number: 1, of: 2 }];
const JOURNAL: &str = ".rows-1-of-2-77-0.journal";

/// After files were changed, cut off, renamed and added, the progress and the table are either returned or refused with an
/// error; a campaign counts as complete only if it has every row.
pub(super) fn campaign_folder(input: &[u8]) {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let plan = written(folder);
    let mut script = Script(input);
    while let Some(event) = script.byte() {
        let part = folder.join(PARTS[usize::from(event % 2)].part());
        match event / 2 % 6 {
            0 => change(&part, &mut script),
            1 => change(&folder.join("plan.json"), &mut script),
            2 => change(&folder.join(JOURNAL), &mut script),
            3 => cut(&part, &mut script),
            4 => {
                let name = format!("part-{}.parquet", name(&mut script));
                let _ = std::fs::rename(&part, folder.join(name));
            }
            _ => {
                let path = folder.join(name(&mut script));
                let _ = std::fs::write(path, script.piece().unwrap_or_default());
            }
        }
    }
    let place = Place::folder(folder);
    if let Ok(plan) = Plan::read(&place) {
        let done = progress(&plan, &place).map(|progress| progress.done);
        if merge(&plan, &place).is_ok() {
            assert_eq!(done.ok(), Some(plan.rows()));
        }
    }
    for row in 0..plan.rows() {
        let _ = StoredRow::find(&plan, &place, row);
    }
}

/// A campaign of four rows with one part, and another one that was stopped.
fn written(folder: &Path) -> Plan {
    let campaign = folder.join("campaign.toml");
    std::fs::write(folder.join("spring-rod.toml"), SPRING_ROD).unwrap();
    std::fs::write(&campaign, CAMPAIGN).unwrap();
    let plan = Plan::new(&campaign).unwrap();
    plan.write(&Place::folder(folder)).unwrap();
    for shard in PARTS {
        let rows = (0..plan.rows()).filter(|index| shard.has(*index));
        let rows: Vec<_> = rows.map(|index| (index, Outcome::default())).collect();
        let part = table(&plan, &rows);
        std::fs::write(folder.join(shard.part()), part.to_parquet().unwrap()).unwrap();
    }
    let head = format!("#plan {} {}\n1,completed,,750,1\n", plan.hash, plan.binary);
    std::fs::write(folder.join(JOURNAL), head).unwrap();
    plan
}

fn name(script: &mut Script<'_>) -> String {
    let piece = script.piece().unwrap_or_default();
    String::from_utf8_lossy(piece).replace(['/', '\0'], "_")
}

/// Changes some bytes of a file, counted from its end, where Parquet has its metadata.
fn change(path: &Path, script: &mut Script<'_>) {
    let Ok(mut bytes) = std::fs::read(path) else {
        return;
    };
    let from_end = usize::from(u16::from_le_bytes(script.bytes())) % (bytes.len() + 1);
    let at = bytes.len() - from_end;
    let piece = script.piece().unwrap_or_default();
    let end = (at + piece.len()).min(bytes.len());
    bytes.splice(at..end, piece.iter().copied());
    std::fs::write(path, bytes).unwrap();
}

fn cut(path: &Path, script: &mut Script<'_>) {
    let Ok(mut bytes) = std::fs::read(path) else {
        return;
    };
    let length = usize::from(u16::from_le_bytes(script.bytes())) % (bytes.len() + 1);
    bytes.truncate(length);
    std::fs::write(path, bytes).unwrap();
}
