//! `softdock effects`: the catalogue of physical effects.

use super::{print, print_json};
use crate::catalogue::{lesson, overview, page, picture};
use anyhow::{Result, bail};
use clap::{Args, Subcommand};
use serde::Serialize;
use softdock_io::input::refuse_overwrite;
use softdock_io::output::write_whole;
use softdock_io::say;
use softdock_physics::effects::{CATALOGUE, Effect, Group, named};
use std::path::{Path, PathBuf};

/// List the physical effects that a model can contain, or teach one of them.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "Example: softdock effects show zero_cross_pause"
)]
pub(super) struct Effects {
    #[command(subcommand)]
    show: Option<Task>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum Task {
    Show(Show),
    /// Catches the id of an effect that was given without `show`.
    #[command(external_subcommand)]
    Named(Vec<String>),
}

/// Teach one effect: its equation, what it looks like, and what tells it from its neighbours.
#[derive(Debug, Args)]
#[command(after_help = "Example: softdock effects show zero_cross_pause --picture pause.html")]
struct Show {
    /// Id of the effect, as `softdock effects` lists it
    id: String,
    /// Write the picture (SVG), or the whole page (HTML)
    #[arg(long, value_name = "FILE.svg|FILE.html")]
    picture: Option<PathBuf>,
    /// Overwrite an existing picture
    #[arg(long)]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Listed {
    effects: &'static [&'static Effect],
}

impl Effects {
    pub(super) fn execute(self) -> Result<()> {
        match self.show {
            Some(Task::Show(show)) => show.execute(),
            Some(Task::Named(words)) => {
                let word = words.first().map_or("", String::as_str);
                let id = named(word)?.id;
                bail!("`softdock effects show {id}` explains it")
            }
            None if self.json => print_json(&Listed { effects: CATALOGUE }),
            None => {
                let groups =
                    Group::ALL.map(|group| format!("{}\n\n{}", group.title(), overview(group)));
                print(&format!(
                    "{}\nMore about one of them: softdock effects show ID\n",
                    groups.join("\n")
                ))
            }
        }
    }
}

impl Show {
    fn execute(self) -> Result<()> {
        let effect = named(&self.id)?;
        if let Some(path) = &self.picture {
            write(effect, path, self.force)?;
            say!("picture: {}", path.display());
        }
        if self.json {
            return print_json(effect);
        }
        print(&lesson(effect, &picture(effect)?))
    }
}

fn write(effect: &Effect, path: &Path, force: bool) -> Result<()> {
    let picture = picture(effect)?;
    let text = match path.extension().and_then(|extension| extension.to_str()) {
        Some("svg") => picture.to_plot(effect).to_svg()?,
        Some("html") => page(effect, &picture)?.to_html(),
        _ => bail!(
            "--picture is {}; its name has to end in .svg (the picture) or .html (the page)",
            path.display()
        ),
    };
    refuse_overwrite(path, force)?;
    write_whole(path, text)
}
