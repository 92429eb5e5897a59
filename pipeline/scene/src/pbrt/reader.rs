//! State of the reader while a scene is read, and the stack of files.

use super::fault::{Fault, Files, Place, Read, Warnings, fault};
use super::mesh::{MAX_TRIANGLES, Mesh};
use super::params::Params;
use super::state::{Block, Defaults, Emission, Film, Medium, Saved, State, Surface, Version};
use super::token::Tokens;
use super::value::{Mapping, Value};
use crate::lost::LostPictures;
use crate::texture::TextureTable;
use crate::{LoadOptions, Scene, SceneError, file, resolve};
use glam::DMat4;
use rrf_lights::LightNames;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// How deep files may include one another.
const MAX_INCLUDE_DEPTH: usize = 32;
/// How many files may be included, the same file counted each time.
const MAX_INCLUDES: usize = 100_000;
/// How much text all files together may have [bytes]: included again counts again.
const MAX_TEXT: u64 = 8 << 30;

/// Where in the file's order the reader is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// Before `WorldBegin`: camera, film, options.
    Options,
    /// After it: materials, lights, shapes.
    World,
    /// After `WorldEnd`.
    Ended,
}

/// An object that `ObjectBegin` has opened.
pub(super) struct Recording {
    pub name: String,
    pub meshes: Vec<Mesh>,
}

/// The reader's whole state.
pub(super) struct Reader {
    pub files: Files,
    pub warnings: Warnings,
    pub scene: Scene,
    pub phase: Phase,
    pub state: State,
    pub saved: Vec<Saved>,
    pub version_seen: Option<Version>,
    pub systems: HashMap<String, DMat4>,
    pub materials: HashMap<String, Surface>,
    pub media: HashMap<String, Medium>,
    pub float_textures: HashMap<String, Value>,
    pub spectrum_textures: HashMap<String, Value>,
    /// Pictures by path and whether they are inverted.
    pub pictures: TextureTable<(PathBuf, bool)>,
    pub lost: LostPictures,
    /// Reflectance in place of a lost picture.
    pub lost_albedo: f32,
    pub emissions: Vec<Emission>,
    /// Number of lights that are named by it.
    pub numbered_lights: u32,
    pub light_names: LightNames,
    /// A sky that the options give stands in for one whose picture is not there.
    pub replaces_sky: bool,
    pub defaults: Vec<Defaults>,
    pub objects: HashMap<String, Vec<Mesh>>,
    pub recording: Option<Recording>,
    /// How each material maps texture coordinates, by material id.
    pub material_maps: Vec<Mapping>,
    /// Materials made so far, by all that they consist of.
    pub known_materials: HashMap<String, u32>,
    pub default_surface: Option<u32>,
    /// Triangles and vertices made so far, in the scene and in objects.
    pub triangles_made: usize,
    pub vertices_made: usize,
    /// Where a hostile file is stopped.
    pub max_triangles: usize,
    pub film: Option<Film>,
    open: Vec<PathBuf>,
    includes: usize,
    text_read: u64,
}

impl Reader {
    pub fn new(path: &Path) -> Self {
        Self {
            files: Files::default(),
            warnings: Warnings::default(),
            scene: Scene {
                source: path.to_path_buf(),
                ..Scene::default()
            },
            phase: Phase::Options,
            state: State::new(),
            saved: Vec::new(),
            version_seen: None,
            systems: HashMap::new(),
            materials: HashMap::new(),
            media: HashMap::new(),
            float_textures: HashMap::new(),
            spectrum_textures: HashMap::new(),
            pictures: TextureTable::new(),
            lost: LostPictures::default(),
            lost_albedo: LoadOptions::default().default_albedo,
            emissions: Vec::new(),
            numbered_lights: 0,
            light_names: LightNames::default(),
            replaces_sky: false,
            defaults: Vec::new(),
            objects: HashMap::new(),
            recording: None,
            material_maps: Vec::new(),
            known_materials: HashMap::new(),
            default_surface: None,
            triangles_made: 0,
            vertices_made: 0,
            max_triangles: MAX_TRIANGLES,
            film: None,
            open: Vec::new(),
            includes: 0,
            text_read: 0,
        }
    }

    /// The version whose rules hold.
    pub fn version(&self) -> Version {
        self.version_seen.unwrap_or(Version::V4)
    }

    /// A word that only one version has; the first such word decides.
    pub fn sees(&mut self, version: Version) {
        self.version_seen.get_or_insert(version);
    }

    /// Notes a warning.
    pub fn warn(&mut self, place: Place, message: impl Into<String>) {
        self.warnings.add(place, message);
    }

    /// Reads the scene's first file to its end and checks that all is closed.
    pub fn main_file(&mut self, path: &Path) -> Read<()> {
        let bytes = self.bytes(path).map_err(|source| {
            let path = path.to_path_buf();
            Fault::Elsewhere(SceneError::Io { path, source })
        })?;
        self.main_text(path, &bytes)
    }

    /// [`Reader::main_file`] for a file's content.
    pub fn main_text(&mut self, path: &Path, bytes: &[u8]) -> Read<()> {
        let file = self.files.id(path);
        let end = self.follow(path, file, bytes)?;
        self.check_closed(0)?;
        match (self.phase, self.version()) {
            (Phase::Options, _) => fault(
                end,
                "the file ends without WorldBegin, so it has no scene; is it truncated?",
            ),
            (Phase::World, Version::V3) => {
                fault(end, "the file ends without WorldEnd; is it truncated?")
            }
            _ => Ok(()),
        }
    }

    /// Reads a file that `Include` or `Import` names.
    pub fn include(&mut self, name: &str, place: Place) -> Read<()> {
        if self.open.len() >= MAX_INCLUDE_DEPTH {
            return fault(
                place,
                format!("files include one another more than {MAX_INCLUDE_DEPTH} deep"),
            );
        }
        self.includes += 1;
        if self.includes > MAX_INCLUDES {
            return fault(
                place,
                format!("more than {MAX_INCLUDES} files are included"),
            );
        }
        let path = self.beside(name, place);
        let unreadable = |source: std::io::Error| Fault::At {
            place,
            message: format!("{} cannot be read: {source}", path.display()),
        };
        let same = path.canonicalize().map_err(unreadable)?;
        if self.open.contains(&same) {
            return fault(place, format!("{} includes itself", path.display()));
        }
        let bytes = self.bytes(&path).map_err(unreadable)?;
        let file = self.files.id(&path);
        let blocks = self.saved.len();
        self.follow(&path, file, &bytes)?;
        self.check_closed(blocks)
    }

    /// Follows the text of one file; returns its end.
    fn follow(&mut self, path: &Path, id: u32, bytes: &[u8]) -> Read<Place> {
        let text = file::text(bytes);
        check_text(&text, id)?;
        self.open
            .push(path.canonicalize().unwrap_or_else(|_| path.to_path_buf()));
        let mut tokens = Tokens::new(&text, id);
        while self.directive(&mut tokens)? {}
        self.open.pop();
        Ok(tokens.here())
    }

    /// A small text file that a parameter names.
    pub fn text_file(&mut self, path: &Path) -> std::io::Result<String> {
        Ok(file::text(&self.bytes(path)?).into_owned())
    }

    /// A regular file's content, within the limit of all text.
    pub fn bytes(&mut self, path: &Path) -> std::io::Result<Vec<u8>> {
        let bytes = file::read(path)?;
        self.text_read = self.text_read.saturating_add(bytes.len() as u64);
        if self.text_read > MAX_TEXT {
            return Err(std::io::Error::other(
                "all files together have more than 8 GiB of text",
            ));
        }
        Ok(bytes)
    }

    /// Blocks beyond the first `before` must be closed where a file ends.
    fn check_closed(&self, before: usize) -> Read<()> {
        match self.saved.get(before..).and_then(<[Saved]>::last) {
            Some(saved) => {
                let name = saved.block.name();
                fault(
                    saved.place,
                    format!("{name}Begin has no {name}End; is the file truncated?"),
                )
            }
            None => Ok(()),
        }
    }

    /// A file named in the text: relative to the main file, as pbrt has it, else to the file
    /// of the text.
    pub fn beside(&mut self, name: &str, place: Place) -> PathBuf {
        let here = self.files.path(place.file);
        let folders = [self.scene.source.as_path(), &here].map(|file| file.parent());
        let folders = folders.map(|folder| folder.unwrap_or(Path::new("")));
        let found = resolve::find(&folders, name);
        if found.is_guess {
            let message = format!("\"{name}\" is read from {}", found.path.display());
            self.warn(place, message);
        }
        found.path
    }

    /// Saves the graphics state.
    pub fn push(&mut self, block: Block, place: Place) -> Read<()> {
        const DEEPEST: usize = 10_000;
        if self.saved.len() >= DEEPEST {
            return fault(place, format!("blocks are nested more than {DEEPEST} deep"));
        }
        self.saved.push(Saved {
            block,
            place,
            state: self.state,
        });
        Ok(())
    }

    /// Restores the graphics state that the same kind of block saved.
    pub fn pop(&mut self, block: Block, place: Place) -> Read<()> {
        let name = block.name();
        let Some(saved) = self.saved.pop() else {
            return fault(place, format!("{name}End without {name}Begin"));
        };
        if saved.block != block {
            let open = saved.block.name();
            let message = format!("{name}End inside {open}Begin of line {}", saved.place.line);
            // pbrt's version 3 has one stack for attributes and objects, and takes them crossed.
            let is_tolerated = self.version_seen != Some(Version::V4)
                && ![block, saved.block].contains(&Block::Transform);
            if !is_tolerated {
                return fault(place, message);
            }
            self.warn(place, format!("{message}: each ends the innermost block"));
        }
        match block {
            Block::Transform => self.state.ctm = saved.state.ctm,
            Block::Attribute | Block::Object => self.state = saved.state,
        }
        Ok(())
    }

    /// Judges the parameters that nothing asked for: version 4 refuses them, version 3 reads
    /// on as pbrt itself does.
    pub fn check_unused(&mut self, params: &Params) -> Read<()> {
        for param in params.unused() {
            let message = format!("{} has no parameter \"{}\"", params.owner, param.name);
            match self.version() {
                Version::V4 => return fault(param.place, message),
                Version::V3 => self.warn(param.place, format!("{message}; it is ignored")),
            }
        }
        Ok(())
    }

    /// The scene, once all is read.
    pub fn finish(mut self) -> Scene {
        self.finish_cameras();
        self.scene.textures = self.pictures.into_textures();
        self.scene.warnings = self.warnings.finish(&self.files);
        let lost = self.lost.warning(&self.scene.source, self.lost_albedo);
        self.scene.warnings.extend(lost);
        self.scene
    }
}

/// Refuses what is no text at the first byte that shows it.
fn check_text(text: &str, file: u32) -> Read<()> {
    let Some(nul) = text.find('\0') else {
        return Ok(());
    };
    let good = text.get(..nul).unwrap_or_default();
    let line = good.matches('\n').count() as u32 + 1;
    let column = good.rsplit('\n').next().unwrap_or_default().chars().count() as u32 + 1;
    fault(
        Place { file, line, column },
        "this is not text, as pbrt scenes are; is it a binary file?",
    )
}
