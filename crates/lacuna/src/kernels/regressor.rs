//! The joint-torque regressor: `tau = Y(q, dq, ddq) p` with the stacked inertial parameters `p`.

use super::chain::Chain;
use super::motion::{LinkMotion, State, Workspace, propagate};
use super::real::Real;
use super::rnea::unit_twist;
use super::vector::{add, cross, dot, scale, turn_back};
use crate::robot::PARAMETERS_PER_LINK;

/// Unit twist of one ancestor joint, seen from a link: velocity of the link origin and angular velocity.
type Twist<T> = ([T; 3], [T; 3]);

/// Twists of every joint as seen from every link it carries.
#[derive(Debug, Clone)]
pub struct Twists<T> {
    dof: usize,
    seen: Vec<Twist<T>>,
}

impl<T: Real> Twists<T> {
    /// Room for `chain`; `like` as in [`Workspace::new`].
    pub fn new(chain: &Chain, like: T) -> Self {
        let none = [like.lift(0.0); 3];
        let dof = chain.dof();
        Self { dof, seen: vec![(none, none); dof * dof] }
    }
}

/// Computes the regressor block by block: `sink(joint, link, columns)` is called for every joint and every
/// link it carries, with the ten entries of row `joint` under the parameters of `link`, in the order of
/// [`crate::robot::InertialParameters`]. All other entries are zero.
#[inline(always)]
pub fn regressor<T: Real>(
    chain: &Chain,
    ws: &mut Workspace<T>,
    twists: &mut Twists<T>,
    state: State<'_, T>,
    mut sink: impl FnMut(usize, usize, [T; PARAMETERS_PER_LINK]),
) {
    propagate(chain, ws, state);
    for &k in &chain.order {
        let link = &ws.links[k];
        let own = unit_twist(chain, k, state.q[k]);
        twists.seen[k * twists.dof + k] = own;
        sink(k, k, row(link, own));
        let Some(parent) = chain.joints[k].parent else { continue };
        let mut at = Some(parent);
        while let Some(i) = at {
            let (lin, ang) = twists.seen[parent * twists.dof + i];
            let moved = add(lin, cross(ang, link.origin));
            let seen = (turn_back(&link.rotation, moved), turn_back(&link.rotation, ang));
            twists.seen[k * twists.dof + i] = seen;
            sink(i, k, row(link, seen));
            at = chain.joints[i].parent;
        }
    }
}

/// Power of the wrench that one body needs against the twist `(lin, ang)`, per inertial parameter.
///
/// With `f = m a + alpha × mc + omega × (omega × mc)` and `n = J alpha + omega × J omega + mc × a`,
/// `lin · f + ang · n` is sorted by parameter.
#[inline(always)]
fn row<T: Real>(link: &LinkMotion<T>, (lin, ang): Twist<T>) -> [T; PARAMETERS_PER_LINK] {
    let (w, alpha, a) = (link.omega, link.alpha, link.accel);
    let mass = dot(lin, a);
    let toward = scale(w, dot(lin, w));
    let outward = scale(lin, dot(w, w));
    let mc = add(add(cross(lin, alpha), cross(a, ang)), toward);
    let u = cross(ang, w);
    let inertia = |i: usize, j: usize| {
        if i == j {
            ang[i] * alpha[i] + u[i] * w[i]
        } else {
            (ang[i] * alpha[j] + ang[j] * alpha[i]) + (u[i] * w[j] + u[j] * w[i])
        }
    };
    [
        mass,
        mc[0] - outward[0],
        mc[1] - outward[1],
        mc[2] - outward[2],
        inertia(0, 0),
        inertia(0, 1),
        inertia(0, 2),
        inertia(1, 1),
        inertia(1, 2),
        inertia(2, 2),
    ]
}

/// Static regressor at one configuration: the lower triangle of `M` by rows, then `g`, each as a linear
/// function of the parameters (Gaz et al. 2019, eq. 17).
///
/// Returns `n (n + 1) / 2 + n` rows of `10 n` columns, row by row.
pub fn static_regressor<T: Real>(chain: &Chain, q: &[T]) -> Vec<T> {
    let n = chain.dof();
    let zero = q[0].lift(0.0);
    let width = PARAMETERS_PER_LINK * n;
    let triangle = n * (n + 1) / 2;
    let mut rows = vec![zero; (triangle + n) * width];
    let mut ws = Workspace::new(chain, zero);
    let mut twists = Twists::new(chain, zero);
    let still = vec![zero; n];
    let mut put = |row: usize, link: usize, columns: [T; PARAMETERS_PER_LINK]| {
        let at = row * width + PARAMETERS_PER_LINK * link;
        rows[at..at + PARAMETERS_PER_LINK].copy_from_slice(&columns);
    };
    let state = State::new(q, &still, &still);
    regressor(chain, &mut ws, &mut twists, state, |i, k, y| put(triangle + i, k, y));
    let weightless = chain.with_gravity([0.0; 3]);
    let mut push = still.clone();
    for j in 0..n {
        push[j] = zero.lift(1.0);
        let state = State::new(q, &still, &push);
        regressor(&weightless, &mut ws, &mut twists, state, |i, k, y| {
            if i >= j {
                put(i * (i + 1) / 2 + j, k, y);
            }
        });
        push[j] = zero;
    }
    rows
}
