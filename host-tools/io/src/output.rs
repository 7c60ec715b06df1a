//! Writing files that are there whole or not at all.

use anyhow::{Context, Result};
use std::io::Write;
use std::path::Path;

/// What a new file may be used for, before the user's mask.
#[cfg(unix)]
const ANYBODY: u32 = 0o666;

/// Writes a file through a temporary one beside it: whoever looks at `path` finds what was there
/// before or all of `content`, after a crash too. A link stays a link; permissions stay.
///
/// # Errors
/// The folder is missing, full or not to be written to.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<()> {
    write_whole_with(path, |file| Ok(file.write_all(content)?))
}

/// The same for what is too long to be held in memory: `write` is given the file.
///
/// # Errors
/// Those of [`write_whole`], and what `write` says; then `path` is as it was.
pub fn write_whole_with(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<()>,
) -> Result<()> {
    let failed = || format!("cannot write {}", path.display());
    let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(ANYBODY));
    let mut new = builder.tempfile_in(folder).with_context(failed)?;
    write(new.as_file_mut()).with_context(failed)?;
    if let Ok(old) = std::fs::metadata(&target) {
        let file = new.as_file();
        file.set_permissions(old.permissions())
            .with_context(failed)?;
    }
    new.as_file().sync_all().with_context(failed)?;
    new.persist(&target).with_context(failed)?;
    Ok(())
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::write_whole;
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
        // Nothing temporary is left.
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_whole(&folder.path().join("none/file"), b"").unwrap_err();
        assert!(format!("{error:#}").contains("none/file"), "{error:#}");
    }
}
