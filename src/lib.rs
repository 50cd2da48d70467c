//! Estimates a scattering medium from one blurred image: scattering coefficient sigma_s, absorption coefficient
//! sigma_a and the width B of a Gaussian phase function, or g of Henyey and Greenstein's, given the clear object image and its
//! depth.
//!
//! # Image formation
//!
//! ```text
//! observed(x) = gain · [ T(z_x) L(x) + sum_j w_j(x - j) L(j) ] + veil
//!
//! T(z)   = exp(-sigma_t z)                                direct light
//! w_j(u) = psf of path length z_j, integrated over object pixel j and averaged over observed pixel j + u
//! M(k)   = T + 2 pi ∫ psf(r) J0(k r) r dr                 transfer function of the kernel
//!        = exp(-sigma_t z + sigma_s z F(k z))             for the model `small-angle`
//! F(q)   = sqrt(pi) erf(x) / (2 x),  x = sqrt(B) q
//! ```
//!
//! This is eq. 29 of M. Shinya, Y. Dobashi, M. Shiraishi, T. Nishita, *Rendering Objects in Random Scattering Media
//! with the Narrow Beam Theory*, with the kernel as a choice ([`spread`]). The medium is homogeneous and
//! index-matched (no refraction at its surface).
//!
//! | symbol | in code | meaning | unit |
//! | --- | --- | --- | --- |
//! | L | `radiance` | clear object image, linear radiance | any |
//! | sigma_s, sigma_a | `sigma_s`, `sigma_a` | scattering, absorption coefficient | 1/length |
//! | sigma_t | `sigma_t` | extinction sigma_s + sigma_a | 1/length |
//! | B | `b` | width of the phase function exp(-theta²/(4B)) | rad² |
//! | g | `g` | mean cosine of the phase function | 1 |
//! | sqrt(4B) | `spread_angle` | rms of a single deflection for small B | rad |
//! | z | `path_length` | path in the medium along the line of sight: depth - surface | length |
//! | tau | `tau` | scattering optical depth sigma_s z | 1 |
//! | T | `transmittance` | fraction of the light that arrives unscattered | 1 |
//! | psf(r) | `psf` | density of the scattered light; integrates to the scattered fraction of all light, not to 1 | 1/area |
//! | M(k) | `mtf` | transfer function, direct light included; M(0) is all light that arrives | 1 |
//! | F | `mean_planar_transform` | mean of the planar phase function's transform over the path | 1 |
//! | k | `k` | spatial frequency in the object plane | rad/length |
//! | gain, veil | `gain`, `veil` | exposure; light scattered in from the illumination, in units of the observation | 1; any |
//!
//! # A whole fit
//!
//! A checkerboard 2 m behind the medium's surface, pixels of 5 cm:
//!
//! ```
//! use narrowbeam::filter::{Optics, Target, cpu::CpuFilter};
//! use narrowbeam::fit::{Observation, Settings, fit_channel};
//! use narrowbeam::geometry::Geometry;
//! use narrowbeam::image::{Border, Image, View};
//! use narrowbeam::medium::Medium;
//! use narrowbeam::scene::FitOptions;
//! use narrowbeam::spread::Model;
//!
//! let object = Image::from_fn(32, 32, |x, y| if (x / 5 + y / 7) % 2 == 0 { 0.9 } else { 0.2 });
//! let geometry = Geometry::planar(32, 32, 0.05, 2.0)?;
//! let view = View::whole(32, 32);
//! let target = Target::plain(&object, &geometry, Border::Mirror, view);
//!
//! // What the camera sees through a medium of sigma_s 0.9 and sigma_a 0.05 per metre, B 0.004 rad².
//! let optics = Optics { model: Model::SmallAngle, medium: Medium::gaussian(0.9, 0.05, 0.004)? };
//! let observed = CpuFilter::new(target, &optics, 1.0)?.render(&optics)?;
//!
//! // Estimate the medium from the two images.
//! let seen = [Observation::plain(target, &observed)];
//! let fit = fit_channel(&seen, &FitOptions::default(), &Settings::default(), &|| ())?;
//! assert!(fit.converged);
//! assert!((fit.parameters["sigma_s"].value() - 0.9).abs() < 1e-3);
//! assert!((fit.parameters["sigma_a"].value() - 0.05).abs() < 1e-3);
//! assert!((fit.parameters["b"].value() - 0.004).abs() < 1e-5);
//! # Ok::<(), narrowbeam::Error>(())
//! ```
//!
//! Scene files are read by [`scene::ObservedScene::read`] and fitted by [`fit::fit_scenes`].
//!
//! # Modules
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`medium`], [`phase`] | coefficients; phase functions |
//! | [`geometry`], [`image`](mod@image) | camera, distances, pixel pitch; linear images, views, borders |
//! | [`imaging`] | what a camera does to the light that reaches it |
//! | [`spread`] | the kernels: `beer-lambert` to `wide-angle` |
//! | [`filter`] | from the clear object to the image through the medium, for any depth map |
//! | [`illumination`], [`synthesis`] | light that falls into the medium and its veil; images with all their light |
//! | [`relief`] | slopes and occluders of a depth map |
//! | [`forward`] | from parameters to images and their inner products, with derivatives |
//! | [`fit`] | estimates, their errors, the report |
//! | [`gpu`] | compute on graphics adapters; contains no optics |
//! | [`trace`] | photon tracer: an independent check, uses neither `spread` nor `filter` nor `fit` |
//! | [`scene`], [`io`] | scene files; images of all formats |
//! | [`error`](mod@error), [`memory`] | every error, naming its cause; the memory budget |
//!
//! What a user needs is documented here. Enums that will grow are `non_exhaustive`. Items that only the tests reach, such as the
//! reference implementations of the filter, are hidden from these pages and may change at any time.
//!
//! # Features
//!
//! All are on by default. Without them the crate computes on the CPU: kernels, filter, tracer, scene files, fits and reports.
//!
//! | feature | what it adds |
//! | --- | --- |
//! | `gpu` | [`gpu`]: renders and fits on a graphics adapter |
//! | `plots` | `plots`: figures as PNG and SVG |
//! | `lab` | `lab`: studies, the paper's experiments, tables of kernels |
//! | `cli` | `cli`, and the program `narrowbeam`, which needs all others |

// Streams belong to the program; tests print what they assert.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

mod chebyshev;
#[cfg(feature = "cli")]
pub mod cli;
pub mod error;
pub mod filter;
pub mod fit;
pub mod forward;
pub mod geometry;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod illumination;
pub mod image;
pub mod imaging;
pub mod io;
#[cfg(feature = "lab")]
pub mod lab;
pub mod medium;
pub mod memory;
pub mod phase;
#[cfg(feature = "plots")]
pub mod plots;
mod quadrature;
pub mod relief;
pub mod scene;
pub mod spread;
pub mod synthesis;
pub mod trace;

pub use error::{Error, Result};

/// The code of the README runs as a doctest.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeDoctests;
