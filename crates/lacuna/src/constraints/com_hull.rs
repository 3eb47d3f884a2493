use std::path::Path;

use serde::{Deserialize, Serialize};

use super::mesh::Mesh;
use super::{About, Bound, Constraint, LinkSpace, Links, Shape, inside, within};
use crate::error::Result;
use crate::form::Form;
use crate::robot::Robot;

/// The centre of mass lies in the convex hull of a mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComHull {
    /// Links it holds for; the mesh is in each link's own frame.
    pub links: Links,
    /// The mesh.
    pub mesh: Mesh,
}

impl ComHull {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "com_hull",
        title: "the centre of mass lies in the convex hull of an STL mesh",
        text: "The tightest statement about a link's shape that needs no thought: take the link's visual or \
               collision mesh. Whatever the density, the centre of mass lies in the convex hull. A hull with \
               more faces than `faces` is replaced by its largest ones and a box, which is slightly larger.",
        condition: "n_k . m c <= d_k m for every face k of the hull",
        settings: &[
            ("links", "", "links it holds for: All, or Only([\"name\", ..])"),
            ("mesh.path", "", "STL file, ASCII or binary, relative to the scenario, inside its repository"),
            ("mesh.scale", "m", "metres per unit of the file; 1 when not given, 0.001 for millimetres"),
            ("mesh.xyz", "m", "origin of the mesh in the link frame; none when not given"),
            ("mesh.rpy", "rad", "roll, pitch, yaw of the mesh in the link frame; none when not given"),
            ("mesh.faces", "", "most faces to use, 6 or more; 200 when not given"),
        ],
        example: r#"{"com_hull": (links: Only(["1"]), mesh: (path: "meshes/link1.stl", scale: 1.0))}"#,
        form: "affine, one per face: every engine",
    };

    fn shape(&self) -> Shape {
        Shape::Hull { mesh: self.mesh.clone() }
    }
}

#[typetag::serde(name = "com_hull")]
impl Constraint for ComHull {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn load(&mut self, folder: &Path) -> Result<()> {
        self.mesh.load(folder)
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        inside(&self.links, &self.shape(), robot, space)
    }

    fn bounds(&self, robot: &Robot, _space: &LinkSpace) -> Result<Vec<Bound>> {
        within(&self.links, &self.shape().extent()?, robot)
    }
}
