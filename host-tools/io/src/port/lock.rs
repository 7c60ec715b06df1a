//! A lock among all softdock processes of this computer, for lines that the system does not lock.

use anyhow::{Context, Result, bail, ensure};
use std::fs::File;
use std::path::{Path, PathBuf};

/// Attempts to lock a file that others remove again and again, before that is an error.
const ATTEMPTS: usize = 100;

/// A locked file in the folder for temporary files.
///
/// The holder removes the file before it releases the lock. Whoever gets a lock checks that its file is still the one of that
/// name: otherwise it has locked a file that nobody else can find, and it opens the name again. So no two processes hold the
/// lock at a time. A program that is killed leaves the file behind, unlocked. On Windows the file always stays, as an open
/// file keeps its name until it is closed.
pub(super) struct Lock {
    file: File,
    path: PathBuf,
}

impl Lock {
    /// Acquires the lock of this name.
    ///
    /// # Errors
    /// Another softdock has it, or no file can be made.
    pub(super) fn take(name: &str) -> Result<Self> {
        let plain = |c: char| match c.is_ascii_alphanumeric() || c == '.' {
            true => c,
            false => '-',
        };
        let name: String = name.chars().map(plain).collect();
        let path = std::env::temp_dir().join(format!("softdock-{name}.lock"));
        for _ in 0..ATTEMPTS {
            let file = File::options()
                .create(true)
                .append(true)
                .open(&path)
                .with_context(|| format!("cannot lock the port with {}", path.display()))?;
            ensure!(
                file.try_lock().is_ok(),
                "another softdock is talking to this board; wait for it, or end it"
            );
            if is_at(&file, &path) {
                return Ok(Self { file, path });
            }
        }
        bail!(
            "cannot lock the port: something removes {} again and again",
            path.display()
        );
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        if cfg!(unix) && is_at(&self.file, &self.path) {
            // A file that cannot be removed stays, but unlocked.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Whether an open file is still the one at this path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |of: std::io::Result<std::fs::Metadata>| of.map(|m| (m.dev(), m.ino())).ok();
    let own = place(file.metadata());
    own.is_some() && own == place(path.metadata())
}

/// Here lock files are never removed.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    fn name(test: &str) -> String {
        format!("test-{test}-{}", std::process::id())
    }

    #[test]
    fn one_has_it_at_a_time_and_nothing_stays() {
        let name = name("one");
        let lock = Lock::take(&name).unwrap();
        let path = lock.path.clone();
        let refused = Lock::take(&name).err().unwrap().to_string();
        assert!(refused.contains("another softdock"), "{refused}");
        assert!(path.exists());
        drop(lock);
        assert_eq!(path.exists(), !cfg!(unix));
        drop(Lock::take(&name).unwrap());
        assert_eq!(path.exists(), !cfg!(unix));
    }

    /// Locks that are taken and let go all the time by several at once.
    #[test]
    fn no_two_have_it_while_files_come_and_go() {
        let (name, inside) = (name("many"), AtomicU32::new(0));
        let taken = AtomicU32::new(0);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..2000 {
                        let Ok(lock) = Lock::take(&name) else {
                            continue;
                        };
                        assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0);
                        taken.fetch_add(1, Ordering::SeqCst);
                        inside.fetch_sub(1, Ordering::SeqCst);
                        drop(lock);
                    }
                });
            }
        });
        assert!(taken.load(Ordering::SeqCst) > 0);
    }
}
