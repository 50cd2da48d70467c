//! `[observation]`: which part of the object is seen, and the image of it.

use super::format::{NumberOrFree, ObservationSection, VeilValue};
use super::images::{Frame, as_the_object, check_pixels, check_size, pick};
use super::source::{LARGEST, Source};
use super::variance;
use super::{Gain, HIDDEN_SHARE_MAX, Noise, Observation, Registration, Scene, Veil};
use crate::error::{Error, Result};
use crate::image::{Channel, Image, View};
use crate::io::exr::{self, ExrFile};
use std::path::{Path, PathBuf};

/// The part of the object image, `object` (width, height) px large, that is observed: its size is that of the observed
/// image.
pub(super) fn observed_view(
    source: &Source,
    section: Option<&ObservationSection>,
    object: (usize, usize),
) -> Result<View> {
    let Some(section) = section else { return Ok(View::whole(object.0, object.1)) };
    let Some(image) = &section.image else { return planned_view(source, Some(section), object) };
    let path = source.resolve(image);
    let size = seen_size(&path, object)?;
    if let Some([w, h]) = section.size_px.filter(|&[w, h]| (w, h) != size) {
        let found = format!("{} is {}x{} px", path.display(), size.0, size.1);
        return Err(source.error(format!("[observation] size_px = [{w}, {h}], but {found}")));
    }
    placed(source, section, object, size)
}

/// The part of the object image to render or trace: as large as `size_px`, or else as the observed image if there is one;
/// without either all of the object.
pub(super) fn planned_view(
    source: &Source,
    section: Option<&ObservationSection>,
    object: (usize, usize),
) -> Result<View> {
    let Some(section) = section else { return Ok(View::whole(object.0, object.1)) };
    let seen = section.image.as_ref().map(|image| source.resolve(image)).filter(|path| path.exists());
    let size = match (section.size_px, seen) {
        (Some([w, h]), _) => (w, h),
        (None, Some(path)) => seen_size(&path, object)?,
        (None, None) => object,
    };
    placed(source, section, object, size)
}

/// The view of this `size` where `[observation] offset_px` has it, or else in the middle.
fn placed(
    source: &Source,
    section: &ObservationSection,
    object: (usize, usize),
    size: (usize, usize),
) -> Result<View> {
    if size.0 == 0 || size.1 == 0 || size.0 > object.0 || size.1 > object.1 {
        return Err(source.error(format!(
            "[observation] size_px = [{}, {}]: must be at least 1 and at most the object image's {}x{} px",
            size.0, size.1, object.0, object.1
        )));
    }
    let view = match section.offset_px {
        Some([x, y]) => View { x, y, width: size.0, height: size.1 },
        None => View::centred(object, size),
    };
    if !view.fits(object.0, object.1) {
        return Err(source.error(format!(
            "[observation] offset_px = [{}, {}]: the view of {}x{} px does not fit there into the object image of \
             {}x{} px",
            view.x, view.y, size.0, size.1, object.0, object.1
        )));
    }
    Ok(view)
}

/// Size of the observed image, which must not be larger than the object.
fn seen_size(path: &Path, object: (usize, usize)) -> Result<(usize, usize)> {
    let size = exr::size(path)?;
    if size.0 > object.0 || size.1 > object.1 {
        return Err(Error::WrongSize {
            path: path.into(),
            found: format!("{}x{}", size.0, size.1),
            expected: format!("at most the object image's {}x{} px can be seen", object.0, object.1),
        });
    }
    Ok(size)
}

/// Reads and checks all that a fit needs of the observation of `scene`. `observed` is what reading
/// its image gave, `None` if it names none.
pub(super) fn read_observation(
    source: &Source,
    section: Option<&ObservationSection>,
    observed: Option<Result<ExrFile>>,
    scene: &Scene,
) -> Result<Observation> {
    let section = section.ok_or_else(|| source.error("section [observation] is missing: a fit needs one"))?;
    let (Some(named), Some(observed)) = (&section.image, observed) else {
        return Err(source.error("[observation] image is missing: a fit needs it"));
    };
    let path = source.resolve(named);
    let names: Vec<&str> = scene.object.iter().map(|c| c.name.as_str()).collect();
    let frame = Frame { path: &path, size: (scene.view.width, scene.view.height) };

    let pick = pick(source, "[observation]", &section.layer_name, &section.channels)?;
    let mut image = observed?.picked(&names, &pick).map_err(|e| e.since(|| as_the_object(&names)))?;
    for channel in &image {
        check_size(&path, &channel.image, frame.size, "the view")?;
    }
    let mask = section.mask.as_ref().map(|m| read_mask(&source.resolve(m), &frame)).transpose()?;
    if let Some(mask) = &mask {
        image.iter_mut().for_each(|channel| blank(channel, mask));
    }
    for channel in &image {
        let allowed = "finite where the mask does not exclude it, and at most 1e15; scale all images alike";
        check_pixels(&path, channel, allowed, |v| v.abs() <= LARGEST as f32)?;
    }
    for channel in &image {
        let counted = |i: &usize| mask.as_ref().is_none_or(|m| m.data[*i] > 0.0);
        if (0..channel.image.data.len()).filter(counted).all(|i| channel.image.data[i] == 0.0) {
            let what = format!("{}: channel {} is black wherever it counts", path.display(), channel.name);
            return Err(Error::NothingToFit(what));
        }
    }
    let noise = match (section.noise, &section.variance) {
        (Some(_), Some(_)) => {
            return Err(
                source.error("[observation] noise and variance: the noise is given twice; leave one out")
            );
        }
        (Some(v), None) => Some(Noise::Level(source.positive("[observation] noise", v)?)),
        (None, Some(file)) => {
            Some(Noise::Variance(variance::read(&source.resolve(file), &names, &frame, mask.as_ref())?))
        }
        (None, None) => None,
    };
    let gain = match section.gain {
        NumberOrFree::Number(v) => Gain::Fixed(source.positive("[observation] gain", v)?),
        NumberOrFree::Free => Gain::Free,
    };
    let gain_error = source.relative_error("[observation] gain_error", section.gain_error)?;
    let veil = match &section.veil {
        VeilValue::Number(v) => Veil::Fixed(source.finite("[observation] veil", *v)?),
        VeilValue::Free => Veil::Free,
        VeilValue::File(file) => Veil::Image(read_veil(source.resolve(file), &names, &frame, mask.as_ref())?),
    };
    let share = section.hidden_share_max.unwrap_or(HIDDEN_SHARE_MAX);
    let ok = share > 0.0 && share <= 1.0;
    let key = "[observation] hidden_share_max";
    let hidden_share_max = source.in_range(key, share, ok, "above 0 and at most 1")?;
    let registration = read_registration(source, section.registration.as_deref())?;
    Ok(Observation { path, image, noise, mask, gain, gain_error, veil, hidden_share_max, registration })
}

fn read_registration(source: &Source, name: Option<&str>) -> Result<Registration> {
    match name {
        None | Some("none") => Ok(Registration::None),
        Some("shift") => Ok(Registration::Shift),
        Some(other) => {
            let known = "none, shift";
            Err(source.error(format!(
                "[observation] registration: unknown registration {other}; known are {known}"
            )))
        }
    }
}

fn read_mask(path: &Path, observed: &Frame) -> Result<Image> {
    let mask = ExrFile::read(path)?.single()?.image;
    observed.check(path, &mask, "the observed image")?;
    if mask.data.iter().any(|&v| v > 0.0) {
        Ok(mask)
    } else {
        Err(Error::NothingToFit(format!("{}: the mask excludes every pixel", path.display())))
    }
}

fn read_veil(path: PathBuf, names: &[&str], observed: &Frame, mask: Option<&Image>) -> Result<Vec<Channel>> {
    let file = ExrFile::read(&path)?;
    let mut veil = file.channels(names).map_err(|e| e.since(|| as_the_object(names)))?;
    for channel in &mut veil {
        observed.check(&path, &channel.image, "the observed image")?;
        if let Some(mask) = mask {
            blank(channel, mask);
        }
        check_pixels(&path, channel, "finite and at most 1e15", |v| v.abs() <= LARGEST as f32)?;
    }
    Ok(veil)
}

/// Sets excluded pixels that are not finite to 0, so that they do not affect sums in which their weight is 0.
fn blank(channel: &mut Channel, mask: &Image) {
    for (value, &counts) in channel.image.data.iter_mut().zip(&mask.data) {
        let counted = counts > 0.0;
        if !counted && !value.is_finite() {
            *value = 0.0;
        }
    }
}
