//! Convex hull of points as half-spaces, by quickhull (Barber, Dobkin and Huhdanpaa 1996).
//!
//! What comes out always holds every point: each plane is shifted to touch the outermost one. Thin or
//! nearly coplanar triangles, which CAD meshes are full of, can therefore cost tightness of about
//! [`NEAR`] times the size, never correctness.

use std::collections::HashMap;

use nalgebra::Vector3;

/// Points this close to a plane, as a part of the hull's size, lie on it.
const NEAR: f64 = 1e-9;
/// Planes whose unit normals differ by less than this are one.
const PARALLEL: f64 = 1e-4;

/// `normal . x <= offset`, unit normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HalfSpace {
    pub normal: Vector3<f64>,
    pub offset: f64,
}

/// A triangle of the growing hull, corners counter-clockwise from outside.
struct Triangle {
    corners: [usize; 3],
    normal: Vector3<f64>,
    offset: f64,
    /// Points beyond it that no other triangle has taken.
    beyond: Vec<usize>,
    alive: bool,
}

/// The planes around `points`, largest face first, coplanar triangles merged.
///
/// # Errors
/// When the points lie in a plane; the message says so.
pub(super) fn convex_hull(points: &[Vector3<f64>]) -> Result<Vec<HalfSpace>, String> {
    let Some(simplex) = simplex(points) else {
        return Err("its points lie in one plane, so it has no inside".into());
    };
    let mut hull = Growing::new(points, simplex);
    while let Some(next) = hull.triangles.iter().rposition(|t| t.alive && !t.beyond.is_empty()) {
        hull.reach_out(next);
    }
    Ok(merged(points, &hull.triangles))
}

/// Length of the diagonal of the smallest box.
pub(super) fn size(points: &[Vector3<f64>]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let low = points.iter().fold(*first, |a, p| a.inf(p));
    let high = points.iter().fold(*first, |a, p| a.sup(p));
    (high - low).norm()
}

/// Four points far apart, not in a plane.
fn simplex(points: &[Vector3<f64>]) -> Option<[usize; 4]> {
    let near = NEAR * size(points);
    let farthest = |distance: &dyn Fn(&Vector3<f64>) -> f64| {
        let best =
            (0..points.len()).max_by(|&i, &j| distance(&points[i]).total_cmp(&distance(&points[j])))?;
        (distance(&points[best]) > near).then_some(best)
    };
    let a = (0..points.len()).min_by(|&i, &j| points[i].x.total_cmp(&points[j].x))?;
    let pa = points[a];
    let b = farthest(&|p| (p - pa).norm())?;
    let along = (points[b] - pa).normalize();
    let c = farthest(&|p| (p - pa).cross(&along).norm())?;
    let normal = along.cross(&(points[c] - pa)).normalize();
    let d = farthest(&|p| (p - pa).dot(&normal).abs())?;
    let above = (points[d] - pa).dot(&normal) > 0.0;
    Some(if above { [a, c, b, d] } else { [a, b, c, d] })
}

struct Growing<'a> {
    points: &'a [Vector3<f64>],
    near: f64,
    triangles: Vec<Triangle>,
    /// The living triangle on the left of each directed edge.
    left_of: HashMap<(usize, usize), usize>,
}

impl<'a> Growing<'a> {
    /// From a simplex whose fourth point lies below the first three.
    fn new(points: &'a [Vector3<f64>], [a, b, c, d]: [usize; 4]) -> Self {
        let near = NEAR * size(points);
        let mut hull = Self { points, near, triangles: Vec::new(), left_of: HashMap::new() };
        for corners in [[a, b, c], [a, d, b], [b, d, c], [c, d, a]] {
            hull.add(corners);
        }
        hull.share(&(0..points.len()).collect::<Vec<_>>(), 0);
        hull
    }

    fn add(&mut self, corners: [usize; 3]) {
        let [a, b, c] = corners.map(|i| self.points[i]);
        let area = (b - a).cross(&(c - a));
        // A triangle without area has no plane; it only keeps the surface closed.
        let normal = area.try_normalize(f64::MIN_POSITIVE.sqrt()).unwrap_or_default();
        let id = self.triangles.len();
        for i in 0..3 {
            self.left_of.insert((corners[i], corners[(i + 1) % 3]), id);
        }
        let offset = normal.dot(&a);
        self.triangles.push(Triangle { corners, normal, offset, beyond: Vec::new(), alive: true });
    }

    fn height(&self, triangle: usize, point: usize) -> f64 {
        let t = &self.triangles[triangle];
        t.normal.dot(&self.points[point]) - t.offset
    }

    /// Gives each point to the first triangle, from `first` on, that it lies beyond.
    fn share(&mut self, points: &[usize], first: usize) {
        for &p in points {
            let taker = (first..self.triangles.len()).find(|&t| self.height(t, p) > self.near);
            if let Some(t) = taker {
                self.triangles[t].beyond.push(p);
            }
        }
    }

    /// Adds the point farthest beyond triangle `start`.
    fn reach_out(&mut self, start: usize) {
        let beyond = &self.triangles[start].beyond;
        let farthest =
            beyond.iter().copied().max_by(|&p, &q| self.height(start, p).total_cmp(&self.height(start, q)));
        let Some(apex) = farthest else { return };
        let (seen, horizon) = self.seen_from(apex, start);
        let mut orphans = Vec::new();
        for t in seen {
            let triangle = &mut self.triangles[t];
            triangle.alive = false;
            orphans.append(&mut triangle.beyond);
        }
        let first = self.triangles.len();
        for (a, b) in horizon {
            self.add([a, b, apex]);
        }
        orphans.retain(|&p| p != apex);
        self.share(&orphans, first);
    }

    /// The connected triangles that `apex` lies beyond, and the directed edges around them.
    fn seen_from(&self, apex: usize, start: usize) -> (Vec<usize>, Vec<(usize, usize)>) {
        let mut seen = vec![start];
        let mut edges = Vec::new();
        let mut done = 0;
        while let Some(&t) = seen.get(done) {
            done += 1;
            let corners = self.triangles[t].corners;
            for i in 0..3 {
                let edge = (corners[i], corners[(i + 1) % 3]);
                edges.push(edge);
                if let Some(&twin) = self.left_of.get(&(edge.1, edge.0))
                    && self.triangles[twin].alive
                    && !seen.contains(&twin)
                    && self.height(twin, apex) > self.near
                {
                    seen.push(twin);
                }
            }
        }
        let is_inner = |(a, b): (usize, usize)| self.left_of.get(&(b, a)).is_some_and(|t| seen.contains(t));
        edges.retain(|&edge| !is_inner(edge));
        (seen, edges)
    }
}

/// One plane for each group of parallel triangles, largest area first, shifted to touch the points.
fn merged(points: &[Vector3<f64>], triangles: &[Triangle]) -> Vec<HalfSpace> {
    let area = |t: &Triangle| {
        let [a, b, c] = t.corners.map(|i| points[i]);
        (b - a).cross(&(c - a)).norm()
    };
    let smallest = NEAR * size(points).powi(2);
    let mut alive: Vec<(f64, &Triangle)> =
        triangles.iter().filter(|t| t.alive).map(|t| (area(t), t)).filter(|(a, _)| *a > smallest).collect();
    alive.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.corners.cmp(&y.1.corners)));
    let mut groups: Vec<(f64, Vector3<f64>)> = Vec::new();
    for (area, triangle) in alive {
        match groups.iter_mut().find(|(_, n)| (*n - triangle.normal).norm() < PARALLEL) {
            Some((sum, _)) => *sum += area,
            None => groups.push((area, triangle.normal)),
        }
    }
    groups.sort_by(|x, y| y.0.total_cmp(&x.0));
    let touching =
        |normal: &Vector3<f64>| points.iter().map(|p| normal.dot(p)).fold(f64::NEG_INFINITY, f64::max);
    groups.into_iter().map(|(_, normal)| HalfSpace { normal, offset: touching(&normal) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    /// All planes through three points that have every point on one side.
    fn by_brute_force(points: &[Vector3<f64>]) -> usize {
        let n = points.len();
        let mut count = 0;
        for i in 0..n {
            for j in i + 1..n {
                for k in j + 1..n {
                    let normal = (points[j] - points[i]).cross(&(points[k] - points[i])).normalize();
                    let side: Vec<f64> = points.iter().map(|p| normal.dot(&(p - points[i]))).collect();
                    let one_side = side.iter().all(|s| *s < 1e-9) || side.iter().all(|s| *s > -1e-9);
                    count += usize::from(one_side);
                }
            }
        }
        count
    }

    fn holds(hull: &[HalfSpace], p: &Vector3<f64>, slack: f64) -> bool {
        hull.iter().all(|h| h.normal.dot(p) <= h.offset + slack)
    }

    #[test]
    fn random_points_have_the_faces_that_brute_force_finds() {
        for seed in 1..20 {
            let mut stream = Stream::new(seed, 0);
            let points: Vec<_> =
                (0..30).map(|_| Vector3::from_fn(|_, _| stream.between(-1.0, 1.0))).collect();
            let hull = convex_hull(&points).expect("has an inside");
            assert_eq!(hull.len(), by_brute_force(&points), "seed {seed}");
            assert!(points.iter().all(|p| holds(&hull, p, 1e-12)));
        }
    }

    #[test]
    fn a_finely_meshed_box_has_six_faces() {
        let grid = |n: usize| (0..n).map(move |i| i as f64 / (n - 1) as f64);
        let points: Vec<_> = grid(9)
            .flat_map(|x| grid(7).flat_map(move |y| grid(5).map(move |z| Vector3::new(2.0 * x, y, 0.3 * z))))
            .collect();
        let hull = convex_hull(&points).expect("has an inside");
        assert_eq!(hull.len(), 6, "{hull:?}");
        assert!(holds(&hull, &Vector3::new(1.0, 0.5, 0.1), -0.09));
        assert!(!holds(&hull, &Vector3::new(2.0 + 1e-6, 0.5, 0.1), 0.0));
        assert!(!holds(&hull, &Vector3::new(1.0, 0.5, -1e-6), 0.0));
    }

    #[test]
    fn a_meshed_ball_and_a_meshed_cylinder_hold_no_more_than_they_should() {
        let turn = |i: usize, n: usize| 2.0 * std::f64::consts::PI * i as f64 / n as f64;
        let mut cylinder = Vec::new();
        for i in 0..48 {
            for k in 0..5 {
                let a = turn(i, 48);
                cylinder.push(Vector3::new(0.1 * libm::cos(a), 0.1 * libm::sin(a), 0.1 * k as f64));
            }
        }
        let hull = convex_hull(&cylinder).expect("has an inside");
        assert_eq!(hull.len(), 50);
        assert!(!holds(&hull, &Vector3::new(0.1 + 1e-6, 0.0, 0.2), 0.0));
        let mut stream = Stream::new(5, 0);
        let ball: Vec<_> = (0..2000).map(|_| Vector3::from_fn(|_, _| stream.normal()).normalize()).collect();
        let hull = convex_hull(&ball).expect("has an inside");
        // Each of the 2 n - 4 faces touches the sphere with three corners; all are inside it.
        assert!(hull.len() > 3900, "{}", hull.len());
        assert!(hull.iter().all(|h| h.offset < 1.0 && h.offset > 0.9));
    }

    #[test]
    fn flat_things_have_no_inside() {
        let flat: Vec<_> = (0..9).map(|i| Vector3::new((i % 3) as f64, (i / 3) as f64, 1.0)).collect();
        assert!(convex_hull(&flat).is_err());
        assert!(convex_hull(&flat[..2]).is_err());
        assert!(convex_hull(&[]).is_err());
        assert!(convex_hull(&[Vector3::x(); 12]).is_err());
    }
}
