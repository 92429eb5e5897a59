//! Names of a scene's own lights.

use std::collections::HashSet;

/// Names that a light which is no environment may not bear: lights of a points table.
pub const RESERVED_NAMES: [&str; 3] = ["point", "sun", "sky"];

/// Name of the environment.
pub const SKY: &str = "sky";

/// Gives lights names that none shares: `wanted`, with `.own` where that is reserved, and `.2`,
/// `.3` … from the second light of a name on.
#[derive(Clone, Debug, Default)]
pub struct LightNames {
    taken: HashSet<String>,
}

impl LightNames {
    /// The name of the next light.
    pub fn unique(&mut self, wanted: &str) -> String {
        let base = if RESERVED_NAMES.contains(&wanted) {
            format!("{wanted}.own")
        } else {
            wanted.to_string()
        };
        let mut name = base.clone();
        let mut number = 2;
        while !self.taken.insert(name.clone()) {
            name = format!("{base}.{number}");
            number += 1;
        }
        name
    }

    /// The name of the environment: [`SKY`] for the first one.
    pub fn sky(&mut self) -> String {
        match self.taken.insert(SKY.to_string()) {
            true => SKY.to_string(),
            false => self.unique(SKY),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_none_is_reserved() {
        let mut names = LightNames::default();
        let given = ["lamp", "sun", "lamp", "sun", "point", "lamp"].map(|n| names.unique(n));
        let wanted = [
            "lamp",
            "sun.own",
            "lamp.2",
            "sun.own.2",
            "point.own",
            "lamp.3",
        ];
        assert_eq!(given, wanted);
        assert_eq!(
            (names.sky(), names.unique("sky")),
            ("sky".into(), "sky.own".into())
        );
    }
}
