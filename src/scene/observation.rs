//! `[observation]`: which part of the object is seen, and the image of it.

use super::camera::read_camera;
use super::format::{NumberOrFree, ObservationSection};
use super::images::{Frame, as_the_object, check_pixels, check_size, pick};
use super::light::{Light, LightReader};
use super::numbers::shares;
use super::saturation::{ceiling, left_out};
use super::source::{LARGEST, Source};
use super::value::{NoiseValue, VeilValue};
use super::{Caution, CautionCode, Gain, HIDDEN_SHARE_MAX, Loss, Observation, Scene, Veil};
use crate::error::{Error, Result};
use crate::image::{Channel, Image, Sampling, View};
use crate::imaging::VeilField;
use crate::io::picture;
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
    let size = picture::size(path)?;
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
    observed: Option<Result<Light>>,
    scene: &Scene,
) -> Result<Observation> {
    let section = section.ok_or_else(|| source.error("section [observation] is missing: a fit needs one"))?;
    let (Some(named), Some(observed)) = (&section.image, observed) else {
        return Err(source.error("[observation] image is missing: a fit needs it"));
    };
    let path = source.resolve(named);
    let names: Vec<&str> = scene.object.iter().map(|c| c.name.as_str()).collect();
    let frame = Frame { path: &path, size: (scene.view.width, scene.view.height) };

    let Light { file, codes, caution } = observed?;
    let pick = pick(source, "[observation]", &section.layer_name, &section.channels)?;
    let mut image = file.picked(&names, &pick).map_err(|e| e.since(|| as_the_object(&names)))?;
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
    let noise = match (&section.noise, &section.variance) {
        (Some(_), Some(_)) => {
            return Err(
                source.error("[observation] noise and variance: the noise is given twice; leave one out")
            );
        }
        (Some(noise), None) => Some(("[observation] noise", noise.clone())),
        (None, Some(file)) => Some(("[observation] variance", NoiseValue::File(file.clone()))),
        (None, None) => None,
    };
    let noise =
        noise.map(|(key, noise)| noise.read(source, key, &names, (&frame, mask.as_ref()))).transpose()?;
    let gain = match section.gain {
        NumberOrFree::Number(v) => Gain::Fixed(source.positive("[observation] gain", v)?),
        NumberOrFree::Free => Gain::Free,
    };
    let gain_error = source.relative_error("[observation] gain_error", section.gain_error)?;
    let veil = match &section.veil {
        VeilValue::Number(v) => Veil::Fixed(source.finite("[observation] veil", *v)?),
        VeilValue::Free => Veil::Free(VeilField::Constant),
        VeilValue::Field(field) => Veil::Free(*field),
        VeilValue::Auto => Veil::Auto,
        VeilValue::File(file) => {
            let reader = LightReader::new(source, "[observation]", section.transfer.as_ref())?;
            Veil::Image(read_veil(&reader, source.resolve(file), &names, (&frame, mask.as_ref()))?)
        }
    };
    let share = section.hidden_share_max.unwrap_or(HIDDEN_SHARE_MAX);
    let ok = share > 0.0 && share <= 1.0;
    let key = "[observation] hidden_share_max";
    let hidden_share_max = source.in_range(key, share, ok, "above 0 and at most 1")?;
    let camera = read_camera(source, section)?;
    let saturation =
        section.saturation.map(|v| source.positive("[observation] saturation", v)).transpose()?;
    let mut observation = Observation {
        path,
        image,
        noise,
        mask,
        gain,
        gain_error,
        veil,
        hidden_share_max,
        registration: camera.registration,
        blur: camera.blur,
        gain_field: camera.gain_field,
        loss: read_loss(source, section.loss.as_deref())?,
        saturated_pixels: 0,
        cautions: caution.into_iter().collect(),
    };
    observation.leave_out_saturated(saturation.map(|v| v as f32), codes.is_some())?;
    Ok(observation)
}

impl Observation {
    /// Leaves out what reaches `level`, or else the ceiling that each channel shows.
    fn leave_out_saturated(&mut self, level: Option<f32>, are_codes: bool) -> Result<()> {
        let counts = |i: usize| self.mask.as_ref().is_none_or(|mask| mask.data[i] > 0.0);
        let level = |channel: &Channel| level.or_else(|| ceiling(&channel.image, counts, are_codes));
        let levels: Vec<_> = self.image.iter().filter_map(|c| Some((c, level(c)?))).collect();
        let Some(out) = left_out(&levels) else { return Ok(()) };
        self.mask_out(|i| out[i]);
        if self.mask.as_ref().is_some_and(|mask| mask.data.iter().all(|&v| v <= 0.0)) {
            let what = format!("{}: every pixel that counts is saturated", self.path.display());
            return Err(Error::NothingToFit(what));
        }
        Ok(())
    }

    /// Leaves out pixels in which the photograph of the object, `path`, is saturated: what they sent is not known.
    pub(super) fn leave_out_saturated_object(&mut self, scene: &Scene, path: &Path) {
        if scene.sampling == Sampling::Pixel {
            return;
        }
        let level = |channel: &Channel| ceiling(&channel.image, |_| true, true);
        let levels: Vec<_> = scene.object.iter().filter_map(|c| Some((c, level(c)?))).collect();
        let Some(out) = left_out(&levels) else { return };
        let (view, width) = (scene.view, scene.geometry.width);
        let before = self.saturated_pixels;
        self.mask_out(|i| out[(view.y + i / view.width) * width + view.x + i % view.width]);
        let all = out.iter().filter(|out| **out).count();
        let message = format!(
            "{} is saturated: {all} of its pixels have or touch its highest value, {} that counted are left out; what their light adds to others is \
             too small, so expose for a shorter time",
            path.display(),
            self.saturated_pixels - before
        );
        self.cautions.push(Caution { code: CautionCode::Saturation, message });
    }

    /// Excludes the pixels that are `out`, as saturated.
    fn mask_out(&mut self, out: impl Fn(usize) -> bool) {
        let (width, height) = (self.image[0].image.width, self.image[0].image.height);
        let mask = self.mask.get_or_insert_with(|| Image::filled(width, height, 1.0));
        for (i, counts) in mask.data.iter_mut().enumerate() {
            if *counts > 0.0 && out(i) {
                *counts = 0.0;
                self.saturated_pixels += 1;
            }
        }
    }
}

fn read_loss(source: &Source, name: Option<&str>) -> Result<Loss> {
    match name {
        None | Some("gaussian") => Ok(Loss::Gaussian),
        Some("huber") => Ok(Loss::Huber),
        Some(other) => {
            Err(source.error(format!("[observation] loss: unknown loss {other}; known are gaussian, huber")))
        }
    }
}

fn read_mask(path: &Path, observed: &Frame) -> Result<Image> {
    let mask = shares(path)?.image;
    observed.check(path, &mask, "the observed image")?;
    if mask.data.iter().any(|&v| v > 0.0) {
        Ok(mask)
    } else {
        Err(Error::NothingToFit(format!("{}: the mask excludes every pixel", path.display())))
    }
}

fn read_veil(
    reader: &LightReader,
    path: PathBuf,
    names: &[&str],
    (observed, mask): (&Frame, Option<&Image>),
) -> Result<Vec<Channel>> {
    let file = reader.read(&path)?.file;
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
