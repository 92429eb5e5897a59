//! IES profiles: their own tables, symmetries, editions, hostile files.

use glam::{Mat3, Vec3};
use proptest::prelude::*;
use rrf_lights::{GoniometricLight, IesProfile, LightError, LightKind, Photometry, Profile};

/// A file of type C with four planes over a quadrant.
fn file(head: &str, tilt: &str, factors: &str) -> String {
    format!(
        "{head}[TEST] made for a test\n[MANUFAC] none\n{tilt}\n\
         1 1000 2.0 5 4 1 2 0.1 0.1 0\n{factors} 35\n\
         0 22.5 45 67.5 90\n0 30,60 90\n\
         100 90 70 40 0\n100 80 60 30 0\n100 70 50 20 0\n100 60 40 10 0\n"
    )
}

fn read(text: &str) -> IesProfile {
    IesProfile::from_bytes(text.as_bytes()).unwrap()
}

/// Direction of a vertical and horizontal angle of type C in the profile's frame.
fn direction(vertical: f32, horizontal: f32) -> Vec3 {
    let (s, c) = vertical.to_radians().sin_cos();
    let (sh, ch) = horizontal.to_radians().sin_cos();
    Vec3::new(s * ch, s * sh, c)
}

/// Every entry comes back, times multiplier and ballast factors, in all quadrants.
#[test]
fn a_profile_is_its_own_table() {
    let profile = read(&file("IESNA:LM-63-2002\n", "TILT=NONE", "0.5 1"));
    let rows = [
        [100.0, 90.0, 70.0, 40.0, 0.0],
        [100.0, 80.0, 60.0, 30.0, 0.0],
        [100.0, 70.0, 50.0, 20.0, 0.0],
        [100.0, 60.0, 40.0, 10.0, 0.0],
    ];
    for (h, row) in rows.iter().enumerate() {
        for (v, &want) in row.iter().enumerate() {
            let (vertical, horizontal) = (v as f32 * 22.5, h as f32 * 30.0);
            for mirrored in [
                horizontal,
                180.0 - horizontal,
                180.0 + horizontal,
                -horizontal,
            ] {
                let found = profile.candela(direction(vertical * 0.999_999, mirrored));
                assert!(
                    (found - want).abs() < 1e-3,
                    "{vertical} {mirrored}: {found} {want}"
                );
            }
        }
    }
    assert!((profile.at(11.25, 0.0) - 95.0).abs() < 1e-4);
    assert!((profile.at(45.0, 15.0) - 65.0).abs() < 1e-4);
    assert_eq!(profile.candela(Vec3::NEG_Z), 0.0);
}

#[test]
fn editions_differ_in_their_factors() {
    let at = |head: &str, tilt: &str| read(&file(head, tilt, "0.5 1.5")).at(0.0, 0.0);
    for head in ["", "IESNA91\n", "IESNA:LM-63-1995\n", "IESNA:LM-63-2002\n"] {
        assert_eq!(at(head, "TILT=NONE"), 150.0, "{head}");
    }
    assert_eq!(at("IES:LM-63-2019\n", "TILT=NONE"), 100.0);
    assert_eq!(
        at("IESNA91\n", "TILT=INCLUDE\n1\n3\n0 45 90\n1 .9 .8"),
        150.0
    );
}

/// I = 100 cos γ has the flux 100 π.
#[test]
fn a_lambertian_profile_has_its_flux() {
    let vertical: Vec<f32> = (0..=90).map(|v| v as f32).collect();
    let candela = vertical
        .iter()
        .map(|v| 100.0 * v.to_radians().cos().max(0.0))
        .collect();
    let profile = IesProfile::new(Photometry::C, vertical, vec![0.0], candela).unwrap();
    let flux = profile.lumens();
    // Linear between degrees: low by (π/180)²/12 = 2.5e-5; midpoints alike.
    assert!(
        (flux / (100.0 * std::f64::consts::PI) - 1.0).abs() < 1e-4,
        "{flux}"
    );
    let lamp = GoniometricLight {
        position: Vec3::Y,
        intensity: Vec3::splat(0.01),
        profile: Profile::Ies(profile, Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::NEG_Y)),
    };
    assert!((lamp.power(1.0).x - std::f32::consts::PI).abs() < 1e-3);
    // The frame's +z is the world's -y: below the lamp it is 1 W/sr, above it dark.
    let below = lamp.sample(Vec3::NEG_Y, [0.0; 2]).unwrap();
    assert!((below.irradiance.x - 0.25).abs() < 1e-4);
    assert!(lamp.sample(Vec3::Y * 3.0, [0.0; 2]).is_none());
}

/// Planes all round, half round, and those of 1995 from 90 to 270.
#[test]
fn planes_close_the_circle() {
    let planes = |angles: &[f32]| {
        let candela = angles.iter().flat_map(|a| [a + 1.0, a + 1.0]).collect();
        IesProfile::new(Photometry::C, vec![0.0, 180.0], angles.to_vec(), candela).unwrap()
    };
    let round = planes(&[0.0, 90.0, 180.0, 270.0]);
    assert!((round.at(90.0, 315.0) - (271.0 + 1.0) / 2.0).abs() < 1e-3);
    assert_eq!(round.at(90.0, -90.0), 271.0);
    let half = planes(&[0.0, 90.0, 180.0]);
    assert_eq!(half.at(90.0, 270.0), 91.0);
    let back = planes(&[90.0, 180.0, 270.0]);
    assert_eq!(back.at(90.0, 0.0), 181.0);
    assert_eq!(back.at(90.0, 315.0), 226.0);
}

/// Types A and B: the polar axis is y or x.
#[test]
fn other_photometries_turn_about_their_axes() {
    let angles = vec![-90.0f32, 0.0, 90.0];
    // Intensity rises with the vertical angle in the first table.
    let candela = [0.0, 50.0, 100.0].repeat(3);
    for (photometry, rising) in [(Photometry::A, Vec3::Y), (Photometry::B, Vec3::Y)] {
        let profile = IesProfile::new(photometry, angles.clone(), angles.clone(), candela.clone());
        let profile = profile.unwrap();
        assert!((profile.candela(Vec3::Z) - 50.0).abs() < 1e-3);
        let up = (rising + Vec3::Z).normalize();
        assert!((profile.candela(up) - 75.0).abs() < 1e-3, "{photometry:?}");
    }
    // Seen from the side, type B keeps its vertical angle on a half plane through x.
    let b = IesProfile::new(Photometry::B, angles.clone(), angles, candela).unwrap();
    let d = Vec3::new(0.5, 0.5, 0.5).normalize();
    assert!((b.candela(d) - 75.0).abs() < 1e-3);
}

#[test]
fn files_that_are_no_profile_are_refused_with_their_line() {
    let good = file("IESNA91\n", "TILT=NONE", "1 1");
    for (bad, line) in [
        (String::new(), 1),
        ("no tilt\n1 2 3".to_string(), 1),
        (good.replace("TILT=NONE", "TILT=lamp.tlt"), 4),
        (good.replace(" 5 4 1 2 ", " 5 4 7 2 "), 5),
        (good.replace(" 5 4 1 2 ", " 4000000000 4 1 2 "), 5),
        (good.replace(" 5 4 1 2 ", " 0 4 1 2 "), 5),
        (good.replace("2.0 5", "nan 5"), 5),
        (good.replace("100 60 40 10 0\n", ""), 11),
        (good.replace("0 22.5 45", "0 45 22.5"), 8),
        (good.replace("30 0\n", "-30 0\n"), 8),
    ] {
        let error = IesProfile::from_bytes(bad.as_bytes()).unwrap_err();
        let LightError::Ies {
            line: found,
            message,
        } = &error
        else {
            panic!("{error:?}");
        };
        assert!(
            found.abs_diff(line) <= 3 && !message.is_empty(),
            "{line}: {error}"
        );
    }
}

proptest! {
    /// No bytes bring the reader down, and what it accepts can be looked up everywhere.
    #[test]
    fn any_bytes_give_a_profile_or_an_error(
        words in prop::collection::vec("[0-9]{1,3}|-1|1e30|nan|x|[0-9.]{1,4}", 0..60),
        cut in 0usize..400,
    ) {
        let text = format!("IESNA91\nTILT=NONE\n1 1 1 {}", words.join(" "));
        let broken = file("IESNA91\n", "TILT=NONE", "1 1");
        for bytes in [text.as_bytes(), &broken.as_bytes()[..cut.min(broken.len())]] {
            if let Ok(profile) = IesProfile::from_bytes(bytes) {
                for d in [Vec3::Z, Vec3::NEG_Z, Vec3::ONE, Vec3::NEG_X, Vec3::Y] {
                    prop_assert!(profile.candela(d) >= 0.0);
                }
            }
        }
    }
}
