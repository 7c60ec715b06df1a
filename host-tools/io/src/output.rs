//! Writes files atomically: a file is there whole or not at all.

use anyhow::{Error, Result};
use std::fs::File;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Permissions of a new file before the user's mask.
#[cfg(unix)]
const ANYBODY: u32 = 0o666;

/// Writes a file through a temporary one beside it: whoever opens `path` finds the old content or all of `content`, after a
/// crash too. A link stays a link; permissions stay. A file in a folder that
/// may not be written to is written in its place.
///
/// # Errors
/// The folder is missing, full or not to be written to.
pub fn write_whole(path: &Path, content: impl AsRef<[u8]>) -> Result<()> {
    NewFile::of(path, content)?.keep()
}

/// As [`write_whole`] for content that does not fit in memory: `write` writes it to the file.
///
/// # Errors
/// Those of [`write_whole`] and of `write`; then `path` is unchanged.
pub fn write_whole_with(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<()>,
) -> Result<()> {
    NewFile::write(path, write)?.keep()
}

/// A complete temporary file that has not got its name yet; dropped without [`keep`](Self::keep) it vanishes. Files that
/// belong together are all written before the first is kept.
#[must_use = "only `keep` gives it its name"]
pub struct NewFile {
    path: PathBuf,
    /// The target of `path` (links resolved), and the temporary file for it. None if the target was written directly: a
    /// device, or a file in a folder that may not be written to.
    new: Option<(PathBuf, NamedTempFile)>,
}

impl NewFile {
    /// Writes this content into a temporary file beside `path`.
    ///
    /// # Errors
    /// Those of [`write_whole`].
    pub fn of(path: &Path, content: impl AsRef<[u8]>) -> Result<Self> {
        Self::write(path, |file| Ok(file.write_all(content.as_ref())?))
    }

    /// Writes into a temporary file beside `path` what `write` gives.
    ///
    /// # Errors
    /// Those of [`write_whole_with`].
    pub fn write(path: &Path, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<Self> {
        let new = beside(path, write).map_err(|error| cannot_write(path, error))?;
        let path = path.to_path_buf();
        Ok(Self { path, new })
    }

    /// Renames the temporary file, which replaces the old one.
    ///
    /// # Errors
    /// The folder cannot be written to.
    pub fn keep(self) -> Result<()> {
        let Some((target, new)) = self.new else {
            return Ok(());
        };
        let kept = new.persist(target);
        kept.map_err(|error| cannot_write(&self.path, error.error))?;
        Ok(())
    }
}

fn beside(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<()>,
) -> Result<Option<(PathBuf, NamedTempFile)>> {
    let target = led_to(path);
    let old = std::fs::metadata(&target).ok();
    if old.as_ref().is_some_and(|old| !old.is_file()) {
        write(&mut File::create(&target)?)?;
        return Ok(None);
    }
    if old.is_some() {
        // A file without write permission must not be replaced either.
        File::options().write(true).open(&target)?;
    }
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(ANYBODY));
    let mut new = match builder.tempfile_in(folder) {
        // In a folder of another user there is no room for a temporary file, but one's own file can be written.
        Err(error) if error.kind() == ErrorKind::PermissionDenied && old.is_some() => {
            write(&mut File::create(&target)?)?;
            return Ok(None);
        }
        other => other?,
    };
    write(new.as_file_mut())?;
    if let Some(old) = old {
        new.as_file().set_permissions(old.permissions())?;
    }
    new.as_file().sync_all()?;
    Ok(Some((target, new)))
}

/// The target of a path with links resolved, whether it exists or not.
fn led_to(path: &Path) -> PathBuf {
    let folder = || path.parent().map(Path::to_path_buf).unwrap_or_default();
    let linked = || Some(folder().join(std::fs::read_link(path).ok()?));
    let found = std::fs::canonicalize(path).ok().or_else(linked);
    found.unwrap_or_else(|| path.to_path_buf())
}

/// Adds to an error which file could not be written, and what to do about it.
pub(crate) fn cannot_write(path: &Path, error: impl Into<Error>) -> Error {
    let error = error.into();
    let mut kinds = error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<io::Error>());
    let advice = match kinds.next().map(io::Error::kind) {
        Some(ErrorKind::StorageFull) => ": the disk is full; make room, or choose another disk",
        Some(ErrorKind::QuotaExceeded) => {
            ": your share of the disk is full; make room, or choose another disk"
        }
        Some(ErrorKind::NotFound) => ": its folder does not exist; make it first",
        _ => "",
    };
    error.context(format!("cannot write {}{advice}", path.display()))
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    #[test]
    fn a_link_stays_a_link_and_permissions_stay() {
        let folder = tempfile::tempdir().unwrap();
        let [file, link] = ["file", "link"].map(|name| folder.path().join(name));
        write_whole(&file, b"first").unwrap();
        std::fs::set_permissions(&file, PermissionsExt::from_mode(0o640)).unwrap();
        symlink(&file, &link).unwrap();
        write_whole(&link, b"second").unwrap();

        assert_eq!(std::fs::read(&file).unwrap(), b"second");
        assert!(link.is_symlink());
        let mode = std::fs::metadata(&file).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
        // The link's target need not exist.
        std::fs::remove_file(&file).unwrap();
        write_whole(&link, b"third").unwrap();
        assert_eq!(std::fs::read(&file).unwrap(), b"third");
        assert!(link.is_symlink());
        // Nothing temporary is left.
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_whole(&folder.path().join("none/file"), b"").unwrap_err();
        let error = format!("{error:#}");
        assert!(
            error.contains("none/file: its folder does not exist"),
            "{error}"
        );
    }

    #[test]
    fn what_fails_half_way_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        write_whole(&file, b"first").unwrap();
        let error = write_whole_with(&file, |file| {
            file.write_all(b"sec")?;
            Err(io::Error::from(ErrorKind::StorageFull).into())
        });
        let error = format!("{:#}", error.unwrap_err());
        assert!(error.contains("file: the disk is full"), "{error}");
        assert_eq!(std::fs::read(&file).unwrap(), b"first");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_device_is_written_to_and_not_replaced() {
        use std::os::unix::fs::FileTypeExt;
        let full = Path::new("/dev/full");
        let error = format!("{:#}", write_whole(full, b"text").unwrap_err());
        assert!(error.contains("/dev/full: the disk is full"), "{error}");
        assert!(
            std::fs::metadata(full)
                .unwrap()
                .file_type()
                .is_char_device()
        );
    }
}
