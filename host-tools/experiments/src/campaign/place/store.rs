//! A campaign in an object store: one machine writes the plan, others read it and add their parts.
//!
//! A part is written atomically, and only if it does not exist: stores guarantee this for a conditional put.

use crate::campaign::checksum::checksum;
use anyhow::{Context, Result, anyhow, bail, ensure};
use object_store::local::LocalFileSystem;
use object_store::path::Path as ObjectPath;
use object_store::{
    Error, ObjectStore, ObjectStoreExt, ObjectStoreScheme, PutMode, parse_url_opts,
};
use std::path::{Path, PathBuf};
use tokio::runtime::{Builder, Runtime};
use url::Url;

/// Prefixes of the environment variables with keys, region and endpoint, as the stores' own programs use them.
const VARIABLES: [&str; 3] = ["AWS_", "AZURE_", "GOOGLE_"];

/// A place in an object store.
#[derive(Debug)]
pub(super) struct Store {
    objects: Box<dyn ObjectStore>,
    /// Prefix of the names of all objects of the campaign.
    prefix: ObjectPath,
    address: Url,
    /// Folder of a store that is a file system.
    on_disk: Option<PathBuf>,
    runtime: Runtime,
}

impl Store {
    /// The location at an address; the store is not accessed yet.
    pub(super) fn open(address: &str) -> Result<Self> {
        let address: Url = address.parse().context("it is no address")?;
        let (scheme, prefix) = ObjectStoreScheme::parse(&address).map_err(|_| {
            anyhow!("expected a folder, or file:///.., s3://.., gs://.. or az://..")
        })?;
        refuse_left_out(&scheme)?;
        let local = scheme == ObjectStoreScheme::Local;
        let objects = if local {
            // With fsync, so that a written object survives a crash.
            Box::new(LocalFileSystem::new().with_fsync(true))
        } else {
            parse_url_opts(&address, variables())?.0
        };
        Ok(Self {
            objects,
            prefix,
            on_disk: address.to_file_path().ok().filter(|_| local),
            address,
            runtime: Builder::new_current_thread().enable_all().build()?,
        })
    }

    /// Folder of a store that is a file system; else None.
    pub(super) fn on_disk(&self) -> Option<&Path> {
        self.on_disk.as_deref()
    }

    /// Folder of this machine for the campaign's journals.
    pub(super) fn journals(&self) -> PathBuf {
        let host = &self.address[..url::Position::BeforePath];
        let key = checksum(&[host.as_bytes(), self.prefix.as_ref().as_bytes()]);
        let folder = format!("softdock/campaigns/{key:016x}");
        cache().join(folder)
    }

    /// Names of all objects of the campaign.
    pub(super) fn names(&self) -> Result<Vec<String>> {
        let listed = self.objects.list_with_delimiter(Some(&self.prefix));
        let listed = self.runtime.block_on(listed);
        let listed = listed.map_err(|error| self.cannot("list it", &error))?;
        let names = listed.objects.iter();
        let names = names.filter_map(|object| Some(object.location.filename()?.to_owned()));
        let mut names: Vec<String> = names.collect();
        names.sort();
        Ok(names)
    }

    /// Content of an object; None if it does not exist.
    pub(super) fn read(&self, name: &str) -> Result<Option<Vec<u8>>> {
        let path = self.prefix.clone().join(name);
        let got = self
            .runtime
            .block_on(async { self.objects.get(&path).await?.bytes().await });
        match got {
            Err(Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(self.cannot(&format!("read {name}"), &error)),
            Ok(bytes) => Ok(Some(bytes.into())),
        }
    }

    /// Adds an object that does not exist. An equal object is no error: another machine was faster, or the answer to an
    /// earlier attempt was lost.
    pub(super) fn add(&self, name: &str, content: Vec<u8>) -> Result<()> {
        let path = self.prefix.clone().join(name);
        let payload = content.clone().into();
        let put = self
            .objects
            .put_opts(&path, payload, PutMode::Create.into());
        match self.runtime.block_on(put) {
            Err(Error::AlreadyExists { .. }) => ensure!(
                self.read(name)?.is_some_and(|there| there == content),
                "another {name} is in {} already, and is not replaced: remove it, or plan anew elsewhere",
                self.address
            ),
            Err(error) => return Err(self.cannot(&format!("write {name}"), &error)),
            Ok(_) => {}
        }
        Ok(())
    }

    /// An error of the store in words, which contain those of its causes.
    fn cannot(&self, what: &str, error: &Error) -> anyhow::Error {
        anyhow!("{}: cannot {what}: {error}", self.address)
    }
}

/// An error for a kind of store that this program was built without: how to get it.
fn refuse_left_out(scheme: &ObjectStoreScheme) -> Result<()> {
    let (store, feature, built_in) = match scheme {
        ObjectStoreScheme::Local => return Ok(()),
        ObjectStoreScheme::AmazonS3 => ("S3", "s3", cfg!(feature = "s3")),
        ObjectStoreScheme::GoogleCloudStorage => {
            ("Google Cloud Storage", "gcs", cfg!(feature = "gcs"))
        }
        ObjectStoreScheme::MicrosoftAzure => ("Azure", "azure", cfg!(feature = "azure")),
        _ => {
            bail!("a campaign cannot stand there; expected file:///.., s3://.., gs://.. or az://..")
        }
    };
    ensure!(
        built_in,
        "this softdock was built without {store}; in a clone, `cargo install --locked --path host-tools/cli --features {feature}` builds it in"
    );
    Ok(())
}

/// Environment variables with keys, region and endpoint.
fn variables() -> impl Iterator<Item = (String, String)> {
    let all = std::env::vars_os();
    let all =
        all.filter_map(|(name, value)| Some((name.into_string().ok()?, value.into_string().ok()?)));
    all.filter(|(name, _)| VARIABLES.iter().any(|start| name.starts_with(start)))
}

/// The user's cache folder.
fn cache() -> PathBuf {
    let named = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from);
    let home = || Some(std::env::home_dir()?.join(".cache"));
    let cache = named.filter(|folder| folder.is_absolute()).or_else(home);
    cache.unwrap_or_else(std::env::temp_dir)
}

#[cfg(test)]
mod tests;
