//! `narrowbeam init`: from two photographs and a distance to a scene file, and to what may be expected of a fit.

mod looks;
mod place;

use super::console::say;
use super::errors::Usage;
use super::options::positive;
use crate::error::Error;
use crate::geometry::Camera;
use crate::io::atomic;
use crate::io::picture::Picture;
use crate::scene::ObservedScene;
use anyhow::Result;
use looks::Looks;
use place::relative;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("size").required(true))]
pub(super) struct Arguments {
    /// Folder in which scene.toml is written; made if it does not exist
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// Photograph of the object through clear water or air
    #[arg(long, value_name = "IMAGE")]
    clear: PathBuf,
    /// Photograph of the same through the medium, from the same place; as large, or smaller: then its centre
    #[arg(long, value_name = "IMAGE")]
    turbid: PathBuf,
    /// Distance that the light of the object goes through the medium, in any unit of length
    #[arg(long, value_name = "Z", value_parser = positive)]
    depth: f64,
    /// Width of what the clear photograph shows, at the object, in the same unit
    #[arg(long, value_name = "W", value_parser = positive, group = "size")]
    view_width: Option<f64>,
    /// Length at the object that one pixel shows, in the same unit
    #[arg(long, value_name = "P", value_parser = positive, group = "size")]
    pixel_pitch: Option<f64>,
    /// Angle that the clear photograph spans horizontally, degrees
    #[arg(long, value_name = "D", value_parser = positive, group = "size")]
    fov: Option<f64>,
    /// How the numbers of both photographs follow from radiance: linear, srgb, a gamma, or the CSV file of a response curve;
    /// needed for PNG, JPEG and integer TIFF files
    #[arg(long, value_name = "T")]
    transfer: Option<String>,
}

/// Name of the file that is written.
const FILE: &str = "scene.toml";

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode> {
    let path = arguments.dir.join(FILE);
    if path.symlink_metadata().is_ok() {
        Err(Usage(format!("{}: is there already; remove it, or take another folder", path.display())))?;
    }
    let is_photograph = [&arguments.clear, &arguments.turbid]
        .map(|image| Ok(Picture::read(image)?.codes.is_some()))
        .into_iter()
        .collect::<crate::Result<Vec<bool>>>()?;
    if is_photograph.contains(&true) && arguments.transfer.is_none() {
        Err(Usage(
            "--transfer is missing: these are photographs, so say how their numbers follow from radiance: srgb (JPEG of a camera), linear \
             (developed from a raw file without a curve), a gamma such as 2.2, or the CSV file of a measured response curve"
                .into(),
        ))?;
    }
    let existed = arguments.dir.is_dir();
    let _folder = atomic::create_dir(&arguments.dir)?;
    let text = text(arguments, &is_photograph)?;
    atomic::write(&path, text.as_bytes())?;
    // Only what a fit can read stays.
    let looked = ObservedScene::read(&path).and_then(|scene| Ok((Looks::at(&scene)?, scene)));
    let (looks, scene) = match looked {
        Ok(looked) => looked,
        Err(error) => {
            atomic::remove(&path)?;
            if !existed {
                // It is ours, and empty; if not, it may stay.
                let _ = std::fs::remove_dir(&arguments.dir);
            }
            return Err(about_options(error).into());
        }
    };
    say(&looks.lines(&scene));
    say(&format!("\n{} is written; now run: narrowbeam fit {}\n", path.display(), path.display()));
    Ok(ExitCode::SUCCESS)
}

/// The same without the name of a scene file that is no longer there.
fn about_options(error: Error) -> Error {
    match error {
        Error::Scene { message, path } if path.ends_with(FILE) => Error::NothingToFit(message),
        other => other,
    }
}

/// The scene file.
fn text(arguments: &Arguments, is_photograph: &[bool]) -> Result<String> {
    let clear = Picture::read(&arguments.clear)?;
    let width = clear.file.all().first().map_or(1, |channel| channel.image.width);
    let camera = match (arguments.view_width, arguments.pixel_pitch, arguments.fov) {
        (Some(view), _, _) => {
            format!("pixel_pitch = {:?}          # length of a pixel at the object", view / width as f64)
        }
        (_, Some(pitch), _) => format!("pixel_pitch = {pitch:?}          # length of a pixel at the object"),
        (_, _, fov) => {
            let fov = fov.unwrap_or_default();
            Camera::perspective(fov).map_err(|e| Usage(format!("--fov: {e}")))?;
            format!("fov_x_deg = {fov:?}          # angle that the clear image spans horizontally")
        }
    };
    let file = |path: &Path| quoted(&relative(&arguments.dir, path).to_string_lossy());
    let transfer = |is_photograph: bool| match &arguments.transfer {
        Some(name) if is_photograph => {
            let value = match name.parse::<f64>() {
                Ok(gamma) => format!("{gamma:?}"),
                Err(_) if name.ends_with(".csv") => file(Path::new(name)),
                Err(_) => quoted(name),
            };
            format!("transfer = {value}          # how numbers follow from radiance\n")
        }
        _ => String::new(),
    };
    Ok(format!(
        "# Written by narrowbeam init. All keys: docs/scene-file.md\n\
         [object]\n\
         radiance = {clear}\n\
         {of_clear}\
         depth = {depth:?}          # length of the light's way through the medium\n\
         # noise = {{ read = 0.001, shot = 0.004 }}   # of the clear image, if it is known\n\
         \n\
         [camera]\n\
         {camera}\n\
         \n\
         [observation]\n\
         image = {turbid}\n\
         {of_turbid}\
         registration = \"auto\"      # the camera may have moved, turned or come nearer\n\
         gain = \"free\"              # exposure over that of the clear image; a number, if it is known, determines sigma_a\n\
         veil = \"auto\"              # light that the medium scatters in, as far as the image asks for it; 0.0 if the water is dark\n\
         blur_px = \"auto\"           # how much less sharp it is than the clear image, the medium aside\n\
         gain_field = \"auto\"        # how its brightness falls off towards the corners, over that of the clear image\n",
        clear = file(&arguments.clear),
        of_clear = transfer(is_photograph[0]),
        depth = arguments.depth,
        turbid = file(&arguments.turbid),
        of_turbid = transfer(is_photograph[1]),
    ))
}

/// `text` as a TOML string.
fn quoted(text: &str) -> String {
    toml::Value::String(text.into()).to_string()
}
