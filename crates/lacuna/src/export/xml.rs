//! Numbers and names in XML, and angles of a rotation.

use nalgebra::{Matrix3, Vector3};

/// Numbers with all the digits that bring them back, separated by spaces.
pub(super) fn numbers<'a>(values: impl IntoIterator<Item = &'a f64>) -> String {
    // Adding 0 turns -0 into 0, which looks odd in a file.
    values.into_iter().map(|x| format!("{:?}", x + 0.0)).collect::<Vec<_>>().join(" ")
}

/// Text for an attribute.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Text for a comment, in which XML forbids two hyphens.
pub(super) fn in_comment(text: &str) -> String {
    text.replace("--", "- -")
}

/// Roll, pitch and yaw of `Rz(yaw) Ry(pitch) Rx(roll)` \[rad\].
pub(super) fn roll_pitch_yaw(r: &Matrix3<f64>) -> Vector3<f64> {
    let yaw = libm::atan2(r[(1, 0)], r[(0, 0)]);
    let (sin, cos) = (libm::sin(yaw), libm::cos(yaw));
    let pitch = libm::atan2(-r[(2, 0)], cos * r[(0, 0)] + sin * r[(1, 0)]);
    // From the rotation with the yaw taken off, so that it fits the yaw even where pitch is a right angle and
    // yaw is arbitrary.
    let roll = libm::atan2(sin * r[(0, 2)] - cos * r[(1, 2)], cos * r[(1, 1)] - sin * r[(0, 1)]);
    Vector3::new(roll, pitch, yaw)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    fn rotation(rpy: &Vector3<f64>) -> Matrix3<f64> {
        nalgebra::Rotation3::from_euler_angles(rpy.x, rpy.y, rpy.z).into_inner()
    }

    #[test]
    fn angles_give_the_rotation_back_also_where_they_are_not_unique() {
        let mut stream = Stream::new(11, 0);
        let right = std::f64::consts::FRAC_PI_2;
        for pitch in [0.0, right, -right, right - 1e-9, -right + 1e-13, 0.3, -1.2] {
            for _ in 0..200 {
                let angle = stream.between(-3.2, 3.2);
                let r = rotation(&Vector3::new(angle, pitch, stream.between(-3.2, 3.2)));
                let back = rotation(&roll_pitch_yaw(&r));
                assert!((r - back).norm() < 1e-14, "pitch {pitch}: {}", (r - back).norm());
            }
        }
        let r = rotation(&Vector3::new(right, 0.0, 0.0));
        assert!((roll_pitch_yaw(&r).x - right).abs() < 1e-15);
    }

    #[test]
    fn numbers_come_back_and_text_is_safe() {
        let values = [0.1, -0.0, 1e-9, 123456.789, 1.0 / 3.0];
        let written = numbers(&values);
        assert_eq!(written, "0.1 0.0 1e-9 123456.789 0.3333333333333333");
        assert_eq!(escaped("a<\"b\">&"), "a&lt;&quot;b&quot;&gt;&amp;");
        assert_eq!(in_comment("a--b"), "a- -b");
    }
}
