//! Notes, data, settings and the model: what a reader needs to repeat the diagnosis.

use super::{Source, words};
use softdock_analysis::diagnose::Verdict;
use softdock_io::identity;
use softdock_io::shell::quoted;
use softdock_report::{Cell, Column, Page, Table, number};

impl Source<'_> {
    /// The last sections and the foot.
    pub(super) fn provenance(&self, page: &mut Page) {
        let (diagnosis, identity) = (self.diagnosis, self.identity);
        if !diagnosis.notes.is_empty() {
            page.section("Notes");
            page.list(&diagnosis.notes);
        }
        page.section("Data and settings");
        page.table(&self.sources());
        if diagnosis.verdict == Verdict::Named {
            page.paragraph("To take it into the model:");
            page.code(&self.command());
        }
        let model = match self.after {
            Some(_) => format!(
                "Model with {} added",
                words::count(diagnosis.effects.len(), "effect")
            ),
            None => "Model".to_owned(),
        };
        if !identity.model_toml.trim().is_empty() {
            page.details(&model, &identity.model_toml);
        }
        if !identity.settings_toml.trim().is_empty() {
            page.details("Settings of the board", &identity.settings_toml);
        }
        page.identity(&format!(
            "{} · {} · {}",
            identity::text(),
            identity.model_path,
            identity.judged()
        ));
    }

    fn sources(&self) -> Table {
        let (diagnosis, identity) = (self.diagnosis, self.identity);
        let held_back = match diagnosis.in_sample {
            true => "none: the end of the log of the fit moves too little to be held back",
            false => "none: the end of the log of the fit was held back",
        };
        let test = identity.test.as_deref().unwrap_or(held_back);
        let cycles = self.before.time_s.len();
        let cycle_ms = number::significant(self.before.cycle_s * 1e3, 3);
        let took = format!("{} s", number::significant(diagnosis.seconds, 2));
        let mut rows = vec![
            ("Model", identity.model_path.clone()),
            ("Data of the fit", identity.train.clone()),
            ("Unseen data", test.to_owned()),
            ("Judged", format!("{cycles} cycles of {cycle_ms} ms")),
            ("Recorded by", identity.firmware.clone()),
            ("Diagnosed by", identity::text()),
            ("Computing time", took),
        ];
        rows.retain(|(_, value)| !value.trim().is_empty());
        let mut table = Table::new(vec![Column::text("What"), Column::text("Which")]);
        for (what, which) in rows {
            table.push(vec![Cell::text(what), Cell::text(which)]);
        }
        table
    }

    /// The command that adds the named effects to the model.
    fn command(&self) -> String {
        let identity = self.identity;
        let data = match &identity.test {
            Some(test) => format!("{} --test {}", quoted(&identity.train), quoted(test)),
            None => quoted(&identity.train),
        };
        let model = quoted(&identity.model_path);
        format!("softdock add {model} --fit {data}")
    }
}
