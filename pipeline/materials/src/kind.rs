//! A kind of material and the questions that it answers.

use crate::math::pick;
use crate::slot::{Slot, Storage, own_numbers};
use crate::{Lane, Lane3, Parts, TILE};
use glam::Vec3;
use std::fmt;

/// How a surface scatters light: one kind of material, described once. All kinds are two-sided.
///
/// World frame. `n` is the unit shading normal on the viewer's side, `v` points to the viewer
/// (n.v > 0), `l` to where the light comes from. Values are f(v, l) |cos(theta_l)| \[1/sr\] of
/// radiance; densities are with respect to solid angle about `l`. Light from below the surface
/// (n.l < 0) is scattered by kinds that transmit alone. Functions of frequent kinds are free of
/// branches, so that loops over columns vectorise.
pub struct MaterialKind {
    /// Its name in summaries.
    pub name: &'static str,
    /// Its number in the scene hash, below 32; never given to another kind.
    pub number: u32,
    /// Its parameters, in the order of summaries and exports.
    pub slots: &'static [Slot],
    /// Mitsuba 3's plugin of the same definition.
    pub mitsuba: &'static str,
    /// Whether what it sends depends on where it is seen from. Nets of cells without such
    /// surfaces need no view direction.
    pub depends_on_viewer: bool,
    /// Whether it reflects nothing at all.
    pub is_black: fn(&Bsdf) -> bool,
    /// Whether light from below the surface reaches the viewer.
    pub transmits: bool,
    /// Index of refraction of what lies below the surface, relative to the vacuum; 1 where it does
    /// not matter.
    pub index: fn(&Bsdf) -> f32,
    /// Absorption of what the surface encloses [1/m], if light travels there.
    pub interior: fn(&Bsdf) -> Option<Vec3>,
    /// Share of the light that goes straight through toward a viewer, by n.v.
    pub straight: fn(&Bsdf, f32) -> Vec3,
    /// Its microfacet lobe, if it has one: flat surfaces with a narrow lobe are mirrors.
    pub lobe: fn(&Bsdf) -> Option<Lobe>,
    /// The parts that it has with these parameters.
    pub parts: fn(&Bsdf) -> Parts,
    /// Value for (n, v, l).
    pub eval: fn(&Bsdf, Vec3, Vec3, Vec3) -> Vec3,
    /// Density of `sample` for (n, v, l).
    pub pdf: fn(&Bsdf, Vec3, Vec3, Vec3) -> f32,
    /// A direction for (n, v) from three numbers in [0, 1).
    pub sample: fn(&Bsdf, Vec3, Vec3, [f32; 3]) -> Scatter,
    /// `eval` and `pdf` of the lanes of this kind for (n, v, l).
    pub(crate) eval_lanes: fn(&MaterialLanes, [&Lane3; 3], &mut Scattered),
    /// `sample` of the lanes of this kind for (n, v) and three numbers.
    pub(crate) sample_lanes: fn(&MaterialLanes, [&Lane3; 2], [&Lane; 3], &mut Scattered),
}

/// A microfacet lobe at normal incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// GGX alpha.
    pub alpha: f32,
    /// Reflectance, the largest channel.
    pub reflectance: f32,
}

impl PartialEq for MaterialKind {
    fn eq(&self, other: &MaterialKind) -> bool {
        self.number == other.number
    }
}

impl fmt::Debug for MaterialKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl MaterialKind {
    /// Whether the kind has a parameter that stands there.
    pub fn has(&self, storage: Storage) -> bool {
        self.slots.iter().any(|slot| slot.storage == storage)
    }

    /// Whether its parameters fit into [`Bsdf::own`] and its number into a bit mask.
    pub(crate) const fn fits(&self) -> bool {
        own_numbers(self.slots) <= OWN && self.number < 32
    }
}

/// Room for the further parameters of a kind: eta and k of a conductor take six.
pub(crate) const OWN: usize = 8;

/// Material parameters at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bsdf {
    /// Scattering model.
    pub kind: &'static MaterialKind,
    /// Linear sRGB reflectance.
    pub base_color: Vec3,
    /// Perceptual roughness in [0, 1].
    pub roughness: f32,
    /// Metalness in [0, 1].
    pub metallic: f32,
    /// Dielectric specular in [0, 1].
    pub specular: f32,
    /// Further numbers, whose places the kind's slots name.
    pub own: [f32; OWN],
    /// The parts that value, density and sampler take; [`Parts::ALL`] unless taken apart.
    pub parts: Parts,
    /// Index of refraction beyond the surface over that on the viewer's side.
    pub eta: f32,
    /// Whether the viewer is in what the surface encloses.
    pub inside: bool,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Unit direction, world frame.
    pub l: Vec3,
    /// f cos(theta_l) / pdf; zero when nothing is scattered there.
    pub weight: Vec3,
    /// Density of `l` with respect to solid angle; [`CERTAIN`] for a direction that sharp reflection
    /// or refraction leaves no choice of.
    pub pdf: f32,
}

impl Scatter {
    /// A direction of the value f cos(theta_l) and the density `pdf`.
    #[inline(always)]
    pub fn weighted(l: Vec3, value: Vec3, pdf: f32) -> Scatter {
        Scatter {
            l,
            weight: pick(pdf > 0.0, value / pdf, Vec3::ZERO),
            pdf,
        }
    }
}

/// Stands for the unbounded density of a direction without a choice: in the balance heuristic it
/// outweighs every other density to the last digit. Such lobes have no value and no density where
/// they are asked for a given direction.
pub const CERTAIN: f32 = 1e30;

impl Bsdf {
    /// f(v, l) cos(theta_l) [1/sr].
    pub fn eval(&self, n: Vec3, v: Vec3, l: Vec3) -> Vec3 {
        (self.kind.eval)(self, n, v, l)
    }

    /// Density of [`Bsdf::sample`] at `l`.
    pub fn pdf(&self, n: Vec3, v: Vec3, l: Vec3) -> f32 {
        (self.kind.pdf)(self, n, v, l)
    }

    /// A direction from three numbers in [0, 1).
    pub fn sample(&self, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
        (self.kind.sample)(self, n, v, u)
    }

    /// The columns that nets know a surface by: base colour, roughness, metallic, specular.
    pub fn columns(&self) -> [f32; 6] {
        let [r, g, b] = self.base_color.to_array();
        [r, g, b, self.roughness, self.metallic, self.specular]
    }

    /// Share of the light that goes straight through toward a viewer at n.v; black where nothing
    /// does. [`Bsdf::sample`] has this light too unless [`Parts::STRAIGHT`] is taken out.
    pub fn straight(&self, cosine: f32) -> Vec3 {
        (self.kind.straight)(self, cosine)
    }

    /// Absorption of what it encloses [1/m], if light travels there.
    pub fn interior(&self) -> Option<Vec3> {
        (self.kind.interior)(self)
    }

    /// The surface seen from within what it encloses, which has this index of refraction
    /// relative to what lies outside.
    pub fn from_within(self) -> Bsdf {
        Bsdf {
            eta: 1.0 / self.eta,
            inside: true,
            ..self
        }
    }

    /// Whether it reflects nothing, whatever the directions.
    pub fn is_black(&self) -> bool {
        (self.kind.is_black)(self)
    }
}

/// Material parameters of sixty-four points as columns.
#[derive(Clone)]
pub struct MaterialLanes {
    kind: [u32; TILE],
    base_color: Lane3,
    roughness: Lane,
    metallic: Lane,
    specular: Lane,
    own: [Lane; OWN],
    parts: [Parts; TILE],
    eta: Lane,
    inside: [bool; TILE],
    /// One bit for each kind that a lane has been given since [`MaterialLanes::clear`].
    present: u32,
}

/// Light scattered by the materials of sixty-four points.
pub struct Scattered {
    /// Directions of the light, where they were sampled.
    pub direction: Lane3,
    /// f cos(theta) [1/sr], or that over the density where the directions were sampled.
    pub value: Lane3,
    /// Density of the directions with respect to solid angle.
    pub density: Lane,
}

impl Scattered {
    /// All zero.
    pub const ZERO: Scattered = Scattered {
        direction: Lane3::ZERO,
        value: Lane3::ZERO,
        density: [0.0; TILE],
    };

    /// Writes the value and density of lane `i` where `own` holds.
    #[inline(always)]
    pub(crate) fn keep(&mut self, i: usize, own: bool, value: Vec3, density: f32) {
        self.value.set(i, pick(own, value, self.value.get(i)));
        self.density[i] = if own { density } else { self.density[i] };
    }

    /// Writes a sampled direction too.
    #[inline(always)]
    pub(crate) fn keep_sample(&mut self, i: usize, own: bool, chosen: Scatter) {
        let l = pick(own, chosen.l, self.direction.get(i));
        self.direction.set(i, l);
        self.keep(i, own, chosen.weight, chosen.pdf);
    }
}

impl MaterialLanes {
    /// All zero.
    pub const ZERO: MaterialLanes = MaterialLanes {
        kind: [0; TILE],
        base_color: Lane3::ZERO,
        roughness: [0.0; TILE],
        metallic: [0.0; TILE],
        specular: [0.0; TILE],
        own: [[0.0; TILE]; OWN],
        parts: [Parts::ALL; TILE],
        eta: [1.0; TILE],
        inside: [false; TILE],
        present: 0,
    };

    /// Forgets which kinds are present.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.present = 0;
    }

    /// Writes lane `i`.
    #[inline(always)]
    pub fn set(&mut self, i: usize, bsdf: &Bsdf) {
        self.kind[i] = bsdf.kind.number;
        self.base_color.set(i, bsdf.base_color);
        self.roughness[i] = bsdf.roughness;
        self.metallic[i] = bsdf.metallic;
        self.specular[i] = bsdf.specular;
        self.parts[i] = bsdf.parts;
        self.eta[i] = bsdf.eta;
        self.inside[i] = bsdf.inside;
        let own = bsdf.own.iter().take(own_numbers(bsdf.kind.slots));
        for (lane, &number) in self.own.iter_mut().zip(own) {
            lane[i] = number;
        }
        self.present |= 1 << bsdf.kind.number;
    }

    /// Lane `i`, taken to be of `kind`.
    #[inline(always)]
    pub(crate) fn get(&self, i: usize, kind: &'static MaterialKind) -> Bsdf {
        let mut own = [0.0; OWN];
        for (number, lane) in own.iter_mut().zip(&self.own) {
            *number = lane[i];
        }
        Bsdf {
            kind,
            base_color: self.base_color.get(i),
            roughness: self.roughness[i],
            metallic: self.metallic[i],
            specular: self.specular[i],
            own,
            parts: self.parts[i],
            eta: self.eta[i],
            inside: self.inside[i],
        }
    }

    /// Whether lane `i` is of `kind`.
    #[inline(always)]
    pub(crate) fn is(&self, i: usize, kind: &MaterialKind) -> bool {
        self.kind[i] == kind.number
    }

    /// Whether a lane is of `kind`.
    #[inline(always)]
    pub(crate) fn has(&self, kind: &MaterialKind) -> bool {
        self.present >> kind.number & 1 == 1
    }

    /// Whether no lane is of another kind than `kind`.
    #[inline(always)]
    pub(crate) fn has_only(&self, kind: &MaterialKind) -> bool {
        self.present & !(1 << kind.number) == 0
    }
}

/// Makes the functions `eval_lanes` and `sample_lanes` of a kind from its `eval`, `pdf` and `sample`,
/// for the widest instruction set that the processor has. Lanes of other kinds keep what they have.
macro_rules! scatter_lanes {
    ($kind:ident) => {
        const _: () = assert!($kind.fits());

        #[multiversion::multiversion(targets(
            "x86_64+avx512f+avx512vl+avx512bw+avx512dq",
            "x86_64+avx2"
        ))]
        fn eval_lanes(
            lanes: &crate::MaterialLanes,
            [n, v, l]: [&crate::Lane3; 3],
            out: &mut crate::Scattered,
        ) {
            for i in 0..crate::TILE {
                let bsdf = lanes.get(i, &$kind);
                let (n, v, l) = (n.get(i), v.get(i), l.get(i));
                let (value, density) = (eval(&bsdf, n, v, l), pdf(&bsdf, n, v, l));
                out.keep(i, lanes.is(i, &$kind), value, density);
            }
        }

        #[multiversion::multiversion(targets(
            "x86_64+avx512f+avx512vl+avx512bw+avx512dq",
            "x86_64+avx2"
        ))]
        fn sample_lanes(
            lanes: &crate::MaterialLanes,
            [n, v]: [&crate::Lane3; 2],
            u: [&crate::Lane; 3],
            out: &mut crate::Scattered,
        ) {
            for i in 0..crate::TILE {
                let bsdf = lanes.get(i, &$kind);
                let chosen = sample(&bsdf, n.get(i), v.get(i), u.map(|u| u[i]));
                out.keep_sample(i, lanes.is(i, &$kind), chosen);
            }
        }
    };
}
pub(crate) use scatter_lanes;
