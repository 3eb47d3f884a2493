//! Effects: what each column is, found by other means; and what all of them promise.

use super::common;

#[path = "effects/bodies.rs"]
mod bodies;
#[path = "effects/built_from_torque.rs"]
mod built_from_torque;
#[path = "effects/catalogue.rs"]
mod catalogue;
#[path = "effects/hidden.rs"]
mod hidden;
#[path = "effects/limits.rs"]
mod limits;
#[path = "effects/local.rs"]
mod local;
#[path = "effects/motion.rs"]
mod motion;
#[path = "effects/presliding.rs"]
mod presliding;
#[path = "effects/recovered.rs"]
mod recovered;
#[path = "effects/settled.rs"]
mod settled;
#[path = "effects/study.rs"]
mod study;
