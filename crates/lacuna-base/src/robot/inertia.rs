//! Inertial parameters of one rigid body, in the one order and frame that the whole crate uses.

use nalgebra::{Matrix3, Matrix4, Vector3};

use super::{PARAMETERS_PER_LINK, Pose};

/// Symbols of the ten parameters, in order; the link's number follows (`Jxy2`, `mx3`).
pub const PARAMETER_NAMES: [&str; PARAMETERS_PER_LINK] =
    ["m", "mx", "my", "mz", "Jxx", "Jxy", "Jxz", "Jyy", "Jyz", "Jzz"];

/// Units of the ten parameters.
pub const PARAMETER_UNITS: [&str; PARAMETERS_PER_LINK] =
    ["kg", "kg m", "kg m", "kg m", "kg m^2", "kg m^2", "kg m^2", "kg m^2", "kg m^2", "kg m^2"];

/// `(m, mx, my, mz, Jxx, Jxy, Jxz, Jyy, Jyz, Jzz)`: mass \[kg\], first moment `m c` [kg m] and inertia
/// tensor **about the link-frame origin** [kg m²], all in link-frame axes.
///
/// `J` holds tensor elements, so `Jxy = Ixy - m cx cy` and `Jxx = Ixx + m (cy² + cz²)` with `I` about
/// the centre of mass (Gaz et al. 2019, eq. 2-4; in eq. 26 of the print the `xx` line reads `cx² + cz²`,
/// a misprint).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InertialParameters(pub [f64; PARAMETERS_PER_LINK]);

impl InertialParameters {
    /// Nothing there.
    pub const ZERO: Self = Self([0.0; PARAMETERS_PER_LINK]);

    /// From mass, centre of mass and inertia about the centre of mass.
    pub fn from_barycentric(mass: f64, com: Vector3<f64>, inertia: Matrix3<f64>) -> Self {
        let j = inertia + mass * (Matrix3::identity() * com.norm_squared() - com * com.transpose());
        let mc = mass * com;
        Self([mass, mc.x, mc.y, mc.z, j[(0, 0)], j[(0, 1)], j[(0, 2)], j[(1, 1)], j[(1, 2)], j[(2, 2)]])
    }

    /// The ten numbers.
    pub fn as_slice(&self) -> &[f64] {
        &self.0
    }

    /// Mass \[kg\].
    pub fn mass(&self) -> f64 {
        self.0[0]
    }

    /// First moment `m c` [kg m].
    pub fn first_moment(&self) -> Vector3<f64> {
        Vector3::new(self.0[1], self.0[2], self.0[3])
    }

    /// Inertia tensor about the link-frame origin [kg m²].
    pub fn inertia_at_origin(&self) -> Matrix3<f64> {
        let [_, _, _, _, xx, xy, xz, yy, yz, zz] = self.0;
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// Centre of mass \[m\]; `None` below 1e-6 kg, where it has no meaning.
    pub fn center_of_mass(&self) -> Option<Vector3<f64>> {
        (self.mass() >= 1e-6).then(|| self.first_moment() / self.mass())
    }

    /// Inertia tensor about the centre of mass [kg m²]; `None` below 1e-6 kg.
    pub fn inertia_at_center_of_mass(&self) -> Option<Matrix3<f64>> {
        let c = self.center_of_mass()?;
        let steiner = Matrix3::identity() * c.norm_squared() - c * c.transpose();
        Some(self.inertia_at_origin() - self.mass() * steiner)
    }

    /// Pseudo-inertia `[[tr(J)/2 1 - J, m c], [(m c)ᵀ, m]]`: positive semidefinite exactly when the body
    /// can exist (Wensing, Kim and Slotine 2018).
    pub fn pseudo_inertia(&self) -> Matrix4<f64> {
        let j = self.inertia_at_origin();
        let second_moment = Matrix3::identity() * (0.5 * j.trace()) - j;
        let mut p = Matrix4::zeros();
        p.fixed_view_mut::<3, 3>(0, 0).copy_from(&second_moment);
        p.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.first_moment());
        p.fixed_view_mut::<1, 3>(3, 0).copy_from(&self.first_moment().transpose());
        p[(3, 3)] = self.mass();
        p
    }

    fn from_pseudo_inertia(p: &Matrix4<f64>) -> Self {
        let s: Matrix3<f64> = p.fixed_view::<3, 3>(0, 0).into_owned();
        let j = Matrix3::identity() * s.trace() - s;
        Self([
            p[(3, 3)],
            p[(0, 3)],
            p[(1, 3)],
            p[(2, 3)],
            j[(0, 0)],
            j[(0, 1)],
            j[(0, 2)],
            j[(1, 1)],
            j[(1, 2)],
            j[(2, 2)],
        ])
    }

    /// The same body described in another frame: `pose` is this frame's pose in the new one.
    #[must_use]
    pub fn moved(&self, pose: &Pose) -> Self {
        // The pseudo-inertia is a sum over points of (x, 1)(x, 1)ᵀ dm, so it moves like the points do.
        let t = pose.rotation.to_homogeneous().append_translation(&pose.translation);
        Self::from_pseudo_inertia(&(t * self.pseudo_inertia() * t.transpose()))
    }

    /// Both bodies together.
    #[must_use]
    pub fn combined(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}
