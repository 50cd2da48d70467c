//! What `[observation]` says of its camera: registration, blur, gain field.

use super::format::ObservationSection;
use super::source::Source;
use super::value::BlurValue;
use crate::error::Result;
use crate::imaging::{Blur, Choice, GainField, Registration};

/// Widest blur that is believed, px.
const WIDEST_PX: f64 = 10.0;

/// What is stated of a camera, or left to the fit.
pub(super) struct Camera {
    pub registration: Choice<Registration>,
    pub blur: Choice<Blur>,
    pub gain_field: Choice<GainField>,
}

/// Reads the keys of `section`. Where nothing is said of the registration, it is left to the fit.
pub(super) fn read_camera(source: &Source, section: &ObservationSection) -> Result<Camera> {
    let registration = named(
        source,
        "registration",
        section.registration.as_deref(),
        &Registration::ALL,
        Registration::name,
    )?;
    let gain_field =
        named(source, "gain_field", section.gain_field.as_deref(), &GainField::ALL, GainField::name)?;
    let blur = match section.blur_px {
        None => Choice::Is(Blur::default()),
        Some(BlurValue::Auto) => Choice::Auto,
        Some(BlurValue::Free) => Choice::Is(Blur::Free),
        Some(BlurValue::Number(px)) => {
            let ok = (0.0..=WIDEST_PX).contains(&px);
            Choice::Is(Blur::Fixed(source.in_range(
                "[observation] blur_px",
                px,
                ok,
                "at least 0 and at most 10 px",
            )?))
        }
    };
    Ok(Camera {
        registration: registration.unwrap_or(Choice::Auto),
        blur,
        gain_field: gain_field.unwrap_or(Choice::Is(GainField::None)),
    })
}

/// The one of `all` that `key` names, if it is given.
fn named<T: Copy>(
    source: &Source,
    key: &str,
    stated: Option<&str>,
    all: &[T],
    name: impl Fn(T) -> &'static str,
) -> Result<Option<Choice<T>>> {
    match stated {
        None => Ok(None),
        Some("auto") => Ok(Some(Choice::Auto)),
        Some(stated) => match all.iter().find(|one| name(**one) == stated) {
            Some(one) => Ok(Some(Choice::Is(*one))),
            None => {
                let known: Vec<&str> = all.iter().map(|one| name(*one)).collect();
                Err(source.error(format!(
                    "[observation] {key} = \"{stated}\": known are {}, auto",
                    known.join(", ")
                )))
            }
        },
    }
}
