//! The media that a path is in.
//!
//! Solids of glass may lie in each other. Where they overlap, the one that the path entered last
//! counts: a drink that reaches into its glass is the drink there. So a surface of a solid that was
//! not entered last changes nothing, and the index of refraction beyond a surface that is left is
//! that of what was entered before.

use crate::facets::Facet;
use crate::surface::Site;
use crate::tracer::Tracer;
use crate::walk::Found;
use glam::Vec3;
use rrf_materials::Bsdf;

/// Solids that a path keeps in mind; the oldest is forgotten where there are more.
const MOST: usize = 4;

/// No solid.
const NONE: u32 = u32::MAX;

/// Materials of the solids that a path is in, the one entered last first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Media([u32; MOST]);

impl Media {
    /// In none.
    pub(crate) const NONE: Media = Media([NONE; MOST]);

    pub(crate) fn is_empty(self) -> bool {
        self.0[0] == NONE
    }

    /// The material of the solid entered last.
    fn last(self) -> Option<u32> {
        (self.0[0] != NONE).then_some(self.0[0])
    }

    fn enter(&mut self, material: u32) {
        self.0.rotate_right(1);
        self.0[0] = material;
    }

    /// Leaves the solid of this material that was entered last.
    fn leave(&mut self, material: u32) {
        if let Some(at) = self.0.iter().position(|&m| m == material) {
            self.0[at..].rotate_left(1);
            self.0[MOST - 1] = NONE;
        }
    }

    /// After a path has crossed a surface that encloses a solid.
    pub(crate) fn cross(&mut self, facet: &Facet, inside: bool) {
        if inside {
            self.leave(facet.material);
        } else {
            self.enter(facet.material);
        }
    }
}

impl Tracer<'_> {
    fn index_of(&self, material: Option<u32>) -> f32 {
        let found = material.and_then(|m| self.materials.get(m as usize));
        found.map_or(1.0, |bsdf| (bsdf.kind.index)(bsdf))
    }

    /// A surface that encloses a solid, as a path in `media` sees it.
    pub(crate) fn between(&self, facet: &Facet, bsdf: Bsdf, media: Media) -> Bsdf {
        let own = self.index_of(Some(facet.material));
        if !bsdf.inside {
            let eta = own / self.index_of(media.last());
            return Bsdf { eta, ..bsdf };
        }
        let (mut beyond, here) = (media, media.last());
        beyond.leave(facet.material);
        if here.is_some_and(|here| here != facet.material) && beyond != media {
            return Bsdf::CLEAR;
        }
        let eta = self.index_of(beyond.last()) / own;
        Bsdf { eta, ..bsdf }
    }

    /// The point of a hit as a path in `media` sees it that has stopped there.
    pub(crate) fn site_of(&self, hit: &Found, media: Media, viewer: Vec3) -> Site {
        let mut site = self.site(hit.triangle, hit.barycentrics);
        let facet = &self.facets[hit.triangle as usize];
        if facet.passes {
            site.bsdf = site.bsdf.without_straight();
        }
        if facet.encloses && !media.is_empty() {
            let seen = self.between(facet, site.seen_from(viewer).bsdf, media);
            let eta = if seen.inside {
                1.0 / seen.eta
            } else {
                seen.eta
            };
            site.bsdf = Bsdf {
                eta,
                inside: false,
                ..seen
            };
        }
        site
    }

    /// Share of light that is left after `distance` metres up to a surface seen from `viewer`: in
    /// the solid entered last or, where a path began inside, in what the surface encloses.
    pub(crate) fn left_after(
        &self,
        distance: f32,
        media: Media,
        facet: &Facet,
        viewer: Vec3,
    ) -> Vec3 {
        let within = facet.encloses && facet.is_inside(viewer);
        let material = media.last().or(within.then_some(facet.material));
        let bsdf = material.and_then(|m| self.materials.get(m as usize));
        match bsdf.and_then(Bsdf::interior) {
            Some(absorption) if absorption != Vec3::ZERO => (absorption * -distance).exp(),
            _ => Vec3::ONE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Overlapping solids are left in any order.
    #[test]
    fn the_one_entered_last_counts() {
        let mut media = Media::NONE;
        media.enter(7);
        media.enter(9);
        assert_eq!(media.last(), Some(9));
        media.leave(7);
        assert_eq!(media.last(), Some(9));
        media.leave(9);
        assert!(media.is_empty());
        media.leave(9);
        assert!(media.is_empty());
        for material in 0..6 {
            media.enter(material);
        }
        media.leave(5);
        assert_eq!(media.last(), Some(4));
        for material in [2, 3, 4] {
            media.leave(material);
        }
        assert!(media.is_empty());
    }
}
