//! The one resolver of names: from what a scene file calls another file to its path.
//!
//! Scenes are made on other machines, under other systems and in other folders. A name is
//! tried as it is written, with its backslashes turned, and then without its first folders
//! (down to the bare name, beside the scene), each time also in another case.

use std::ffi::OsString;
use std::path::{Component, Path, PathBuf};

/// Folders of a name that are tried to be left out; more are hardly meant.
const MAX_PARTS: usize = 16;

/// A file that a scene names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Found {
    /// Its path; where nothing is found, the name in the first of the folders.
    pub(crate) path: PathBuf,
    /// Folders of the name had to be left out: it may be another file than is meant.
    pub(crate) is_guess: bool,
}

/// Finds the file that `name` means, seen from the first of `folders` that has it.
pub(crate) fn find(folders: &[&Path], name: &str) -> Found {
    let exact = |path: PathBuf| Found {
        path,
        is_guess: false,
    };
    for written in spellings(name) {
        for folder in folders {
            let path = folder.join(&written);
            if path.is_file() {
                return exact(path);
            }
        }
    }
    let parts = parts(name);
    for left_out in 0..parts.len() {
        let wanted = parts.get(left_out..).unwrap_or_default();
        if left_out > 0 && wanted.iter().any(|part| part == "..") {
            continue;
        }
        for folder in folders {
            if let Some(path) = in_any_case(folder, wanted) {
                return Found {
                    path,
                    is_guess: left_out > 0,
                };
            }
        }
    }
    let first = folders.first().copied().unwrap_or(Path::new(""));
    exact(first.join(name.replace('\\', "/")))
}

/// The name as it is written, then with slashes for backslashes; each as UTF-8 and, where a
/// file system still has such names, as the bytes of Latin-1.
fn spellings(name: &str) -> Vec<OsString> {
    let turned = name.replace('\\', "/");
    let mut spellings: Vec<OsString> = Vec::new();
    for name in [name, &turned] {
        spellings.push(name.into());
        if let Some(bytes) = latin_1(name) {
            spellings.push(bytes);
        }
    }
    spellings
}

#[cfg(unix)]
fn latin_1(name: &str) -> Option<OsString> {
    use std::os::unix::ffi::OsStringExt;
    if name.is_ascii() {
        return None;
    }
    let bytes: Result<Vec<u8>, _> = name.chars().map(u8::try_from).collect();
    bytes.ok().map(OsString::from_vec)
}

#[cfg(not(unix))]
fn latin_1(_: &str) -> Option<OsString> {
    None
}

/// The name's last parts, without drive, root and `.`.
fn parts(name: &str) -> Vec<String> {
    let turned = name.replace('\\', "/");
    let mut parts: Vec<String> = Path::new(&turned)
        .components()
        .filter_map(|part| match part {
            Component::Normal(part) => Some(part.to_string_lossy().into_owned()),
            Component::ParentDir => Some("..".to_owned()),
            _ => None,
        })
        .filter(|part| !part.ends_with(':'))
        .collect();
    parts.drain(..parts.len().saturating_sub(MAX_PARTS));
    parts
}

/// The file below `folder` whose path is `parts` in whatever case; of several the one in
/// the given case, else the first by name.
fn in_any_case(folder: &Path, parts: &[String]) -> Option<PathBuf> {
    let (part, rest) = parts.split_first()?;
    let reached = |path: PathBuf| {
        if rest.is_empty() {
            path.is_file().then_some(path)
        } else {
            in_any_case(&path, rest)
        }
    };
    if let Some(path) = reached(folder.join(part)) {
        return Some(path);
    }
    let here = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let wanted = part.to_lowercase();
    let mut others: Vec<OsString> = std::fs::read_dir(here)
        .ok()?
        .filter_map(|entry| Some(entry.ok()?.file_name()))
        .filter(|name| name != part.as_str() && name.to_string_lossy().to_lowercase() == wanted)
        .collect();
    others.sort();
    others
        .into_iter()
        .find_map(|name| reached(folder.join(name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_of(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, file).unwrap();
        }
        folder
    }

    #[test]
    fn names_are_found_as_meant() {
        let folder = folder_of(&["a b.png", "tex/wood.png", "Tex/stone.png", "wall.png"]);
        for (name, want, is_guess) in [
            ("a b.png", "a b.png", false),
            ("./tex/wood.png", "tex/wood.png", false),
            (r".\tex\wood.png", "tex/wood.png", false),
            (r"TEX\WOOD.PNG", "tex/wood.png", false),
            ("tex/Stone.png", "Tex/stone.png", false),
            (r"C:\room\Tex\WALL.PNG", "wall.png", true),
            ("/home/me/room/tex/wood.png", "tex/wood.png", true),
            ("../other/wood/wall.png", "wall.png", true),
        ] {
            let found = find(&[folder.path()], name);
            let same = found.path.canonicalize().unwrap();
            let want = folder.path().canonicalize().unwrap().join(want);
            assert_eq!((same, found.is_guess), (want, is_guess), "{name}");
        }
        let lost = find(&[folder.path()], r"tex\gone.png");
        assert_eq!(lost.path, folder.path().join("tex/gone.png"));
    }

    #[test]
    fn the_first_folder_comes_first() {
        let folder = folder_of(&["a/x.ply", "b/x.ply", "b/y.ply"]);
        let (a, b) = (folder.path().join("a"), folder.path().join("b"));
        assert_eq!(find(&[&a, &b], "x.ply").path, a.join("x.ply"));
        assert_eq!(find(&[&a, &b], "y.ply").path, b.join("y.ply"));
        assert_eq!(find(&[&a, &b], "z.ply").path, a.join("z.ply"));
    }

    #[test]
    fn strange_names_find_nothing() {
        let folder = folder_of(&["a.png"]);
        let long = "x/".repeat(10_000);
        for name in ["", ".", "..", "/", "\\", "C:", "a.png/", "a.png/b", &long] {
            assert!(
                !find(&[folder.path()], name).path.is_file() || name == "a.png/",
                "{name}"
            );
        }
    }

    #[cfg(unix)]
    #[test]
    fn names_of_old_code_pages_are_found() {
        use std::os::unix::ffi::OsStringExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder
            .path()
            .join(OsString::from_vec(b"\xd1\xf2.png".into()));
        if std::fs::write(&path, "").is_ok() {
            assert_eq!(find(&[folder.path()], "Ñò.png").path, path);
        }
    }
}
