//! Small robots built in code, for tests, examples and benchmarks.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use crate::robot::{InertialParameters, Joint, JointKind, Limits, Link, Pose, Robot};

/// Gravity of every robot here: 9.81 m/s² along -z.
const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// Builds a robot joint by joint; joints come out in the order they were added.
#[derive(Debug, Clone)]
pub struct Builder {
    robot: Robot,
}

impl Builder {
    /// A robot without joints.
    pub fn new(name: &str) -> Self {
        let (joints, links, order) = (vec![], vec![], vec![]);
        let robot = Robot {
            name: name.into(),
            gravity: GRAVITY,
            joints,
            links,
            order,
            frames: vec![],
            remarks: vec![],
        };
        Self { robot }
    }

    /// Adds a joint mounted on link `parent` (`None` is the base) at `before`, moving along or about `axis`
    /// (of any length but zero), and the link it moves.
    #[must_use]
    pub fn joint(
        mut self,
        name: &str,
        kind: JointKind,
        parent: Option<usize>,
        before: Pose,
        axis: Vector3<f64>,
        inertia: InertialParameters,
    ) -> Self {
        let (axis, after) = (axis.normalize(), Pose::identity());
        let limits = Limits::default();
        self.robot.joints.push(Joint { name: name.into(), kind, parent, before, axis, after, limits });
        self.robot.links.push(Link { name: format!("{name}_link"), inertia: Some(inertia) });
        self
    }

    /// Sets the position limits [rad, m] of the joint added last.
    #[must_use]
    pub fn limits(mut self, lower: f64, upper: f64) -> Self {
        if let Some(joint) = self.robot.joints.last_mut() {
            joint.limits = Limits { lower: Some(lower), upper: Some(upper), ..joint.limits };
        }
        self
    }

    /// Moves the frame of the link added last to `after` in the joint frame, as standard Denavit-Hartenberg
    /// does; the link itself stays where it is.
    #[must_use]
    pub fn frame_at(mut self, after: Pose) -> Self {
        if let Some(joint) = self.robot.joints.last_mut() {
            joint.after = after;
        }
        if let Some(link) = self.robot.links.last_mut() {
            link.inertia = link.inertia.map(|inertia| inertia.moved(&after.inverse()));
        }
        self
    }

    /// The robot. Children may stand before their parents, as in some URDF files.
    pub fn build(self) -> Robot {
        let mut robot = self.robot;
        let depth = |i: usize| robot.path_to_base(i).count();
        let mut order: Vec<usize> = (0..robot.dof()).collect();
        order.sort_by_key(|&i| depth(i));
        robot.order = order;
        robot
    }
}

/// A frame shifted by (x, y, z) \[m\].
pub fn shift(x: f64, y: f64, z: f64) -> Pose {
    Pose { rotation: Matrix3::identity(), translation: Vector3::new(x, y, z) }
}

/// A frame turned about `axis` by `angle` \[rad\] and shifted by `translation` \[m\].
pub fn turned(axis: Vector3<f64>, angle: f64, translation: Vector3<f64>) -> Pose {
    let rotation = Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle).into_inner();
    Pose { rotation, translation }
}

fn body(mass: f64, center: Vector3<f64>, inertia: Vector3<f64>) -> InertialParameters {
    InertialParameters::from_barycentric(mass, center, Matrix3::from_diagonal(&inertia))
}

/// A pendulum about -y that hangs along -z at zero: `(inertia + mass length²) ddq + mass g length sin q = tau`.
pub fn pendulum(mass: f64, length: f64, inertia: f64) -> Robot {
    let bob = body(mass, Vector3::new(0.0, 0.0, -length), Vector3::repeat(inertia));
    let axis = -Vector3::y();
    Builder::new("pendulum").joint("pivot", JointKind::Revolute, None, Pose::identity(), axis, bob).build()
}

/// Masses \[kg\], lengths \[m\] and inertias about centres of mass [kg m²] of [`two_link`].
#[derive(Debug, Clone, Copy)]
pub struct TwoLink {
    /// Mass of the first link.
    pub m1: f64,
    /// Mass of the second link.
    pub m2: f64,
    /// Length of the first link.
    pub l1: f64,
    /// From the first joint to the first centre of mass.
    pub c1: f64,
    /// From the second joint to the second centre of mass.
    pub c2: f64,
    /// Inertia of the first link.
    pub i1: f64,
    /// Inertia of the second link.
    pub i2: f64,
}

/// Numbers of [`two_link`].
pub const TWO_LINK: TwoLink = TwoLink { m1: 2.0, m2: 1.2, l1: 0.5, c1: 0.22, c2: 0.17, i1: 0.05, i2: 0.02 };

/// A planar arm in the vertical x-z plane, both axes -y, stretched along x at zero.
pub fn two_link() -> Robot {
    two_link_with(Pose::identity(), Pose::identity())
}

/// [`two_link`] with link frames at the far, twisted ends, as standard Denavit-Hartenberg puts them.
pub fn two_link_far_frames() -> Robot {
    let far = |length: f64, angle| turned(Vector3::x(), angle, Vector3::new(length, 0.0, 0.03));
    two_link_with(far(TWO_LINK.l1, 0.7), far(0.35, -1.1))
}

fn two_link_with(first: Pose, second: Pose) -> Robot {
    let TwoLink { m1, m2, l1, c1, c2, i1, i2 } = TWO_LINK;
    let near = body(m1, Vector3::new(c1, 0.0, 0.0), Vector3::new(0.01, i1, 0.04));
    let far = body(m2, Vector3::new(c2, 0.0, 0.0), Vector3::new(0.01, i2, 0.015));
    let elbow = first.inverse().then(&shift(l1, 0.0, 0.0));
    let axis = -Vector3::y();
    Builder::new("two_link")
        .joint("shoulder", JointKind::Revolute, None, Pose::identity(), axis, near)
        .frame_at(first)
        .joint("elbow", JointKind::Revolute, Some(0), elbow, axis, far)
        .frame_at(second)
        .build()
}

/// Numbers of [`cart_pole`]: masses \[kg\], length \[m\], inertia about the pole's centre of mass [kg m²].
#[derive(Debug, Clone, Copy)]
pub struct CartPole {
    /// Mass of the cart.
    pub cart: f64,
    /// Mass of the pole.
    pub pole: f64,
    /// From the hinge to the pole's centre of mass.
    pub length: f64,
    /// Inertia of the pole.
    pub inertia: f64,
}

/// Numbers of [`cart_pole`].
pub const CART_POLE: CartPole = CartPole { cart: 1.5, pole: 0.6, length: 0.3, inertia: 0.02 };

/// A cart that slides along x with a pole that hangs along -z at zero and turns about -y.
pub fn cart_pole() -> Robot {
    let CartPole { cart, pole, length, inertia } = CART_POLE;
    let trolley = body(cart, Vector3::new(0.1, 0.0, 0.2), Vector3::repeat(0.01));
    let rod = body(pole, Vector3::new(0.0, 0.0, -length), Vector3::repeat(inertia));
    let (base, hinge) = (Pose::identity(), shift(0.0, 0.0, 0.1));
    Builder::new("cart_pole")
        .joint("slider", JointKind::Prismatic, None, base, Vector3::x(), trolley)
        .limits(-1.0, 1.0)
        .joint("hinge", JointKind::Revolute, Some(0), hinge, -Vector3::y(), rod)
        .build()
}

/// A trunk that turns about an upright axis with two arms; one arm stands before the trunk in the order of
/// joints, as a URDF may have it.
pub fn branched() -> Robot {
    let arm = |mass, length| body(mass, Vector3::new(length, 0.02, 0.0), Vector3::new(0.01, 0.02, 0.015));
    let trunk = body(3.0, Vector3::new(0.05, 0.0, 0.3), Vector3::repeat(0.04));
    let side = |y: f64, angle| turned(Vector3::x(), angle, Vector3::new(0.1, y, 0.4));
    let mut robot = Builder::new("branched")
        .joint(
            "left",
            JointKind::Revolute,
            Some(1),
            side(0.2, -0.5),
            Vector3::new(1.0, 2.0, 0.5),
            arm(1.1, 0.2),
        )
        .joint("trunk", JointKind::Revolute, None, Pose::identity(), Vector3::z(), trunk)
        .joint(
            "right",
            JointKind::Revolute,
            Some(1),
            side(-0.2, 0.4),
            Vector3::new(0.0, 1.0, 2.0),
            arm(0.8, 0.25),
        )
        .build();
    robot.gravity = Vector3::new(1.0, -2.0, -9.0);
    robot
}

/// A spatial arm of six revolute joints and one slider, with skew axes and frames at both ends of links.
pub fn seven_joint() -> Robot {
    let mut builder = Builder::new("seven_joint");
    for j in 0..7_u32 {
        let x = f64::from(j);
        let kind = if j == 3 { JointKind::Prismatic } else { JointKind::Revolute };
        let before =
            turned(Vector3::new(1.0, 0.3 * x, -0.5), 0.4 + 0.9 * x, Vector3::new(0.05, 0.02 * x, 0.25));
        let axis = Vector3::new(0.2 * (x - 3.0), -0.1 * x, 1.0);
        let size = 1.0 / (1.0 + 0.5 * x);
        let center = Vector3::new(0.04, -0.03, 0.1) * size;
        let link = body(4.0 * size, center, Vector3::new(0.05, 0.04, 0.03) * size);
        let (lower, upper) = if j == 3 { (-0.1, 0.25) } else { (-2.5 + 0.1 * x, 2.0) };
        builder = builder.joint(
            &format!("joint{}", j + 1),
            kind,
            j.checked_sub(1).map(|p| p as usize),
            before,
            axis,
            link,
        );
        builder = builder.limits(lower, upper);
        if j % 2 == 1 {
            builder = builder.frame_at(turned(Vector3::y(), 0.6, Vector3::new(0.1, 0.0, 0.05)));
        }
    }
    builder.build()
}
