use super::*;
use crate::Preset;
use crate::settings::Method;

fn read(text: &str) -> Result<Settings, BakeError> {
    Settings::from_table(&text.parse().unwrap())
}

/// Every option has a key, and means the same as on the command line.
#[test]
fn a_table_means_what_the_options_mean() {
    let table = "light_box = [-1, 0, 0.5, 1, 2, 3.25]\neye_box = [0, 0, 0, 1, 1, 1]\ntarget = 0.1\n\
        seed = 7\npreset = \"fine\"\nmethod = \"nearest\"\nhidden = [8, 4]\ninputs = [\"px\", \"ny\"]\n\
        rows = 10\npaths = 2\ncells = 3\nrounds = 4\nmost_cells = 5\ntrim = false\n\
        default_albedo = 0.25\nlight_units = \"raw\"\n\
        sky = [1, 2, 3]\nsky_rotate = -30";
    let options = "--light-box=-1,0,0.5,1,2,3.25 --eye-box 0,0,0,1,1,1 --target 0.1 --seed 7 --preset fine \
        --method nearest --hidden 8,4 --inputs px,ny --rows 10 --paths 2 --cells 3 --rounds 4 \
        --most-cells 5 --no-trim --default-albedo 0.25 --light-units raw \
        --sky 1,2,3 --sky-rotate -30";
    let typed = Options::try_parse_from(options.split_whitespace()).unwrap();
    assert_eq!(
        format!("{:?}", read(table).unwrap()),
        format!("{:?}", typed.settings)
    );
    let keys = table.parse::<Table>().unwrap();
    assert!(
        Options::command()
            .get_arguments()
            .all(|arg| keys.contains_key(arg.get_id().as_str()))
    );
    let defaults = read("trim = true").unwrap();
    assert_eq!((defaults.preset, defaults.trim), (Preset::Standard, true));
    assert_eq!(defaults.method, Method::Transfer);
}

#[test]
fn wrong_values_are_named() {
    for (text, words) in [
        (
            "colour = 1",
            "colour: is no setting; the settings are light_box, eye_box",
        ),
        ("no_trim = true", "no_trim: is no setting"),
        ("trim = 1", "trim: needs true or false"),
        (
            "target = -1",
            "settings: invalid value '-1' for '--target <TARGET>': has to be above 0",
        ),
        ("target = [1, 2]", "is not a number"),
        (
            "preset = \"best\"",
            "[possible values: preview, standard, fine]",
        ),
        ("rounds = 0", "--rounds <N>"),
        ("rows = { n = 1 }", "rows: cannot be"),
        (
            "light_box = [1, 1, 1, 0, 2, 2]",
            "smaller one on every axis",
        ),
        ("default_albedo = 1.5", "from 0 to 1"),
        ("sky = [1, 2]", "needs 3 numbers"),
        ("sky = [1, 2, -3]", "cannot be negative"),
        ("sky_rotate = 3", "--sky <FILE.exr|r,g,b>"),
        ("inputs = [\"qx\"]", "is no input of a net"),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains(words), "{text}: {error}");
    }
}
