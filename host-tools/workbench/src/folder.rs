//! The folder that the workbench shows. No request reaches a file outside of it.

use super::problem::Problem;
use anyhow::{Context, Result, ensure};
use axum::http::StatusCode;
use std::path::{Component, Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Depth of subfolders that are searched.
const DEPTH: usize = 3;
/// Most files of a kind that are listed.
const MOST_FILES: usize = 500;
/// Folders of build products, which contain no recordings.
const SKIPPED: [&str; 2] = ["target", "node_modules"];

/// A folder with everything below it.
#[derive(Debug)]
pub(super) struct Folder {
    root: PathBuf,
}

/// A file of the folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FolderFile {
    /// Path relative to the folder, with `/`.
    pub(super) id: String,
    pub(super) path: PathBuf,
    pub(super) bytes: u64,
    /// Time of the last change, seconds since 1970.
    pub(super) changed_s: u64,
}

impl Folder {
    /// # Errors
    ///
    /// The path is no folder.
    pub(super) fn new(path: &Path) -> Result<Self> {
        let root = path
            .canonicalize()
            .with_context(|| format!("cannot open the folder {}", path.display()))?;
        ensure!(
            root.is_dir(),
            "{} is a file; expected the folder that holds it",
            path.display()
        );
        Ok(Self { root })
    }

    pub(super) fn root(&self) -> &Path {
        &self.root
    }

    /// Common prefix of the paths of all files, which a page does not see.
    pub(super) fn prefix(&self) -> String {
        format!("{}/", self.root.display())
    }

    /// Path of the file with an id that a browser sent.
    ///
    /// # Errors
    ///
    /// The id is no plain path below the folder, leads out of it through a link, or names no file with this ending.
    pub(super) fn file(&self, id: &str, ending: &str) -> Result<PathBuf, Problem> {
        let inside = plain(id)?;
        let missing = || Problem::not_found(format!("`{id}` is not in the folder (any more)"));
        let path = self
            .root
            .join(inside)
            .canonicalize()
            .map_err(|_| missing())?;
        let is_ours = path.starts_with(&self.root) && path.is_file() && has(&path, ending);
        is_ours.then_some(path).ok_or_else(missing)
    }

    /// Path of a file that is to be created.
    ///
    /// # Errors
    ///
    /// As for [`Self::file`]; or the subfolder does not exist, the ending is another one, or the file exists.
    pub(super) fn new_file(&self, id: &str, ending: &str) -> Result<PathBuf, Problem> {
        let inside = plain(id)?;
        let refused = |why| Problem::new(StatusCode::UNPROCESSABLE_ENTITY, why);
        let name = inside.file_name().filter(|_| has(inside, ending));
        let name = name.ok_or_else(|| {
            refused(format!(
                "expected a name that ends with .{ending}, received `{id}`"
            ))
        })?;
        let folder = self.root.join(inside).parent().map(Path::canonicalize);
        let folder = folder
            .and_then(Result::ok)
            .filter(|folder| folder.starts_with(&self.root));
        let folder =
            folder.ok_or_else(|| refused(format!("there is no such folder for `{id}`")))?;
        let path = folder.join(name);
        if path.symlink_metadata().is_ok() {
            return Err(Problem::changed(format!(
                "`{id}` exists already and is left as it is: choose another name"
            )));
        }
        Ok(path)
    }

    /// Files with this ending, the newest first.
    pub(super) fn list(&self, ending: &str) -> Vec<FolderFile> {
        let mut found = Vec::new();
        self.walk(&self.root, DEPTH, ending, &mut found);
        found.sort_by(|a, b| b.changed_s.cmp(&a.changed_s).then(a.id.cmp(&b.id)));
        found.truncate(MOST_FILES);
        found
    }

    fn walk(&self, folder: &Path, depth: usize, ending: &str, found: &mut Vec<FolderFile>) {
        // Entries that cannot be read are not listed.
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        for entry in entries {
            let name = entry.file_name();
            let Some(name) = name.to_str().filter(|name| !name.starts_with('.')) else {
                continue;
            };
            let path = entry.path();
            let Ok(kind) = entry.file_type() else {
                continue;
            };
            if kind.is_dir() && depth > 0 && !SKIPPED.contains(&name) {
                self.walk(&path, depth - 1, ending, found);
            } else if !kind.is_dir() && has(&path, ending) {
                found.extend(self.entry(path));
            }
        }
    }

    /// A file for the list; None for a link that leads out of the folder.
    fn entry(&self, path: PathBuf) -> Option<FolderFile> {
        let id = path.strip_prefix(&self.root).ok()?.to_str()?;
        let id = id.replace(std::path::MAIN_SEPARATOR, "/");
        let path = self.file(&id, path.extension()?.to_str()?).ok()?;
        let about = std::fs::metadata(&path).ok()?;
        let changed = about.modified().unwrap_or(SystemTime::UNIX_EPOCH);
        Some(FolderFile {
            id,
            bytes: about.len(),
            changed_s: changed
                .duration_since(UNIX_EPOCH)
                .map_or(0, |d| d.as_secs()),
            path,
        })
    }
}

/// An id as a path without `..` or an absolute part.
fn plain(id: &str) -> Result<&Path, Problem> {
    let inside = Path::new(id);
    let normal = |part| matches!(part, Component::Normal(_));
    let is_plain = !id.is_empty() && !id.contains(['\\', '\0']);
    if is_plain && inside.components().all(normal) {
        return Ok(inside);
    }
    Err(Problem::new(
        StatusCode::BAD_REQUEST,
        format!("`{id}` is no path in the folder; expected one as /api lists it"),
    ))
}

fn has(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|own| own == ending)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_path_leads_out() {
        let outside = tempfile::tempdir().unwrap();
        std::fs::write(outside.path().join("secret.toml"), "").unwrap();
        let inside = outside.path().join("inside");
        std::fs::create_dir_all(inside.join("runs")).unwrap();
        std::fs::write(inside.join("runs/model.toml"), "").unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(outside.path(), inside.join("link")).unwrap();
        let folder = Folder::new(&inside).unwrap();
        assert!(folder.file("runs/model.toml", "toml").is_ok());
        let absolute = outside.path().join("secret.toml").display().to_string();
        for id in [
            "",
            ".",
            "..",
            "../secret.toml",
            "runs/../../secret.toml",
            "runs/./../../secret.toml",
            "./../secret.toml",
            "link/secret.toml",
            "runs/model.toml/../../../secret.toml",
            "..\\secret.toml",
            "runs\0/model.toml",
            "%2e%2e/secret.toml",
            "/etc/hostname",
            "//secret.toml",
            "runs",
            "runs/model.mcap",
            &absolute,
        ] {
            assert!(folder.file(id, "toml").is_err(), "{id}");
            assert!(folder.new_file(id, "toml").is_err(), "{id}");
        }
        for id in ["link/new.toml", "nowhere/new.toml", "new.mcap", ".toml"] {
            assert!(folder.new_file(id, "toml").is_err(), "{id}");
        }
        assert!(folder.new_file("runs/new.toml", "toml").is_ok());
        let listed: Vec<String> = folder.list("toml").into_iter().map(|f| f.id).collect();
        assert_eq!(listed, ["runs/model.toml"]);
    }
}
