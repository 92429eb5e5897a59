//! Portable float maps (PFM): pictures of 32-bit floats, rows from the bottom up.

use crate::Texture;
use glam::Vec3;

/// Whether a file is a PFM, in colour or grey.
pub(crate) fn is_pfm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'F' | b'f', space, ..] if space.is_ascii_whitespace())
}

/// Reads a PFM file of at most `most` texels; the error is a message. Values are multiplied by the
/// header's scale, as pbrt does.
pub(crate) fn read_pfm(bytes: &[u8], most: u64) -> Result<Texture, String> {
    let mut rest = bytes.get(2..).unwrap_or_default();
    let channels = if bytes.get(1) == Some(&b'F') { 3 } else { 1 };
    let width = number(&mut rest, "width")?;
    let height = number(&mut rest, "height")?;
    let scale: f32 = number(&mut rest, "scale")?;
    let (width, height): (u32, u32) = (width, height);
    let texels = u64::from(width) * u64::from(height);
    if texels == 0 || texels > most {
        return Err(format!(
            "PFM picture of {width} x {height} texels: from 1 to {most} are read"
        ));
    }
    if !(scale.is_finite() && scale != 0.0) {
        return Err(format!(
            "PFM scale {scale}: a number other than 0 is needed"
        ));
    }
    let needed = texels * channels * 4;
    if (rest.len() as u64) < needed {
        return Err(format!(
            "PFM picture of {width} x {height} texels: {} bytes of {needed}: truncated",
            rest.len()
        ));
    }
    let value = |at: usize| {
        let word = rest.get(4 * at..4 * at + 4);
        let word: [u8; 4] = word.and_then(|w| w.try_into().ok()).unwrap_or_default();
        let value = if scale < 0.0 {
            f32::from_le_bytes(word)
        } else {
            f32::from_be_bytes(word)
        };
        value * scale.abs()
    };
    let (w, h, channels) = (width as usize, height as usize, channels as usize);
    let texel = |k: usize| {
        let (x, y) = (k % w, h - 1 - k / w);
        let first = (y * w + x) * channels;
        match channels {
            3 => Vec3::new(value(first), value(first + 1), value(first + 2)),
            _ => Vec3::splat(value(first)),
        }
    };
    Ok(Texture {
        width,
        height,
        texels: (0..w * h).map(texel).collect(),
    })
}

/// The next word of the header as a number, and the one white space after it.
fn number<T: std::str::FromStr>(rest: &mut &[u8], what: &str) -> Result<T, String> {
    let start = rest.iter().position(|b| !b.is_ascii_whitespace());
    let text = rest.get(start.unwrap_or(rest.len())..).unwrap_or_default();
    let end = text.iter().position(u8::is_ascii_whitespace);
    let (word, after) = text.split_at(end.unwrap_or(text.len()).min(32));
    *rest = after.get(1..).unwrap_or_default();
    let word = std::str::from_utf8(word).ok();
    word.and_then(|word| word.parse().ok())
        .ok_or_else(|| format!("PFM header: no {what}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(head: &str, values: &[f32], little: bool) -> Vec<u8> {
        let mut bytes = head.as_bytes().to_vec();
        let word = |v: &f32| {
            if little {
                v.to_le_bytes()
            } else {
                v.to_be_bytes()
            }
        };
        bytes.extend(values.iter().flat_map(word));
        bytes
    }

    #[test]
    fn rows_go_up_in_either_order_of_bytes() {
        let values: Vec<f32> = (0..12).map(|i| i as f32).collect();
        for (head, little, scale) in [("PF\n2 2\n-1.0\n", true, 1.0), ("PF 2 2 2\n", false, 2.0)] {
            let picture = read_pfm(&file(head, &values, little), 100).unwrap();
            assert_eq!((picture.width, picture.height), (2, 2));
            assert_eq!(picture.texels[0], scale * Vec3::new(6.0, 7.0, 8.0));
            assert_eq!(picture.texels[3], scale * Vec3::new(3.0, 4.0, 5.0));
        }
        let grey = read_pfm(&file("Pf\n1 2\n-1\n", &[1.0, 2.0], true), 100).unwrap();
        assert_eq!(grey.texels, [Vec3::splat(2.0), Vec3::ONE]);
    }

    #[test]
    fn broken_files_are_messages() {
        let whole = file("PF\n2 1\n-1.0\n", &[0.0; 6], true);
        assert!(is_pfm(&whole) && !is_pfm(b"PNG") && !is_pfm(b"PF"));
        for end in 0..whole.len() {
            assert!(read_pfm(&whole[..end], 100).is_err(), "{end}");
        }
        assert!(read_pfm(&whole, 1).unwrap_err().contains("2 x 1"));
        for head in [
            "PF\n0 1\n-1\n",
            "PF\n1 1\n0\n",
            "PF\n1 1\nnan\n",
            "PF\n-1 1\n1\n",
        ] {
            assert!(
                read_pfm(&file(head, &[0.0; 6], true), 100).is_err(),
                "{head}"
            );
        }
    }
}
