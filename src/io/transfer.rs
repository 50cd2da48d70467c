//! From the codes of a photograph to radiance.

use super::colour::srgb_inverse;
use super::picture::{Codes, Embedded};
use crate::error::{Error, Result};
use crate::image::{Channel, Image};
use std::path::{Path, PathBuf};

/// The curve that a camera or an editor has put on radiance.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Transfer {
    /// None: codes are proportional to radiance.
    Linear,
    /// That of sRGB (IEC 61966-2-1).
    Srgb,
    /// Radiance is the code to this power; above 0.
    Gamma(f64),
    /// A measured curve.
    Response(Response),
}

/// A measured response curve: the radiance of codes, which lie between those that are given on straight lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    path: PathBuf,
    /// Codes, rising.
    values: Vec<f64>,
    /// Radiance at each, rising: one curve for all channels, or one each for R, G, B.
    radiances: Vec<Vec<f64>>,
}

/// Relative difference of two exponents from which on they are not the same.
const OTHER_GAMMA: f64 = 0.1;
/// The power that is nearest to the curve of sRGB.
const SRGB_GAMMA: f64 = 2.2;

impl Transfer {
    /// The radiance of the codes of channel number `channel` of the file `path`.
    ///
    /// # Errors
    /// [`Error::BadPixel`] if a response curve does not reach a code.
    pub fn radiance(&self, path: &Path, channel: &Channel, number: usize, codes: &Codes) -> Result<Image> {
        let table: Vec<Option<f32>> =
            (0..=codes.largest).map(|code| self.of_code(code, number, codes).map(|v| v as f32)).collect();
        let image = &channel.image;
        let data: Option<Vec<f32>> = image.data.iter().map(|&code| table[code as usize]).collect();
        let Some(data) = data else {
            let i = image.data.iter().position(|&code| table[code as usize].is_none()).unwrap_or(0);
            return Err(Error::BadPixel {
                path: path.to_path_buf(),
                channel: channel.name.clone(),
                x: i % image.width,
                y: i / image.width,
                value: f64::from(image.data[i]),
                allowed: "within the response curve of its transfer",
            });
        };
        Ok(Image { data, ..*image })
    }

    /// The radiance of a `code` in channel number `channel`; `None` beyond a measured curve.
    fn of_code(&self, code: u32, channel: usize, codes: &Codes) -> Option<f64> {
        let share = f64::from(code) / f64::from(codes.largest);
        match self {
            Self::Linear => Some(share),
            Self::Srgb => Some(srgb_inverse(share)),
            Self::Gamma(gamma) => Some(share.powf(*gamma)),
            Self::Response(response) => response.at(f64::from(code), channel),
        }
    }

    /// Whether a file that says `embedded` of itself contradicts this; a measured curve knows better.
    pub fn contradicts(&self, embedded: Embedded) -> bool {
        let is_about = |gamma: f64, other: f64| (gamma / other - 1.0).abs() < OTHER_GAMMA;
        match (self, embedded) {
            (Self::Response(_), _) => false,
            (Self::Linear, Embedded::Linear) | (Self::Srgb, Embedded::Srgb) => false,
            (Self::Srgb, Embedded::Gamma(gamma)) => !is_about(gamma, SRGB_GAMMA),
            (Self::Gamma(gamma), Embedded::Srgb) => !is_about(*gamma, SRGB_GAMMA),
            (Self::Gamma(gamma), Embedded::Gamma(other)) => !is_about(*gamma, other),
            (Self::Gamma(gamma), Embedded::Linear) => !is_about(*gamma, 1.0),
            // Profiles with a table are mostly sRGB's.
            (Self::Srgb | Self::Gamma(_), Embedded::Curve) => false,
            _ => true,
        }
    }
}

impl Response {
    /// Reads the curve in `path`: a first line `value,radiance` or `value,R,G,B`, then a line for each code that was measured, 0 to 255 or
    /// 65535 as in the image; both columns rise.
    ///
    /// # Errors
    /// [`Error::Read`] with the path and line.
    pub fn read(path: &Path) -> Result<Self> {
        let failed = |reason: String| Error::Read { path: path.to_path_buf(), reason };
        let text = std::fs::read_to_string(path).map_err(|e| failed(e.to_string()))?;
        let (values, radiances) = parse(&text).map_err(failed)?;
        Ok(Self { path: path.to_path_buf(), values, radiances })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn at(&self, code: f64, channel: usize) -> Option<f64> {
        let curve = &self.radiances[channel.min(self.radiances.len() - 1)];
        let above = self.values.partition_point(|&value| value < code);
        let (value, radiance) = (*self.values.get(above)?, curve[above]);
        if value == code {
            return Some(radiance);
        }
        let below = above.checked_sub(1)?;
        let share = (code - self.values[below]) / (value - self.values[below]);
        Some(curve[below] + share * (radiance - curve[below]))
    }
}

/// Codes and curves.
type Table = (Vec<f64>, Vec<Vec<f64>>);

fn parse(text: &str) -> std::result::Result<Table, String> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let cells = |line: &str| line.split(',').map(|cell| cell.trim().to_string()).collect::<Vec<_>>();
    let header = lines.next().map(|(_, line)| cells(line)).unwrap_or_default();
    let curves = match header.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["value", "radiance"] => 1,
        ["value", "R", "G", "B"] => 3,
        _ => return Err("line 1: must be value,radiance or value,R,G,B".into()),
    };
    let (mut values, mut radiances) = (Vec::new(), vec![Vec::new(); curves]);
    for (i, line) in lines {
        let numbers: Option<Vec<f64>> = cells(line).iter().map(|cell| cell.parse().ok()).collect();
        let numbers = numbers.filter(|n| n.len() == curves + 1 && n.iter().all(|v| v.is_finite()));
        let numbers = numbers.ok_or_else(|| format!("line {}: must be {} numbers", i + 1, curves + 1))?;
        values.push(numbers[0]);
        radiances.iter_mut().zip(&numbers[1..]).for_each(|(curve, v)| curve.push(*v));
        let rises = |column: &Vec<f64>| column.windows(2).last().is_none_or(|pair| pair[0] < pair[1]);
        if !rises(&values) || !radiances.iter().all(rises) {
            return Err(format!("line {}: must be above the line before it in every column", i + 1));
        }
    }
    if values.len() < 2 {
        Err("must have two lines of numbers at least".into())
    } else {
        Ok((values, radiances))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::picture::Format;

    const CODES: Codes = Codes { format: Format::Png, largest: 255, embedded: None };

    fn response(text: &str) -> std::result::Result<Transfer, String> {
        let (values, radiances) = parse(text)?;
        Ok(Transfer::Response(Response { path: "response.csv".into(), values, radiances }))
    }

    #[test]
    fn curves_are_undone_exactly() {
        let of = |transfer: Transfer, code: u32| transfer.of_code(code, 0, &CODES).unwrap();
        assert_eq!(of(Transfer::Linear, 51), 0.2);
        assert_eq!(of(Transfer::Gamma(2.0), 51), 0.2 * 0.2);
        assert!((of(Transfer::Srgb, 128) - 0.215_860_5).abs() < 1e-6);
        assert_eq!(of(Transfer::Srgb, 255), 1.0);
    }

    #[test]
    fn a_measured_curve_is_met_at_its_points_and_straight_between_them() {
        let curve = response("value,R,G,B\n0,0,0,0\n100,1,2,3\n200,5,6,7\n").unwrap();
        let at = |code, channel| curve.of_code(code, channel, &CODES);
        assert_eq!([at(100, 0), at(100, 1), at(150, 2), at(200, 0)], [1.0, 2.0, 5.0, 5.0].map(Some));
        assert_eq!(at(201, 0), None);
        let one = response("value, radiance\n10,0.5\n20,0.75\n").unwrap();
        assert_eq!([one.of_code(15, 2, &CODES), one.of_code(9, 2, &CODES)], [Some(0.625), None]);
    }

    #[test]
    fn curves_that_are_none_are_refused_by_line() {
        let reason = |text| response(text).unwrap_err();
        assert_eq!(reason("0,0\n1,1\n"), "line 1: must be value,radiance or value,R,G,B");
        assert_eq!(reason("value,radiance\n0,0\n1,x\n"), "line 3: must be 2 numbers");
        assert_eq!(
            reason("value,radiance\n0,0\n\n1,0\n"),
            "line 4: must be above the line before it in every column"
        );
        assert_eq!(reason("value,radiance\n0,0\n"), "must have two lines of numbers at least");
        assert_eq!(reason("value,radiance\n0,0\n1,nan\n"), "line 3: must be 2 numbers");
    }

    #[test]
    fn what_a_file_says_is_compared_with_what_is_stated() {
        let (linear, srgb) = (Transfer::Linear, Transfer::Srgb);
        assert!(linear.contradicts(Embedded::Srgb) && linear.contradicts(Embedded::Gamma(2.2)));
        assert!(linear.contradicts(Embedded::Curve) && srgb.contradicts(Embedded::Linear));
        assert!(srgb.contradicts(Embedded::Gamma(1.8)) && Transfer::Gamma(1.8).contradicts(Embedded::Srgb));
        assert!(!linear.contradicts(Embedded::Linear) && !srgb.contradicts(Embedded::Srgb));
        assert!(!srgb.contradicts(Embedded::Gamma(2.2)) && !Transfer::Gamma(2.2).contradicts(Embedded::Srgb));
        assert!(!Transfer::Gamma(2.0).contradicts(Embedded::Gamma(2.05)));
        assert!(!response("value,radiance\n0,0\n1,1\n").unwrap().contradicts(Embedded::Linear));
    }
}
