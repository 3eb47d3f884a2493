//! Joint-space inertia matrix by composite rigid bodies (Walker and Orin 1982), in frames along the joint axes.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::axes::{Seat, Step, Tilt, axes};
use super::chain::Chain;
use super::motion::Workspace;
use super::real::{Lanes, Real};
use crate::linalg::{LINE_LENGTH, line_start};
use crate::robot::{InertialParameters, JointKind, PARAMETERS_PER_LINK, Pose};

/// Mass, first moment and inertia about the origin, in the order of [`InertialParameters`].
type Body<T> = [T; PARAMETERS_PER_LINK];

/// What of the inertia matrix `M(q)` does not depend on `q`. Build it once, use it for every sample.
#[derive(Debug, Clone, PartialEq)]
pub struct MassMatrix {
    steps: Vec<Step>,
    /// Base outwards.
    order: Vec<usize>,
    /// Each body in its own frame.
    bodies: Vec<Body<f64>>,
}

impl MassMatrix {
    /// For a robot with these stacked [`InertialParameters`] (10 per link).
    pub fn new(chain: &Chain, parameters: &[f64]) -> Self {
        let (seats, steps) = axes(chain);
        let body = |(seat, p): (&Seat, &[f64])| {
            let rotation = seat.rotation.transpose();
            let given = InertialParameters(std::array::from_fn(|k| p[k]));
            given.moved(&Pose { rotation, translation: -(rotation * seat.origin) }).0
        };
        let bodies = seats.iter().zip(parameters.chunks_exact(PARAMETERS_PER_LINK)).map(body).collect();
        Self { steps, order: chain.order.clone(), bodies }
    }

    /// Writes the full matrix, row by row, at the positions `q` [rad, m]; row and column of two revolute joints are
    /// in kg m², of two prismatic ones in kg.
    #[inline(always)]
    pub fn at<T: Real>(&self, ws: &mut Workspace<T>, q: &[T], m: &mut [T]) {
        let (n, zero) = (self.steps.len(), q[0].lift(0.0));
        m.fill(zero);
        self.carry(ws, q);
        for j in 0..n {
            let mut wrench = pushed(&self.steps[j], &ws.carried[j]);
            let mut at = j;
            loop {
                let value = felt(&self.steps[at], &wrench);
                m[j * n + at] = value;
                m[at * n + j] = value;
                let Some(parent) = self.steps[at].parent else { break };
                wrench = handed(&self.steps[at], ws.turns[at], wrench);
                at = parent;
            }
        }
    }

    /// Sums up what every joint carries, in the frame of its own body.
    #[inline(always)]
    fn carry<T: Real>(&self, ws: &mut Workspace<T>, q: &[T]) {
        let like = q[0];
        for (carried, body) in ws.carried.iter_mut().zip(&self.bodies) {
            for k in 0..PARAMETERS_PER_LINK {
                carried[k] = like.lift(body[k]);
            }
        }
        for &i in self.order.iter().rev() {
            let step = &self.steps[i];
            let Some(parent) = step.parent else { continue };
            ws.turns[i] = turn_of(step, q[i]);
            let moved = moved(step, ws.turns[i], ws.carried[i]);
            for k in 0..PARAMETERS_PER_LINK {
                ws.carried[parent][k] += moved[k];
            }
        }
    }

    /// Fills the block with the matrices at `q[joint][k]` for `k` of `range`: the same bits as [`Self::at`] sample by
    /// sample, whatever the vector width.
    ///
    /// # Panics
    /// When the range is longer than the block's capacity or reaches beyond the samples.
    pub fn fill(&self, q: &[Vec<f64>], range: Range<usize>, block: &mut MassMatrixBlock) {
        assert!(range.len() <= block.capacity && q.iter().all(|q| range.end <= q.len()));
        block.rows = range.len();
        Arch::new().dispatch(Fill { matrix: self, q, range, block });
    }
}

/// Inertia matrices of a block of samples, one contiguous column per entry of the lower triangle.
#[derive(Debug, Clone)]
pub struct MassMatrixBlock {
    capacity: usize,
    rows: usize,
    /// Distance of columns: full cache lines, and an odd number of them.
    stride: usize,
    /// Where the first column begins: at a cache line.
    base: usize,
    data: Vec<f64>,
}

impl MassMatrixBlock {
    /// Room for up to `capacity` samples of a robot with `dof` joints.
    pub fn new(dof: usize, capacity: usize) -> Self {
        let stride = (capacity.div_ceil(LINE_LENGTH) | 1) * LINE_LENGTH;
        let data = vec![0.0; dof * (dof + 1) / 2 * stride + LINE_LENGTH];
        let base = line_start(&data);
        Self { capacity, rows: 0, stride, base, data }
    }

    /// Number of samples it holds at the moment.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Entry of two joints, sample by sample; 0 throughout where neither carries the other.
    pub fn entry(&self, i: usize, j: usize) -> &[f64] {
        let at = self.base + place(i, j) * self.stride;
        &self.data[at..at + self.rows]
    }
}

/// Place of an entry in the lower triangle.
#[inline(always)]
fn place(i: usize, j: usize) -> usize {
    let (row, column) = (i.max(j), i.min(j));
    row * (row + 1) / 2 + column
}

struct Fill<'a> {
    matrix: &'a MassMatrix,
    q: &'a [Vec<f64>],
    range: Range<usize>,
    block: &'a mut MassMatrixBlock,
}

impl WithSimd for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Fill { matrix, q, range, block } = self;
        let (n, zero) = (q.len(), Lanes::constant(simd, 0.0));
        let mut ws = Workspace::sized(n, zero);
        let mut at_once = vec![zero; n];
        let mut m = vec![zero; n * n];
        let mut row = 0;
        while row < range.len() {
            let take = Lanes::<S>::COUNT.min(range.len() - row);
            for (lanes, q) in at_once.iter_mut().zip(q) {
                let from = range.start + row;
                *lanes = Lanes::load(simd, &q[from..from + take]);
            }
            matrix.at(&mut ws, &at_once, &mut m);
            for i in 0..n {
                for j in 0..=i {
                    let at = block.base + place(i, j) * block.stride + row;
                    m[i * n + j].store(&mut block.data[at..at + take]);
                }
            }
            row += take;
        }
    }
}

/// A joint's own motion: sine and cosine of its angle, and its shift along the axis.
#[inline(always)]
fn turn_of<T: Real>(step: &Step, q: T) -> [T; 3] {
    let rise = q.lift(step.rise.unwrap_or(0.0));
    match step.kind {
        JointKind::Revolute => {
            let (sin, cos) = (q + q.lift(step.angle)).sin_cos();
            [sin, cos, rise]
        }
        JointKind::Prismatic => {
            let (sin, cos) = q.lift(step.angle).sin_cos();
            [sin, cos, q + rise]
        }
    }
}

/// Force and moment that a unit acceleration of the joint asks of what it carries.
#[inline(always)]
fn pushed<T: Real>(step: &Step, b: &Body<T>) -> [[T; 3]; 2] {
    let zero = b[0].lift(0.0);
    match step.kind {
        JointKind::Revolute => [[-b[2], b[1], zero], [b[6], b[8], b[9]]],
        JointKind::Prismatic => [[zero, zero, b[0]], [b[2], -b[1], zero]],
    }
}

/// What a joint feels of a wrench.
#[inline(always)]
fn felt<T: Real>(step: &Step, [force, moment]: &[[T; 3]; 2]) -> T {
    match step.kind {
        JointKind::Revolute => moment[2],
        JointKind::Prismatic => force[2],
    }
}

/// Whether a shift along the own axis is there at all.
#[inline(always)]
fn rises(step: &Step) -> bool {
    step.rise.is_some() || step.kind == JointKind::Prismatic
}

/// A body in the parent's frame.
#[inline(always)]
fn moved<T: Real>(step: &Step, [sin, cos, rise]: [T; 3], body: Body<T>) -> Body<T> {
    let mut b = spun(body, sin, cos);
    if rises(step) {
        b = slid(b, rise);
    }
    match step.tilt {
        Tilt::None => {}
        // y becomes z, and z becomes -y.
        Tilt::Quarter => b = [b[0], b[1], -b[3], b[2], b[4], -b[6], b[5], b[9], -b[8], b[7]],
        Tilt::Any([s, c]) => b = back(spun(on(b), sin.lift(s), sin.lift(c))),
    }
    if let Some([s, c]) = step.twist {
        b = spun(b, sin.lift(s), sin.lift(c));
    }
    if let Some(x) = step.shift[0] {
        b = back(slid(on(b), sin.lift(x)));
    }
    if let Some(y) = step.shift[1] {
        b = on(slid(back(b), sin.lift(y)));
    }
    if let Some(z) = step.shift[2] {
        b = slid(b, sin.lift(z));
    }
    b
}

/// A wrench in the parent's frame, about its origin.
#[inline(always)]
fn handed<T: Real>(step: &Step, [sin, cos, rise]: [T; 3], wrench: [[T; 3]; 2]) -> [[T; 3]; 2] {
    let mut w = turned(wrench, sin, cos);
    if rises(step) {
        w = levered(w, rise);
    }
    match step.tilt {
        Tilt::None => {}
        Tilt::Quarter => {
            let [f, m] = w;
            w = [[f[0], -f[2], f[1]], [m[0], -m[2], m[1]]];
        }
        Tilt::Any([s, c]) => w = backward(turned(onward(w), sin.lift(s), sin.lift(c))),
    }
    if let Some([s, c]) = step.twist {
        w = turned(w, sin.lift(s), sin.lift(c));
    }
    if let Some(x) = step.shift[0] {
        w = backward(levered(onward(w), sin.lift(x)));
    }
    if let Some(y) = step.shift[1] {
        w = onward(levered(backward(w), sin.lift(y)));
    }
    if let Some(z) = step.shift[2] {
        w = levered(w, sin.lift(z));
    }
    w
}

/// Turns a body about z.
#[inline(always)]
fn spun<T: Real>([m, x, y, z, xx, xy, xz, yy, yz, zz]: Body<T>, s: T, c: T) -> Body<T> {
    let (difference, twice) = (yy - xx, xy + xy);
    let over = s * (s * difference - c * twice);
    [
        m,
        c * x - s * y,
        s * x + c * y,
        z,
        xx + over,
        xy - s * (s * twice + c * difference),
        c * xz - s * yz,
        yy - over,
        s * xz + c * yz,
        zz,
    ]
}

/// Shifts a body by `d` along z.
#[inline(always)]
fn slid<T: Real>([m, x, y, z, xx, xy, xz, yy, yz, zz]: Body<T>, d: T) -> Body<T> {
    let moment = m * d;
    let over = d * (z + z + moment);
    [m, x, y, z + moment, xx + over, xy, xz - d * x, yy + over, yz - d * y, zz]
}

/// The same body with its axes named anew: y, z, x become x, y, z.
#[inline(always)]
fn on<T: Real>([m, x, y, z, xx, xy, xz, yy, yz, zz]: Body<T>) -> Body<T> {
    [m, y, z, x, yy, yz, xy, zz, xz, xx]
}

/// Undoes [`on`].
#[inline(always)]
fn back<T: Real>([m, y, z, x, yy, yz, xy, zz, xz, xx]: Body<T>) -> Body<T> {
    [m, x, y, z, xx, xy, xz, yy, yz, zz]
}

/// Turns a wrench about z.
#[inline(always)]
fn turned<T: Real>([f, m]: [[T; 3]; 2], s: T, c: T) -> [[T; 3]; 2] {
    [[c * f[0] - s * f[1], s * f[0] + c * f[1], f[2]], [c * m[0] - s * m[1], s * m[0] + c * m[1], m[2]]]
}

/// The wrench about a point that lies `d` below on z.
#[inline(always)]
fn levered<T: Real>([f, m]: [[T; 3]; 2], d: T) -> [[T; 3]; 2] {
    [f, [m[0] - d * f[1], m[1] + d * f[0], m[2]]]
}

/// The same wrench with its axes named anew: y, z, x become x, y, z.
#[inline(always)]
fn onward<T: Real>([f, m]: [[T; 3]; 2]) -> [[T; 3]; 2] {
    [[f[1], f[2], f[0]], [m[1], m[2], m[0]]]
}

/// Undoes [`onward`].
#[inline(always)]
fn backward<T: Real>([f, m]: [[T; 3]; 2]) -> [[T; 3]; 2] {
    [[f[2], f[0], f[1]], [m[2], m[0], m[1]]]
}
