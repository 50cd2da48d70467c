//! What an ICC profile says of the transfer curve (ICC.1:2022, 10.6 and 10.18).

use super::Embedded;

/// Curves of the first colour that is there: red, or grey.
const CURVES: [&[u8; 4]; 2] = [b"rTRC", b"kTRC"];
/// Fixed numbers of 16 fractional bits, and of 8.
const FIXED16: f64 = 65536.0;
const FIXED8: f64 = 256.0;
/// Exponent of the power in sRGB's curve.
const SRGB_POWER: f64 = 2.4;

/// The curve of `profile`; `None` if it has none, or is damaged.
pub(super) fn curve(profile: &[u8]) -> Option<Embedded> {
    let count = (long(profile, 128)? as usize).min(100);
    let tags = || (0..count).map(|i| 132 + 12 * i);
    let entry =
        CURVES.iter().find_map(|name| tags().find(|&at| profile.get(at..at + 4) == Some(&name[..])))?;
    let at = long(profile, entry + 4)? as usize;
    let power =
        |gamma: f64| if (gamma - 1.0).abs() < 1e-3 { Embedded::Linear } else { Embedded::Gamma(gamma) };
    match profile.get(at..at.checked_add(4)?)? {
        b"curv" => Some(match long(profile, at + 8)? {
            0 => Embedded::Linear,
            1 => power(f64::from(short(profile, at + 12)?) / FIXED8),
            _ => Embedded::Curve,
        }),
        b"para" => {
            let kind = short(profile, at + 8)?;
            let gamma = f64::from(long(profile, at + 12)?) / FIXED16;
            Some(match kind {
                0 => power(gamma),
                3 if (gamma - SRGB_POWER).abs() < 1e-3 => Embedded::Srgb,
                _ => Embedded::Curve,
            })
        }
        _ => None,
    }
}

fn short(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_be_bytes(bytes.get(at..at.checked_add(2)?)?.try_into().ok()?))
}

fn long(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_be_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(name: &[u8; 4], tag: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0; 128];
        bytes.extend(1_u32.to_be_bytes());
        bytes.extend(name);
        bytes.extend(144_u32.to_be_bytes());
        bytes.extend((tag.len() as u32).to_be_bytes());
        bytes.extend(tag);
        bytes
    }

    #[test]
    fn linear_curves_powers_and_others_are_told_apart() {
        let curv = |numbers: &[u8]| [b"curv\0\0\0\0", numbers].concat();
        let read = |tag: Vec<u8>| curve(&profile(b"rTRC", &tag));
        assert_eq!(read(curv(&[0, 0, 0, 0])), Some(Embedded::Linear));
        assert_eq!(read(curv(&[0, 0, 0, 1, 1, 0])), Some(Embedded::Linear));
        assert_eq!(read(curv(&[0, 0, 0, 1, 2, 0])), Some(Embedded::Gamma(2.0)));
        assert_eq!(read(curv(&[0, 0, 4, 0])), Some(Embedded::Curve));
        let para = |kind: u8, gamma: f64| {
            let fixed = ((gamma * FIXED16) as u32).to_be_bytes();
            [&b"para\0\0\0\0\0"[..], &[kind, 0, 0], &fixed].concat()
        };
        assert_eq!(read(para(0, 1.0)), Some(Embedded::Linear));
        assert_eq!(read(para(3, 2.4)), Some(Embedded::Srgb));
        assert_eq!(read(para(4, 2.4)), Some(Embedded::Curve));
        assert_eq!(curve(&profile(b"kTRC", &curv(&[0, 0, 0, 0]))), Some(Embedded::Linear));
        assert_eq!(curve(&profile(b"desc", &curv(&[0, 0, 0, 0]))), None);
    }

    #[test]
    fn damaged_profiles_say_nothing() {
        let whole = profile(b"rTRC", b"curv\0\0\0\0\0\0\0\x01\x02\0");
        for length in 0..whole.len() {
            assert_eq!(curve(&whole[..length]), None, "{length}");
        }
    }
}
