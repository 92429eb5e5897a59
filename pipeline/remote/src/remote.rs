//! One folder of a store.

use crate::error::RemoteError;
use object_store::path::Path as Name;
use object_store::{ObjectStore, ObjectStoreExt, PutMode, PutOptions, PutPayload};
use std::path::Path;
use tokio::runtime::Runtime;
use url::Url;

/// Whether a path is an address of a store rather than a path of this machine.
pub fn is_url(path: &Path) -> bool {
    let text = path.to_str().unwrap_or_default();
    ["s3://", "gs://", "az://", "file://"]
        .iter()
        .any(|scheme| text.starts_with(scheme))
}

/// What became of a put.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Put {
    /// It was not there.
    New,
    /// The same bytes were there.
    Already,
}

/// A folder of a store.
pub struct Remote {
    store: Box<dyn ObjectStore>,
    folder: Name,
    runtime: Runtime,
}

impl std::fmt::Debug for Remote {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Remote({} in {})", self.folder, self.store)
    }
}

impl Remote {
    /// Opens the folder; nothing is asked of the store yet.
    pub fn open(address: &str) -> Result<Remote, RemoteError> {
        let bad = |reason: String| RemoteError::Url {
            url: address.into(),
            reason,
        };
        let url = Url::parse(address).map_err(|e| bad(e.to_string()))?;
        if cfg!(not(feature = "clouds")) && url.scheme() != "file" {
            let reason = "this build has no cloud stores; `make build` makes one that has";
            return Err(bad(reason.into()));
        }
        let options = std::env::vars().map(|(name, value)| (name.to_ascii_lowercase(), value));
        let (store, folder) =
            object_store::parse_url_opts(&url, options).map_err(|e| bad(e.to_string()))?;
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(|e| bad(e.to_string()))?;
        Ok(Remote {
            store,
            folder,
            runtime,
        })
    }

    /// Names of all objects in the folder, relative to it, sorted.
    pub fn list(&self) -> Result<Vec<String>, RemoteError> {
        let mut names = Vec::new();
        let mut folders = vec![self.folder.clone()];
        while let Some(folder) = folders.pop() {
            let found = self
                .runtime
                .block_on(self.store.list_with_delimiter(Some(&folder)))
                .map_err(fail(&folder, "list"))?;
            folders.extend(found.common_prefixes);
            let relative = found.objects.iter().filter_map(|object| {
                let parts = object.location.prefix_match(&self.folder)?;
                Some(
                    parts
                        .map(|p| p.as_ref().to_string())
                        .collect::<Vec<_>>()
                        .join("/"),
                )
            });
            names.extend(relative);
        }
        names.sort();
        Ok(names)
    }

    /// The bytes of an object, none where there is no such object.
    pub fn get(&self, name: &str) -> Result<Option<Vec<u8>>, RemoteError> {
        let name = self.name(name);
        let bytes = self.runtime.block_on(async {
            let found = self.store.get(&name).await?;
            found.bytes().await
        });
        match bytes {
            Ok(bytes) => Ok(Some(bytes.to_vec())),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(fail(&name, "read")(error)),
        }
    }

    /// Puts an object where there is none. Of two writers one wins, whatever the bytes.
    ///
    /// # Errors
    /// [`RemoteError::Differs`] where other bytes are there already.
    pub fn put_new(&self, name: &str, bytes: Vec<u8>) -> Result<Put, RemoteError> {
        let place = self.name(name);
        let options = PutOptions::from(PutMode::Create);
        let payload = PutPayload::from(bytes.clone());
        match self
            .runtime
            .block_on(self.store.put_opts(&place, payload, options))
        {
            Ok(_) => Ok(Put::New),
            Err(object_store::Error::AlreadyExists { .. }) => {
                match self.get(name)? == Some(bytes) {
                    true => Ok(Put::Already),
                    false => Err(RemoteError::Differs {
                        name: place.to_string(),
                    }),
                }
            }
            Err(error) => Err(fail(&place, "write")(error)),
        }
    }

    /// Puts an object, replacing what is there.
    pub fn put(&self, name: &str, bytes: Vec<u8>) -> Result<(), RemoteError> {
        let name = self.name(name);
        let put = self.store.put(&name, PutPayload::from(bytes));
        self.runtime.block_on(put).map_err(fail(&name, "write"))?;
        Ok(())
    }

    /// Removes an object; one that is gone already is none.
    pub fn remove(&self, name: &str) -> Result<(), RemoteError> {
        let name = self.name(name);
        match self.runtime.block_on(self.store.delete(&name)) {
            Ok(()) | Err(object_store::Error::NotFound { .. }) => Ok(()),
            Err(error) => Err(fail(&name, "remove")(error)),
        }
    }

    fn name(&self, name: &str) -> Name {
        let parts = name.split('/').filter(|part| !part.is_empty());
        parts.fold(self.folder.clone(), |folder, part| folder.join(part))
    }
}

fn fail(name: &Name, action: &'static str) -> impl Fn(object_store::Error) -> RemoteError {
    let name = name.to_string();
    move |source| RemoteError::Store {
        name: name.clone(),
        action,
        source,
    }
}
