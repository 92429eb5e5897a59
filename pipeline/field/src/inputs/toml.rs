//! `schemas/inputs.toml`: the inputs for those who do not read Rust.

use super::registry::INPUTS;

/// The text of `schemas/inputs.toml`; raw columns have no formula.
pub fn toml() -> String {
    let head = "\
# Made from pipeline/field/src/inputs/registry.rs, see there; not to be changed by hand.
# What a net can read. The inputs without a formula are the raw columns of a row, in their order;
# formulas name inputs. sqrt(x) is the square root, reciprocal(x) is 1 / x where x > 0, otherwise 0.
";
    let inputs = INPUTS.iter().map(|input| {
        let mut text = format!(
            "\n[[input]]\nname = {:?}\nunit = {:?}\nframe = {:?}\nmeaning = {:?}\n",
            input.name, input.unit, input.frame, input.meaning
        );
        if let Some(formula) = input.formula {
            let words: Vec<&str> = formula.split_whitespace().collect();
            text += &format!("formula = {:?}\n", words.join(" "));
        }
        text
    });
    head.chars()
        .chain(inputs.collect::<String>().chars())
        .collect()
}
