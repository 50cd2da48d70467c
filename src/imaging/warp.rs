//! Turn, scale, stretch, shear and perspective of an observation on the clear image, about the middle of the view.
//!
//! The clear place p is seen at q = A p / (1 + k·p/h), both from the middle of the view, px, +x to the right and +y down; h is
//! half the view's diagonal, and A = R(rotation) · exp(log scale) · [[1 + stretch, shear], [shear, 1 - stretch]].

use glam::{DMat3, DVec3};

/// A number of a warp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum WarpParameter {
    /// Angle by which the observation is turned from +x towards +y, rad.
    Rotation,
    /// Logarithm of the size of the observation over that of the clear image.
    LogScale,
    /// Larger along x by this share, smaller along y.
    Stretch,
    /// The same along the diagonals.
    Shear,
    /// Share by which the right edge of a square view is seen smaller, times √2.
    KeystoneX,
    /// The same of its lower edge.
    KeystoneY,
}

impl WarpParameter {
    /// All of them: two of a similarity, four of an affinity, six of a homography.
    pub const ALL: [Self; 6] =
        [Self::Rotation, Self::LogScale, Self::Stretch, Self::Shear, Self::KeystoneX, Self::KeystoneY];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rotation => "rotation",
            Self::LogScale => "log_scale",
            Self::Stretch => "stretch",
            Self::Shear => "shear",
            Self::KeystoneX => "keystone_x",
            Self::KeystoneY => "keystone_y",
        }
    }
}

/// The numbers of a warp.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Warp([f64; 6]);

impl Warp {
    /// The value of `parameter`.
    pub fn get(&self, parameter: WarpParameter) -> f64 {
        self.0[parameter as usize]
    }

    /// The same with another value.
    #[must_use]
    pub fn with(mut self, parameter: WarpParameter, value: f64) -> Self {
        self.0[parameter as usize] = value;
        self
    }

    /// The matrix that takes homogeneous clear places to observed ones.
    fn matrix(&self, half_px: f64) -> DMat3 {
        let scale = self.get(WarpParameter::LogScale).exp();
        self.turned(DMat3::from_angle(self.get(WarpParameter::Rotation)) * scale * self.strain(), half_px)
    }

    /// Stretch and shear.
    fn strain(&self) -> DMat3 {
        let (a, h) = (self.get(WarpParameter::Stretch), self.get(WarpParameter::Shear));
        columns([1.0 + a, h, 0.0], [h, 1.0 - a, 0.0], [0.0, 0.0, 1.0])
    }

    /// `linear` in its upper left, with the perspective below.
    fn turned(&self, linear: DMat3, half_px: f64) -> DMat3 {
        let [x, y] = [WarpParameter::KeystoneX, WarpParameter::KeystoneY].map(|k| self.get(k) / half_px);
        let mut matrix = linear;
        matrix.z_axis = DVec3::Z;
        (matrix.x_axis.z, matrix.y_axis.z) = (x, y);
        matrix
    }

    /// The change of that matrix with `parameter`.
    fn change(&self, parameter: WarpParameter, half_px: f64) -> DMat3 {
        let angle = self.get(WarpParameter::Rotation);
        let (turn, scale) = (DMat3::from_angle(angle), self.get(WarpParameter::LogScale).exp());
        let mut change = match parameter {
            WarpParameter::Rotation => {
                let (sin, cos) = angle.sin_cos();
                columns([-sin, cos, 0.0], [-cos, -sin, 0.0], [0.0; 3]) * scale * self.strain()
            }
            WarpParameter::LogScale => turn * scale * self.strain(),
            WarpParameter::Stretch => turn * scale * columns([1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0; 3]),
            WarpParameter::Shear => turn * scale * columns([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]),
            WarpParameter::KeystoneX => columns([0.0, 0.0, 1.0 / half_px], [0.0; 3], [0.0; 3]),
            WarpParameter::KeystoneY => columns([0.0; 3], [0.0, 0.0, 1.0 / half_px], [0.0; 3]),
        };
        change.z_axis = DVec3::ZERO;
        change
    }

    /// Ready for places in a view of this half diagonal, px; `None` if it folds the view.
    pub fn bend(&self, half_px: f64) -> Option<Bend> {
        let matrix = self.matrix(half_px);
        let back = matrix.inverse();
        let finite = back.to_cols_array().iter().all(|v| v.is_finite());
        // The view must lie on one side of the horizon.
        let far = (self.get(WarpParameter::KeystoneX)).hypot(self.get(WarpParameter::KeystoneY));
        (finite && matrix.determinant() > 0.0 && far < 0.5).then(|| Bend {
            forth: matrix,
            back,
            changes: WarpParameter::ALL.map(|parameter| self.change(parameter, half_px)),
        })
    }
}

fn columns(x: [f64; 3], y: [f64; 3], z: [f64; 3]) -> DMat3 {
    DMat3::from_cols_array_2d(&[x, y, z])
}

/// A warp of one view.
#[derive(Debug, Clone, Copy)]
pub struct Bend {
    forth: DMat3,
    back: DMat3,
    changes: [DMat3; 6],
}

impl Bend {
    /// Where the clear place `p` is seen, both from the middle of the view, px.
    pub fn seen_at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        plane(self.forth * DVec3::new(x, y, 1.0))
    }

    /// The clear place that is seen at `q`, both from the middle of the view, px.
    pub fn clear_place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        plane(self.back * DVec3::new(x, y, 1.0))
    }

    /// Its change with `parameter`.
    pub fn change(&self, [x, y]: [f64; 2], parameter: WarpParameter) -> [f64; 2] {
        let place = self.back * DVec3::new(x, y, 1.0);
        let moved = -(self.back * (self.changes[parameter as usize] * place));
        let [u, v] = plane(place);
        [(moved.x - u * moved.z) / place.z, (moved.y - v * moved.z) / place.z]
    }
}

fn plane(v: DVec3) -> [f64; 2] {
    [v.x / v.z, v.y / v.z]
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF_PX: f64 = 50.0;
    const PLACE: [f64; 2] = [31.0, -12.0];

    fn some() -> Warp {
        let values = [0.03, -0.02, 0.01, 0.005, 0.02, -0.03];
        WarpParameter::ALL.into_iter().zip(values).fold(Warp::default(), |warp, (p, v)| warp.with(p, v))
    }

    #[test]
    fn what_is_turned_by_a_quarter_goes_from_the_right_to_below() {
        let quarter = Warp::default().with(WarpParameter::Rotation, std::f64::consts::FRAC_PI_2);
        let [x, y] = quarter.bend(HALF_PX).unwrap().seen_at([10.0, 0.0]);
        assert!(x.abs() < 1e-12 && (y - 10.0).abs() < 1e-12, "{x}, {y}");
        let twice = Warp::default().with(WarpParameter::LogScale, 2f64.ln()).bend(HALF_PX).unwrap();
        assert!((twice.seen_at([3.0, 4.0])[1] - 8.0).abs() < 1e-12);
    }

    #[test]
    fn there_and_back_is_the_same_place() {
        let bend = some().bend(HALF_PX).unwrap();
        let [x, y] = bend.clear_place(bend.seen_at(PLACE));
        assert!((x - PLACE[0]).abs() < 1e-10 && (y - PLACE[1]).abs() < 1e-10);
        let [x, y] = bend.seen_at(PLACE);
        assert!((x - PLACE[0]).abs() > 0.1 && (y - PLACE[1]).abs() > 0.1, "it moves nothing");
        assert!(Warp::default().with(WarpParameter::KeystoneX, 0.9).bend(HALF_PX).is_none());
    }

    #[test]
    fn changes_are_derivatives() {
        let step = 1e-6;
        for parameter in WarpParameter::ALL {
            let at = |side: f64| {
                let warp = some().with(parameter, some().get(parameter) + side * step);
                warp.bend(HALF_PX).unwrap().clear_place(PLACE)
            };
            let (there, here) = (at(1.0), at(-1.0));
            let change = some().bend(HALF_PX).unwrap().change(PLACE, parameter);
            for axis in 0..2 {
                let expected = (there[axis] - here[axis]) / (2.0 * step);
                assert!((change[axis] - expected).abs() < 1e-6, "{parameter:?}: {change:?}, {expected}");
            }
            assert!(change.iter().any(|c| c.abs() > 1.0), "{parameter:?} moves nothing");
        }
    }
}
