//! Random poses within the joint limits, for static read-outs.

use std::f64::consts::PI;

use crate::error::{Error, Result};
use crate::random::Stream;
use crate::robot::{Joint, JointKind, Robot};

/// The positions a joint may take `(lower, upper)` [rad, m].
///
/// A revolute joint without limits (URDF `continuous`) turns through -pi..pi.
///
/// # Errors
/// When a prismatic joint has no limits, when only one of two is known, or when they are out of order.
pub fn position_range(joint: &Joint) -> Result<(f64, f64)> {
    let remedy = "give `lower` and `upper` limits in the robot file";
    match (joint.limits.lower, joint.limits.upper) {
        (Some(lower), Some(upper)) if lower < upper && (upper - lower).is_finite() => Ok((lower, upper)),
        (None, None) if joint.kind == JointKind::Revolute => Ok((-PI, PI)),
        (Some(lower), Some(upper)) => {
            let what = format!("joint `{}` may move from {lower} to {upper}, which is no range", joint.name);
            Err(Error::new(what).help("the lower limit must lie below the upper one"))
        }
        _ => Err(Error::new(format!("the range of joint `{}` is not known", joint.name)).help(remedy)),
    }
}

/// `count` configurations drawn uniformly within the joint limits: `q[joint][pose]` [rad, m].
///
/// Every joint has its own random stream, so more poses of the same seed begin with the same poses.
///
/// # Errors
/// When a joint has no [`position_range`].
pub fn random_configurations(robot: &Robot, count: usize, seed: u64) -> Result<Vec<Vec<f64>>> {
    let draw = |(j, joint): (usize, &Joint)| {
        let (lower, upper) = position_range(joint)?;
        let mut stream = Stream::new(seed, j);
        Ok((0..count).map(|_| stream.between(lower, upper)).collect())
    };
    robot.joints.iter().enumerate().map(draw).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Limits;
    use crate::robot::samples;

    #[test]
    fn poses_fill_the_limits_evenly_and_repeat() -> Result<()> {
        let mut robot = samples::two_link();
        robot.joints[1].limits = Limits { lower: Some(-0.5), upper: Some(2.0), ..Limits::default() };
        let q = random_configurations(&robot, 4000, 11)?;
        assert_eq!((q.len(), q[0].len()), (2, 4000));
        assert_eq!(q, random_configurations(&robot, 4000, 11)?);
        assert_eq!(q[1][..10], random_configurations(&robot, 10, 11)?[1]);
        for (values, lower, upper) in [(&q[0], -PI, PI), (&q[1], -0.5, 2.0)] {
            assert!(values.iter().all(|x| (lower..upper).contains(x)));
            // Uniform: mean at the middle, variance a twelfth of the squared width (four sigma).
            let mean = values.iter().sum::<f64>() / 4000.0;
            let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 4000.0;
            let width = upper - lower;
            assert!((mean - 0.5 * (lower + upper)).abs() < 4.0 * width / (12.0 * 4000.0_f64).sqrt());
            assert!((variance / (width * width / 12.0) - 1.0).abs() < 0.06);
        }
        Ok(())
    }

    #[test]
    fn a_slider_without_limits_is_refused_by_name() {
        let mut robot = samples::cart_pole();
        robot.joints[0].limits = Limits::default();
        let error = random_configurations(&robot, 3, 0).expect_err("no limits");
        assert!(error.message().contains("`slider`"), "{error}");
    }
}
