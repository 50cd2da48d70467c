//! Pictures for people: line charts, maps and panels of images, in colours that colour-blind readers can distinguish.
//!
//! The font is compiled in ([DejaVu Sans](https://dejavu-fonts.github.io/), its licence beside it), so that pictures
//! are the same on every machine.

mod canvas;
mod chart_grid;
mod colour_bar;
mod lines;
mod maps;
mod panels;
mod scale;
mod series;
mod signs;

pub use chart_grid::ChartGrid;
pub use lines::{Axis, LineChart};
pub use maps::{Map, MapGrid, MapRow};
pub use panels::{Figure, Panel, Shade};
pub use series::{Mark, Series, Spread};
pub use signs::{Shape, Sign};
