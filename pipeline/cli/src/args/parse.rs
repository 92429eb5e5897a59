//! From typed text to values, with what would be right where it is wrong.

use rrf_bake::settings::parse::numbers;

pub fn parse_vec3(text: &str) -> Result<[f32; 3], String> {
    numbers::<3>(text)
}

pub fn parse_light(text: &str) -> Result<[f32; 6], String> {
    if text.split(',').count() == 3 {
        let p = numbers::<3>(text)?;
        return Ok([p[0], p[1], p[2], 1.0, 1.0, 1.0]);
    }
    let l = numbers::<6>(text).map_err(|e| format!("{e} (or 3 for a light of 1 W/sr)"))?;
    if l[3..].iter().any(|&x| x < 0.0) {
        return Err("an intensity cannot be negative".into());
    }
    Ok(l)
}

/// A sun by azimuth, elevation and, perhaps, irradiance.
pub fn parse_sun(text: &str) -> Result<[f32; 5], String> {
    let sun = match text.split(',').count() {
        2 => {
            let [azimuth, elevation] = numbers::<2>(text)?;
            [azimuth, elevation, 1.0, 1.0, 1.0]
        }
        _ => numbers::<5>(text).map_err(|e| format!("{e} (or 2 for a sun of 1 W/m²)"))?,
    };
    if !(-90.0..=90.0).contains(&sun[1]) {
        return Err("the elevation is from -90 to 90 degrees".into());
    }
    if sun[2..].iter().any(|&x| x < 0.0) {
        return Err("an irradiance cannot be negative".into());
    }
    Ok(sun)
}

/// An own light times a factor.
#[derive(Clone, Debug, PartialEq)]
pub struct LightDim {
    /// Its name.
    pub name: String,
    /// Factor a channel.
    pub factor: [f32; 3],
}

/// `NAME=r,g,b`; a name may hold an equals sign.
pub fn parse_dim(text: &str) -> Result<LightDim, String> {
    let (name, factor) = text.rsplit_once('=').ok_or("needs NAME=r,g,b")?;
    let factor = numbers::<3>(factor)?;
    if factor.iter().any(|&x| x < 0.0) {
        return Err("a factor cannot be negative".into());
    }
    Ok(LightDim {
        name: name.to_string(),
        factor,
    })
}

/// An own light's new place.
#[derive(Clone, Debug, PartialEq)]
pub struct LightMove {
    /// Its name.
    pub name: String,
    /// World position.
    pub to: [f32; 3],
}

/// `NAME:x,y,z`; a name may hold a colon.
pub fn parse_move(text: &str) -> Result<LightMove, String> {
    let (name, to) = text.rsplit_once(':').ok_or("needs NAME:x,y,z")?;
    Ok(LightMove {
        name: name.to_string(),
        to: numbers::<3>(to)?,
    })
}

pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match parsed {
        Some([w, h]) if (1..=16384).contains(&w) && (1..=16384).contains(&h) => Ok([w, h]),
        _ => Err("needs WIDTHxHEIGHT, each from 1 to 16384, for example 640x480".into()),
    }
}

/// `1500000`, `512MiB`, `2GB`.
pub fn parse_bytes(text: &str) -> Result<u64, String> {
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.');
    let (number, unit) = text.split_at(digits.unwrap_or(text.len()));
    let number: f64 = number.parse().map_err(|_| format!("{text}: no size"))?;
    let scale: f64 = match unit.trim() {
        "" | "B" => 1.0,
        "kB" => 1e3,
        "MB" => 1e6,
        "GB" => 1e9,
        "KiB" => 1024.0,
        "MiB" => 1048576.0,
        "GiB" => 1073741824.0,
        _ => return Err(format!("{unit}: units are B, kB, MB, GB, KiB, MiB, GiB")),
    };
    let bytes = number * scale;
    if (1.0..1e18).contains(&bytes) {
        Ok(bytes as u64)
    } else {
        Err(format!("{text}: not a size of memory"))
    }
}
