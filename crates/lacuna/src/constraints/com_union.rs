use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::shape::{Extent, box_forms, hull_of};
use super::{About, Bound, Constraint, LinkSpace, Links, Shape, within};
use crate::error::{Error, Result};
use crate::form::{Body, Form, General};
use crate::robot::Robot;

/// The centre of mass lies in at least one of several shapes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComUnion {
    /// Links it holds for; coordinates are in each link's own frame.
    pub links: Links,
    /// The shapes; they may overlap.
    pub shapes: Vec<Shape>,
}

impl ComUnion {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "com_union",
        title: "the centre of mass lies in one of several shapes",
        text: "For links that are made of parts and bent, like an L: what lies between the parts is outside. \
               That a centre of mass lies in one of the parts is more than physics demands (that of a bent link \
               may lie in the bend); say it when you know it. Engines that need convexity get the box around \
               all shapes instead.",
        condition: "c in shape 1 or c in shape 2 or ..",
        settings: &[
            ("links", "", "links it holds for: All, or Only([\"name\", ..])"),
            (
                "shapes",
                "m",
                "two or more of Box(lower, upper), Sphere(center, radius), Cylinder(center, axis, radius, height), \
                 Cone(base, axis, radius, top_radius, height, caps), Ellipsoid(center, semi_axes, rpy), Hull(mesh)",
            ),
        ],
        example: r#"{"com_union": (links: Only(["1"]), shapes: [Box(lower: (-0.1, -0.1, -0.1), upper: (0.1, 0.1, 0.3)), Sphere(center: (0.2, 0.0, 0.3), radius: 0.1)])}"#,
        form: "general: engines that search; the box around all shapes for the others",
    };

    fn extent(&self) -> Result<Extent> {
        let none = Error::new("com_union has no shapes").help("give at least one, or leave it out");
        let mut extents = self.shapes.iter().map(Shape::extent);
        let first = extents.next().ok_or(none)??;
        extents.try_fold(first, |sum, next| Ok(hull_of(&sum, &next?)))
    }
}

#[typetag::serde(name = "com_union")]
impl Constraint for ComUnion {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn load(&mut self, folder: &Path) -> Result<()> {
        for shape in &mut self.shapes {
            if let Shape::Hull { mesh } = shape {
                mesh.load(folder)?;
            }
        }
        Ok(())
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        let extent = self.extent()?;
        let mut forms = Vec::new();
        for link in self.links.indices(robot)? {
            let shapes = self.shapes.iter().map(|s| s.forms(space, link)).collect::<Result<Vec<_>>>()?;
            if let [only] = shapes.as_slice() {
                forms.extend_from_slice(only);
                continue;
            }
            let scale = shapes.iter().flatten().map(|f| f.scale).fold(0.0, f64::max);
            let support = (0..4).map(|k| 10 * link + k).collect();
            let body = Body::General {
                function: Arc::new(AnyOf { shapes, support }),
                why: "a union of shapes is not convex".into(),
                implied: box_forms(&extent, space, link),
            };
            let label =
                format!("{}: centre of mass in one of {} shapes", space.names[link], self.shapes.len());
            forms.push(Form::new(label, "m", scale, body));
        }
        Ok(forms)
    }

    fn bounds(&self, robot: &Robot, _space: &LinkSpace) -> Result<Vec<Bound>> {
        within(&self.links, &self.extent()?, robot)
    }
}

/// The largest, over shapes, of the smallest margin of a shape's surfaces.
#[derive(Debug)]
struct AnyOf {
    shapes: Vec<Vec<Form>>,
    support: Vec<usize>,
}

impl AnyOf {
    /// The surface that decides.
    fn decisive(&self, z: &[f64]) -> Option<(f64, &Form)> {
        let least = |surfaces: &'_ Vec<Form>| {
            let margins = surfaces.iter().map(|f| f.reported_margin(z)).enumerate();
            margins.min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let shapes = self.shapes.iter().filter_map(|s| least(s).map(|(i, margin)| (margin, &s[i])));
        shapes.max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl General for AnyOf {
    fn support(&self) -> Vec<usize> {
        self.support.clone()
    }

    fn margin(&self, z: &[f64]) -> f64 {
        self.decisive(z).map_or(f64::NAN, |d| d.0)
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        let mut slopes = vec![0.0; self.support.len()];
        let Some((margin, form)) = self.decisive(z) else { return (f64::NAN, slopes) };
        if let Some(measure) = &form.measure {
            for (i, slope) in measure.support().into_iter().zip(measure.gradient(z).1) {
                if let Ok(at) = self.support.binary_search(&i) {
                    slopes[at] = slope;
                }
            }
        }
        (margin, slopes)
    }
}
