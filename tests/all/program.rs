//! Calls of the `rrf` binary, and the run that several tests read.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use tempfile::TempDir;

/// The light box of the oracle table `cornell_overhead`.
pub const OVERHEAD: &str = "-0.6,1.3,-0.6,0.6,1.8,0.6";
/// A bake of nets that takes less than a second: two cells, 2,000 rows of 4 paths.
/// The rounds come last.
pub const TINY: [&str; 12] = [
    "--method",
    "nets",
    "--light-box",
    OVERHEAD,
    "--rows",
    "2000",
    "--cells",
    "2",
    "--paths",
    "4",
    "--rounds",
    "1",
];

/// What a call said and how it ended.
#[derive(Debug)]
pub struct Said {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

/// `rrf` with these arguments, whatever comes of it.
pub fn rrf(args: &[&str]) -> Said {
    let Output {
        status,
        stdout,
        stderr,
    } = Command::new(env!("CARGO_BIN_EXE_rrf"))
        .args(args)
        .output()
        .expect("the binary was built with this test");
    Said {
        code: status.code(),
        out: String::from_utf8_lossy(&stdout).into_owned(),
        err: String::from_utf8_lossy(&stderr).into_owned(),
    }
}

/// `rrf` with these arguments, which has to end well.
pub fn done(args: &[&str]) -> Said {
    let said = rrf(args);
    assert_eq!(said.code, Some(0), "rrf {args:?}: {said:#?}");
    said
}

/// `rrf` with these arguments, which has to be refused: exit code 2 (bad input), no panic, and
/// each of `words` in a message of a few lines.
pub fn refused(args: &[&str], words: &[&str]) -> Said {
    let said = rrf(args);
    assert_eq!(said.code, Some(2), "rrf {args:?}: {said:#?}");
    says(&said, words);
    said
}

/// The message has all the words, is short, and is no panic.
pub fn says(said: &Said, words: &[&str]) {
    for word in words {
        assert!(said.err.contains(word), "no {word:?} in {said:#?}");
    }
    assert!(!said.err.contains("panicked"), "{said:#?}");
    assert!(said.err.len() < 1500, "too long: {said:#?}");
}

/// A file of the repository.
pub fn file(path: &str) -> String {
    text(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path))
}

/// The Cornell box as pbrt text.
pub fn cornell() -> String {
    file("scenes/cornell-box/scene.pbrt")
}

/// An oracle table.
pub fn oracle(name: &str) -> String {
    file(&format!("tests/data/oracle/{name}.parquet"))
}

/// A path as an argument.
pub fn text(path: &Path) -> String {
    path.to_str().expect("paths of tests are UTF-8").to_string()
}

/// A folder of a test's own, and names in it.
pub struct Place(TempDir);

impl Place {
    pub fn new() -> Place {
        Place(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn name(&self, name: &str) -> String {
        text(&self.path(name))
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        std::fs::write(self.path(name), bytes).expect("a temporary file");
        self.name(name)
    }

    /// Whether nothing but these lies in the folder.
    pub fn holds(&self, names: &[&str]) -> bool {
        let mut found: Vec<String> = std::fs::read_dir(self.0.path())
            .expect("the temporary folder")
            .map(|entry| text(Path::new(&entry.expect("an entry").file_name())))
            .collect();
        found.sort();
        found == names
    }
}

/// The Cornell box baked with [`TINY`], for tests that only read it.
pub fn tiny_run() -> String {
    static RUN: OnceLock<Place> = OnceLock::new();
    let place = RUN.get_or_init(|| {
        let place = Place::new();
        bake_tiny(&cornell(), &place.name("run"), &[]);
        place
    });
    place.name("run")
}

/// Bakes with [`TINY`] and more options.
pub fn bake_tiny(scene: &str, run: &str, more: &[&str]) -> Said {
    done(&[&["bake", scene, "-o", run], &TINY[..], more].concat())
}

/// Every file below a folder with its bytes, sorted by name.
pub fn bytes_below(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = text(path.strip_prefix(folder).expect("below the folder"));
                // wall time: the one file in which two runs of one seed differ
                if !name.ends_with("seconds.json") {
                    files.push((name, std::fs::read(&path).expect("a file")));
                }
            }
        }
    }
    files.sort();
    files
}
