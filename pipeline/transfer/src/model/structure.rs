//! All of a model that follows from the scene and from how patches were asked for.

use super::transfer::TransferModel;
use crate::TransferError;
use crate::columns::ColumnTree;
use crate::patches::{PatchConfig, PatchSizes, Patches};
use crate::reflectance::Reflectances;
use rrf_scene::Scene;

impl TransferModel {
    /// A model without cells over a scene's patches, as a bake begins with and files leave out;
    /// `broad` as in [`crate::RowConfig`].
    ///
    /// # Errors
    /// [`TransferError::NoPatches`].
    pub fn over(
        scene: &Scene,
        patch_config: PatchConfig,
        sizes: PatchSizes,
        broad: bool,
    ) -> Result<TransferModel, TransferError> {
        let patches = Patches::new(scene, &patch_config, &sizes.field())?;
        Ok(TransferModel {
            columns: ColumnTree::new(&patches),
            used: vec![false; patches.columns()],
            reflectances: Reflectances::new(scene, broad),
            broad,
            patches,
            patch_config,
            sizes,
            receiver_points: 0,
            seed: 0,
            tree: Default::default(),
            cells: Vec::new(),
            sketch: Default::default(),
            trust: f32::INFINITY,
        })
    }

    /// Hands out words that change wherever patches or their columns change their numbers, which
    /// the cells name: a program that makes others of the same scene cannot read the cells.
    pub fn structure(&self, word: &mut dyn FnMut(u32)) {
        let patches = &self.patches;
        word(patches.len() as u32);
        for patch in 0..patches.len() as u32 {
            word(patches.object[patch as usize]);
            word(patches.material[patch as usize]);
            word(patches.first_column(patch, true));
        }
        for node in 0..self.columns.len() as u32 {
            let children = self.columns.children(node).unwrap_or_default();
            children.into_iter().for_each(&mut *word);
        }
        if !self.columns.is_empty() {
            self.columns.columns_of(0).iter().copied().for_each(word);
        }
    }
}
