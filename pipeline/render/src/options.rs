//! Options of a frame.

use crate::direct::ShadowRays;
use crate::proxies::AreaLights;
use rrf_field::Borders;
use rrf_field::columns::Columns;

/// Which part of the light a frame shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Part {
    /// Direct and indirect.
    #[default]
    Full,
    /// Light that arrives straight from the lights.
    Direct,
    /// Light that arrives from other surfaces.
    Indirect,
}

impl Part {
    /// Whether it has the direct light.
    pub fn has_direct(self) -> bool {
        self != Part::Indirect
    }

    /// Whether it has the indirect light.
    pub fn has_indirect(self) -> bool {
        self != Part::Direct
    }

    /// Its name in a frame's attributes.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Part::Full => "Full",
            Part::Direct => "Direct",
            Part::Indirect => "Indirect",
        }
    }
}

/// Tells for each row, light included, whether the nets were trained for it.
pub type Trusted<'a> = dyn Fn(&Columns) -> Vec<bool> + Sync + 'a;

/// Options of a frame. Negative radiance, which a net may give where there is next to none,
/// stays: errors average out.
#[derive(Clone, Copy)]
pub struct RenderOptions<'a> {
    /// Part of the light.
    pub part: Part,
    /// Camera rays a pixel are `aa` x `aa`; 0 means 1.
    pub aa: u32,
    /// The scene's area lights: needed where they shine, with the scene that has them traced.
    pub area_lights: Option<&'a AreaLights>,
    /// Sampling of lights. Point lights are otherwise exact, one shadow ray each; area
    /// lights, sky and sun are always sampled, by [`ShadowRays::default`] if need be.
    pub shadow_rays: Option<ShadowRays>,
    /// Standard error of the luminance [W/(sr m²)] that the shadow rays of a pixel go on to, where
    /// [`RenderOptions::shadow_rays`] does not fix their number; without both there are 16.
    pub noise: Option<f32>,
    /// Seed of the random numbers of shadow rays, of followed and of gathered rays.
    pub seed: u64,
    /// With it the frame has a trust layer.
    pub trusted: Option<&'a Trusted<'a>>,
    /// Final gather: rays that each camera ray sends on from broad surfaces, where direct light and
    /// the model answer in place of the model at the surface itself. 0: none.
    pub gather: u32,
    /// Rays of a pixel that are gathered where the model is not believed, and go on from surface to
    /// surface until it is. 0: it is always believed. Nets need [`RenderOptions::trusted`] for it.
    pub fallback: u32,
    /// Rays of a pixel into a narrow lobe that is not as sharp as a mirror's; 0 means 4.
    pub narrow_rays: u32,
    /// Borders of cells, if their nets are to be blended there. Takes the lights one by one.
    pub borders: Option<&'a Borders>,
    /// Asked at every tile whether the frame is still wanted; if it says yes, the frame ends with
    /// [`rrf_trace::TraceError::Halted`].
    pub halt: Option<&'a (dyn Fn() -> bool + Sync)>,
}

impl Default for RenderOptions<'_> {
    fn default() -> Self {
        RenderOptions {
            part: Part::default(),
            aa: 0,
            area_lights: None,
            shadow_rays: None,
            noise: None,
            seed: 1,
            trusted: None,
            gather: 0,
            fallback: 0,
            narrow_rays: 0,
            borders: None,
            halt: None,
        }
    }
}
