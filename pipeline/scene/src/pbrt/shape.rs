//! Shapes as triangles.

use super::fault::{Fault, Place, Read, fault};
use super::mesh::Local;
use super::params::Params;
use super::ply;
use super::reader::Reader;
use super::revolve::{ALONG, AROUND, cone, cylinder, disk, paraboloid, revolve, sphere};
use super::state::Version;
use crate::INVALID;

impl Reader {
    /// `Shape`.
    pub fn shape(&mut self, kind: &str, at: Place, params: &Params) -> Read<()> {
        let (mut local, quadric) = match kind {
            "trianglemesh" => (self.triangle_mesh(params)?, false),
            "loopsubdiv" => {
                params.ignore(&["levels", "nlevels", "scheme"]);
                self.warn(
                    params.place,
                    "a subdivision surface is approximated by its control mesh",
                );
                (self.triangle_mesh(params)?, false)
            }
            "bilinearmesh" => (self.bilinear_mesh(params)?, false),
            "plymesh" => (self.ply_mesh(params)?, false),
            "sphere" | "cylinder" | "disk" | "cone" | "paraboloid" => {
                (self.quadric(kind, params)?, true)
            }
            "curve" | "hyperboloid" | "heightfield" | "heightfield2" | "nurbs" => {
                return fault(
                    at,
                    format!("Shape \"{kind}\" is not read here; turn it into a mesh"),
                );
            }
            _ => return fault(at, format!("unknown shape \"{kind}\"")),
        };
        let visible = self.visible(params)?;
        self.check_unused(params)?;
        if !visible {
            return Ok(());
        }
        let Some(material) = self.material_of(self.state.surface) else {
            self.warn(
                params.place,
                "a shape without a surface (an interface of media) is left out",
            );
            return Ok(());
        };
        let name = format!("{kind} {}:{}", params.place.line, params.place.column);
        self.texture_coordinates(&mut local, material);
        local.reverse_normals |= self.version() == Version::V4;
        let mut mesh = local.placed(&self.state.ctm, self.state.reverse, name, params.place)?;
        mesh.material = material;
        mesh.lights = self.lights_of(&mesh, quadric, params.place)?;
        self.add_mesh(mesh, params.place)
    }

    /// Gives a textured shape, or one that shines by a picture, the coordinates that its
    /// material's mapping makes.
    fn texture_coordinates(&self, local: &mut Local, material: u32) {
        let textured = self
            .scene
            .materials
            .get(material as usize)
            .is_some_and(|material| {
                material.base_texture != INVALID || material.normal_texture != INVALID
            });
        if !textured && !self.shines_by_picture() {
            return;
        }
        if local.uvs.is_empty() {
            *local = std::mem::take(local).with_default_uvs();
        }
        if let Some(map) = self.material_maps.get(material as usize) {
            local.map_uvs(map);
        }
    }

    /// Cut-out maps are left out; whether the shape is there at all.
    fn visible(&mut self, params: &Params) -> Read<bool> {
        for name in ["alpha", "shadowalpha"] {
            let Some(place) = params.place_of(name) else {
                continue;
            };
            match (name, self.float_texture(params, name)?) {
                (_, Some(1.0)) => {}
                ("alpha", Some(0.0)) => {
                    self.warn(place, "a shape of \"alpha\" 0 is left out");
                    return Ok(false);
                }
                _ => self.warn(
                    place,
                    format!("\"{name}\" is left out: the shape is opaque"),
                ),
            }
        }
        Ok(true)
    }

    /// Positions, normals and texture coordinates, with their counts checked.
    fn vertices(&mut self, params: &Params) -> Read<Local> {
        let Some(positions) = params.triples("P")? else {
            return fault(params.place, format!("{} needs \"point3 P\"", params.owner));
        };
        params.ignore(&["S", "faceIndices", "discarddegenerateUVs"]);
        let normals = params.triples("N")?.unwrap_or_default();
        let uv_name = if params.has("uv") { "uv" } else { "st" };
        let uvs = params.pairs(uv_name)?.unwrap_or_default();
        for (name, count) in [("N", normals.len()), (uv_name, uvs.len())] {
            if count != 0 && count != positions.len() {
                return fault(
                    super::colour::place_of(params, name),
                    format!(
                        "\"{name}\" has {count} entries for {} positions",
                        positions.len()
                    ),
                );
            }
        }
        if positions.len() > u32::MAX as usize {
            return fault(params.place, "a mesh has more than 2^32 - 1 positions");
        }
        Ok(Local {
            positions,
            normals,
            uvs,
            ..Local::default()
        })
    }

    /// The ids of faces with `N` corners, checked.
    fn faces<const N: usize>(&self, params: &Params, positions: usize) -> Read<Vec<[u32; N]>> {
        let Some((param, ids)) = params.integers("indices")? else {
            if positions == N {
                return Ok(vec![std::array::from_fn(|i| i as u32)]);
            }
            return fault(
                params.place,
                format!("{} needs \"integer indices\"", params.owner),
            );
        };
        if ids.is_empty() || ids.len() % N != 0 {
            return fault(
                param.place,
                format!(
                    "\"indices\" has {} entries; a positive multiple of {N} is needed",
                    ids.len()
                ),
            );
        }
        if let Some((i, id)) = ids
            .iter()
            .enumerate()
            .find(|&(_, &id)| id < 0 || id >= positions as i64)
        {
            return fault(
                param.place,
                format!(
                    "entry {i} of \"indices\" is {id}, but {} has {positions} positions (0 to {})",
                    params.owner,
                    positions as i64 - 1
                ),
            );
        }
        Ok(ids
            .chunks_exact(N)
            .map(|face| std::array::from_fn(|i| face.get(i).copied().unwrap_or(0) as u32))
            .collect())
    }

    fn triangle_mesh(&mut self, params: &Params) -> Read<Local> {
        let mut local = self.vertices(params)?;
        local.triangles = self.faces::<3>(params, local.positions.len())?;
        Ok(local)
    }

    /// Patches of p00, p10, p01, p11; the normal is dp/du x dp/dv.
    fn bilinear_mesh(&mut self, params: &Params) -> Read<Local> {
        self.sees(Version::V4);
        params.ignore(&["emissionfilename"]);
        let mut local = self.vertices(params)?;
        if local.uvs.is_empty() {
            // A patch has (u, v) of its own corners, which its vertices may not share.
            self.warn(
                params.place,
                "a bilinear mesh without \"uv\" gets those of triangles",
            );
        }
        self.warn(
            params.place,
            "bilinear patches are approximated by two triangles each",
        );
        local.triangles = self
            .faces::<4>(params, local.positions.len())?
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [b, d, c]])
            .collect();
        Ok(local)
    }

    fn ply_mesh(&mut self, params: &Params) -> Read<Local> {
        params.ignore(&["displacement.edgelength"]);
        if let Some(place) = params.place_of("displacement") {
            self.warn(place, "\"displacement\" is left out");
        }
        let Some(name) = params.string("filename")? else {
            return fault(params.place, "Shape \"plymesh\" needs \"string filename\"");
        };
        let at = super::colour::place_of(params, "filename");
        let path = self.beside(name, at);
        match self.bytes(&path) {
            Ok(bytes) => ply::read(&path, &bytes).map_err(Fault::Elsewhere),
            Err(error) => fault(at, format!("{} cannot be read: {error}", path.display())),
        }
    }

    fn quadric(&mut self, kind: &str, params: &Params) -> Read<Local> {
        let float = |name: &str, default: f64| Ok(params.float(name)?.unwrap_or(default));
        let radius = float("radius", 1.0)?;
        let turn = float("phimax", 360.0)?.clamp(0.0, 360.0).to_radians();
        let size = |name: &str, value: f64| {
            if value > 0.0 && value.is_finite() {
                return Ok(value);
            }
            fault(
                params.place,
                format!(
                    "{} has the {name} {value}; it must be above 0",
                    params.owner
                ),
            )
        };
        let (radius, turn) = (size("radius", radius)?, size("phimax", turn)?);
        let profile = match kind {
            "sphere" => {
                let within = |z: f64| z.clamp(-radius, radius);
                let (a, b) = (
                    within(float("zmin", -radius)?),
                    within(float("zmax", radius)?),
                );
                size("height", a.max(b) - a.min(b))?;
                sphere(radius, a.min(b), a.max(b))
            }
            "cylinder" => {
                let (a, b) = (float("zmin", -1.0)?, float("zmax", 1.0)?);
                size("height", a.max(b) - a.min(b))?;
                cylinder(radius, a.min(b), a.max(b))
            }
            "disk" => {
                let inner = float("innerradius", 0.0)?;
                size("width", radius - inner)?;
                disk(radius, inner.max(0.0), float("height", 0.0)?)
            }
            "cone" => cone(radius, size("height", float("height", 1.0)?)?),
            _ => {
                let (a, b) = (float("zmin", 0.0)?, size("zmax", float("zmax", 1.0)?)?);
                size("height", b - a)?;
                paraboloid(radius, a.max(0.0), b)
            }
        };
        self.warn(
            params.place,
            format!(
                "{} becomes triangles: {AROUND} steps around, at most {ALONG} along",
                params.owner
            ),
        );
        Ok(revolve(&profile, turn))
    }
}
