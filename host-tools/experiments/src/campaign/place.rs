//! Location of a campaign: a folder, or an object store by its address. Plan and parts are there. The journals, to which a
//! row is added as soon as it is computed, are always in a folder of this machine.

mod store;

use anyhow::{Context, Result};
use softdock_io::input::refuse_overwrite;
use softdock_io::output::write_whole;
use std::fmt::{self, Display, Formatter};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use store::Store;

/// Location of plan and parts of a campaign.
#[derive(Debug)]
pub struct Place {
    /// Folder or address, as it was given.
    name: String,
    /// The folder of the journals.
    journals: PathBuf,
    /// The store; None if plan and parts are in the folder of the journals.
    store: Option<Store>,
}

impl Place {
    /// Opens a folder, or an address with a scheme: `file:///shared/campaign`, `s3://bucket/campaign`.
    ///
    /// # Errors
    /// The address is invalid, or of a kind of store that this program was built without.
    pub fn open(name: &Path) -> Result<Self> {
        let text = name.display().to_string();
        if !text.contains("://") {
            return Ok(Self::folder(name));
        }
        let store = Store::open(&text).with_context(|| format!("cannot open {text}"))?;
        Ok(Self {
            journals: store.journals(),
            store: Some(store),
            name: text,
        })
    }

    /// The location in this folder.
    pub fn folder(folder: &Path) -> Self {
        Self {
            name: folder.display().to_string(),
            journals: folder.to_path_buf(),
            store: None,
        }
    }

    /// Path or address that is valid in any working directory of this machine.
    ///
    /// # Errors
    /// The folder has no path.
    pub fn absolute(&self) -> Result<PathBuf> {
        if self.store.is_some() {
            return Ok(PathBuf::from(&self.name));
        }
        std::path::absolute(&self.journals).context("cannot find the folder")
    }

    /// The folder in which plan and parts are, if there is one on this machine.
    pub fn on_disk(&self) -> Option<&Path> {
        match &self.store {
            Some(store) => store.on_disk(),
            None => Some(&self.journals),
        }
    }

    /// The folder of the journals.
    pub fn journals(&self) -> &Path {
        &self.journals
    }

    /// Path or address of a file of the campaign, for messages.
    pub fn file(&self, name: &str) -> String {
        match &self.store {
            Some(_) => format!("{}/{name}", self.name.trim_end_matches('/')),
            None => self.journals.join(name).display().to_string(),
        }
    }

    /// Whether something exists there already; an empty folder counts as free.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn is_taken(&self) -> Result<bool> {
        match &self.store {
            Some(store) => Ok(!store.names()?.is_empty()),
            None => Ok(refuse_overwrite(&self.journals, false).is_err()),
        }
    }

    /// Names of all files there.
    ///
    /// # Errors
    /// The location cannot be read.
    pub(super) fn names(&self) -> Result<Vec<String>> {
        match &self.store {
            Some(store) => store.names(),
            None => names(&self.journals),
        }
    }

    /// Content of a file; None if it does not exist.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(super) fn read(&self, name: &str) -> Result<Option<Vec<u8>>> {
        let Some(store) = &self.store else {
            return match std::fs::read(self.journals.join(name)) {
                Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
                read => {
                    Ok(Some(read.with_context(|| {
                        format!("cannot read {}", self.file(name))
                    })?))
                }
            };
        };
        store.read(name)
    }

    /// Adds a file atomically. In a store it never replaces another file.
    ///
    /// # Errors
    /// The location cannot be written to, or the store has another file of that name.
    pub(super) fn add(&self, name: &str, content: Vec<u8>) -> Result<()> {
        let Some(store) = &self.store else {
            std::fs::create_dir_all(&self.journals)
                .with_context(|| format!("cannot make the folder {self}"))?;
            return write_whole(&self.journals.join(name), content);
        };
        store.add(name, content)
    }
}

impl Display for Place {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

/// Names of all files in a folder.
pub(super) fn names(folder: &Path) -> Result<Vec<String>> {
    let entries =
        std::fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))?;
    let names = entries
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<String> = names.collect();
    names.sort();
    Ok(names)
}
