//! Loads against their formulas, steepness against differences, names against the catalogue's.

use nalgebra::Vector3;

use super::super::{Kinematics, Moment, Observed, OwnSlope, PerJoint, Plant, PlantEffect, TWINS, WorldFrame};

use super::*;
use lacuna_base::excitation::FourierMotion;
use lacuna_base::robot::InertialParameters;
use lacuna_base::robot::samples;

/// Every effect with its settings, for a robot of seven joints.
fn all_written() -> Vec<(&'static str, &'static str)> {
    let product =
        "(joint: 4, amplitude: 0.4, factors: [Velocity(4), Wave(of: 3, k: 3, phase: 0.8), Position(2)])";
    TWINS.iter().map(|twin| (twin.name, twin.example)).chain([("product", product)]).collect()
}

fn read(name: &str, settings: &str) -> Box<dyn PlantEffect> {
    lacuna_base::text::from_ron(&format!("{{\"{name}\": {settings}}}"))
        .unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn written(name: &str) -> Box<dyn PlantEffect> {
    read(name, all_written().iter().find(|(n, _)| *n == name).expect("an effect").1)
}

const Q: [f64; 7] = [0.3, -0.4, 0.9, 0.05, -1.2, 0.7, 0.1];

/// Load on the seven-joint toy at velocities `dq` under drives of 5 N m and with `own` states.
fn load(effect: &dyn PlantEffect, t: f64, dq: &[f64; 7], own: &[f64]) -> [f64; 7] {
    let arm = Kinematics::new(&samples::seven_joint()).expect("a robot");
    let mut load = [0.0; 7];
    effect.add_load(&Moment { t, q: &Q, dq, tau: &[5.0; 7], own, arm: &arm }, &mut load);
    load
}

#[test]
fn every_effect_of_the_catalogue_is_written_under_its_name_and_read_back() -> Result<()> {
    for (name, settings) in all_written() {
        let effect = read(name, settings);
        effect.check(7).map_err(|e| e.within(name))?;
        let text = ron::to_string(&effect).map_err(|e| Error::new(e.to_string()))?;
        assert!(text.starts_with(&format!("{{\"{name}\":")), "{text}");
        let back: Box<dyn PlantEffect> = ron::from_str(&text).map_err(|e| Error::new(e.to_string()))?;
        assert_eq!(format!("{effect:?}"), format!("{back:?}"));
    }
    Ok(())
}

#[test]
fn settings_without_meaning_are_refused() {
    for (name, settings) in [
        ("stribeck_friction", "(levels: [0.4], velocities: [0])"),
        ("nonlinear_viscous_friction", "(coefficients: [0.3], exponent: 1)"),
        ("load_dependent_friction", "(ratios: [0.95])"),
        ("coupled_friction", "(joint: 5, from: 5)"),
        ("coupled_friction", "(joint: 0, from: 5)"),
        ("presliding_hysteresis", "(levels: [0.3], stiffness: [400], static_ratio: 0.5)"),
        ("contact_force", "(force: (1, 0, 0), from_s: 2, to_s: 1)"),
        ("payload", "(mass: -1, com: (0, 0, 0))"),
        ("time_delay", "(delays_s: [4.3])"),
        ("product", "(joint: 4, amplitude: 1, factors: [Pieces(of: 1, points: [(1, 0), (0, 1)])])"),
        ("product", "(joint: 8, amplitude: 1, factors: [])"),
        ("backlash", "(gaps: [0.1, 0.2])"),
    ] {
        let read =
            lacuna_base::text::from_ron::<Box<dyn PlantEffect>>(&format!("{{\"{name}\": {settings}}}"));
        assert!(read.and_then(|effect| effect.check(7)).is_err(), "{name} {settings}");
    }
}

#[test]
fn loads_are_what_the_formulas_say() {
    let mut dq = [0.5, -0.5, 2.0, 0.0, -1.0, 0.1, 1.0];
    let near = |got: f64, want: f64, what: &str| assert!((got - want).abs() < 1e-12, "{what}: {got} {want}");
    let of =
        |name: &str| load(written(name).as_ref(), 4.0, &[0.5, -0.5, 2.0, 0.0, -1.0, 0.1, 1.0], &[0.3; 7]);
    near(of("stribeck_friction")[5], 0.4 * (-1.0_f64).exp(), "Stribeck at its velocity");
    let asymmetric = of("asymmetric_friction");
    near(asymmetric[2], 0.5 * 2.0 + 0.3, "forwards");
    near(asymmetric[4], -0.2, "backwards");
    near(of("nonlinear_viscous_friction")[2], 0.3 * 2.0_f64.powf(2.5), "power");
    let load_dependent = of("load_dependent_friction");
    // 5 N m arrive: transmitted + friction = 5 with friction = 0.09 transmitted forwards.
    near(load_dependent[2], 5.0 * 0.09 / 1.09, "driving");
    near(load_dependent[4], -5.0 * 0.07 / 0.93, "driven");
    near(of("position_dependent_friction")[2], 0.2 * (2.7_f64 + 0.4).sin(), "position dependent");
    near(of("coupled_friction")[4], 0.0, "the other joint rests");
    near(of("joint_spring")[6], 0.0, "spring at rest");
    near(of("joint_spring")[2], 1.6, "spring");
    near(of("torque_ripple")[0], 0.3 * (3.6_f64 + 1.0).sin(), "ripple");
    near(of("torque_drift")[1], 0.04, "drift");
    near(of("friction_drift")[2], (0.2 + 0.2) * (-0.5_f64).exp(), "running in");
    let warm = 0.3 + 2.0 * (-4.0_f64 / 30.0).exp();
    near(of("thermal_friction")[2], warm * (-0.004 - 0.04), "thermal");
    near(of("product")[3], 0.0, "a product with a zero");
    dq[3] = -0.6;
    let product = load(written("product").as_ref(), 0.0, &dq, &[]);
    near(product[3], 0.4 * -0.6 * (2.7_f64 + 0.8).sin() * -0.4, "product");
    near(product.iter().map(|x| x.abs()).sum::<f64>(), product[3].abs(), "on one joint");
}

#[test]
fn no_load_is_steeper_than_said() {
    for (name, _) in all_written() {
        let effect = written(name);
        let mut said = [0.0; 7];
        effect.add_steepest_slope(&mut said);
        for k in -2000..2000 {
            let v = 1e-4 + 1e-3 * f64::from(k);
            let own = vec![0.1; effect.states(7)];
            let (low, high) =
                (load(effect.as_ref(), 1.0, &[v; 7], &own), load(effect.as_ref(), 1.0, &[v + 1e-5; 7], &own));
            for j in 0..7 {
                let seen = (high[j] - low[j]) / 1e-5;
                assert!(seen <= said[j] + 1e-6, "{name} joint {}: {seen} {}", j + 1, said[j]);
            }
        }
    }
}

#[test]
fn factors_have_the_shapes_they_say() {
    let arm = Kinematics::new(&samples::seven_joint()).expect("a robot");
    let value = |factor: &Factor, q: f64| {
        let now = Moment { t: 2.0, q: &[q; 7], dq: &[-0.5; 7], tau: &[0.0; 7], own: &[], arm: &arm };
        factor.value(&now)
    };
    let detent = Factor::Detent { of: 2, at: 0.4, width: 0.05 };
    assert!(value(&detent, 0.4).abs() < 1e-15 && (value(&detent, 0.45) - 1.0).abs() < 1e-12);
    assert!((value(&detent, 0.35) + 1.0).abs() < 1e-12 && value(&detent, 0.8).abs() < 1e-12);
    let pieces = Factor::Pieces { of: 1, points: vec![(0.0, 1.0), (1.0, 3.0), (2.0, -1.0)] };
    for (q, want) in [(-1.0, 1.0), (0.25, 1.5), (1.0, 3.0), (1.5, 1.0), (7.0, -1.0)] {
        assert!((value(&pieces, q) - want).abs() < 1e-12, "{q}");
    }
    assert!((value(&Factor::Beyond { of: 3, from: 0.5 }, 0.8) - 0.3).abs() < 1e-12);
    assert!(value(&Factor::Beyond { of: 3, from: 0.5 }, 0.2).abs() < 1e-15);
    assert!((value(&Factor::Below { of: 3, to: 0.5 }, 0.2) + 0.3).abs() < 1e-12);
    assert!((value(&Factor::Speed(1), 0.0) - 0.5).abs() < 1e-15);
    let switch = Factor::OnOff { period_s: 2.0, phase: 0.2 };
    let at = |t: f64| switch.value(&Moment { t, q: &Q, dq: &Q, tau: &Q, own: &[], arm: &arm });
    let steps: Vec<f64> = (0..1000).map(|k| at(0.02 * f64::from(k))).collect();
    assert!(steps.iter().all(|x| (0.0..=1.0).contains(x)));
    let mean = steps.iter().sum::<f64>() / 1000.0;
    assert!((0.3..0.7).contains(&mean), "on about half of the time: {mean}");
    let channel = Factor::Channel { name: "pressure1".into(), period_s: 7.0, phase: 0.3, mean: 2.0 };
    assert!((1.0..3.0).contains(&value(&channel, 0.0)));
    let effect = Product { joint: 1, amplitude: 2.0, factors: vec![channel.clone()] };
    let now = Moment { t: 2.0, q: &Q, dq: &Q, tau: &Q, own: &[], arm: &arm };
    let mut noted = Vec::new();
    effect.measure(&now, &mut |name, x| noted.push((name.to_string(), x)));
    assert_eq!(noted, vec![("pressure1".to_string(), value(&channel, 0.0))]);
}

#[test]
fn a_push_is_the_gradient_of_its_work() {
    // Joint torques of a force are the slopes of the way of its point along it (virtual work).
    let robot = samples::seven_joint();
    let arm = Kinematics::new(&robot).expect("a robot");
    let effect = ContactForce {
        force: [3.0, -2.0, 5.0],
        from_s: 1.0,
        to_s: 2.0,
        rise_s: 0.02,
        point: [0.0, 0.1, 0.2],
        link: Some(5),
    };
    let work = |q: &[f64; 7]| {
        let pose = arm.poses(q)[4];
        Vector3::new(3.0, -2.0, 5.0).dot(&(pose.rotation * Vector3::new(0.0, 0.1, 0.2) + pose.translation))
    };
    let got = load(&effect, 1.5, &[0.0; 7], &[]);
    for j in 0..7 {
        let (mut low, mut high) = (Q, Q);
        low[j] -= 1e-6;
        high[j] += 1e-6;
        let slope = (work(&high) - work(&low)) / 2e-6;
        assert!((got[j] + slope).abs() < 1e-7, "joint {}: {} {slope}", j + 1, got[j]);
    }
    assert!(load(&effect, 0.9, &[0.0; 7], &[]).iter().all(|x| x.abs() <= 0.0));
    assert!(load(&effect, 2.1, &[0.0; 7], &[]).iter().all(|x| x.abs() <= 0.0));
}

#[test]
fn payload_and_tilt_change_what_holds_the_robot() -> Result<()> {
    // A held robot (no motion commanded) shows the gravity torque of the robot that really is there.
    let (robot, still) = (
        samples::seven_joint(),
        FourierMotion::new(4.0, vec![vec![0.0; 7]], vec![vec![0.0; 7]], Q.to_vec())?,
    );
    let mut plant = Plant::new(robot.clone())?;
    plant.effects = vec![written("payload"), written("base_tilt")];
    plant.method = super::super::Method::Implicit;
    let truth = plant.simulate(&still, 6.0, 0)?.truth;
    let mut loaded = robot.clone().with_gravity(Vector3::new(0.005, -0.003, -1.0).normalize() * 9.81);
    let body =
        InertialParameters::from_barycentric(1.5, Vector3::new(0.02, 0.01, 0.08), nalgebra::Matrix3::zeros());
    loaded.links[6].inertia = loaded.links[6].inertia.map(|link| link.combined(&body));
    let mut world = WorldFrame::new(&loaded, &loaded.inertial_parameters()?)?;
    let (end, mut want) = (truth.t.len() - 1, [0.0; 7]);
    let q: Vec<f64> = truth.q.iter().map(|q| q[end]).collect();
    world.gravity_torque(&q, &mut want);
    for j in 0..7 {
        assert!(
            (truth.tau[j][end] - want[j]).abs() < 1e-6,
            "joint {}: {} {}",
            j + 1,
            truth.tau[j][end],
            want[j]
        );
    }
    Ok(())
}

#[test]
fn bristles_bend_as_dahl_says_and_then_slide() {
    // Along a monotonous way x the exact solution is z = 1 - exp(-s x); its mirror image on the way back.
    let dahl = PreslidingHysteresis::dahl(PerJoint::all(0.3), PerJoint::all(400.0));
    let arm = Kinematics::new(&samples::seven_joint()).expect("a robot");
    let mut rates = [0.0; 7];
    let (mut z, h) = (0.0, 1e-5);
    for k in 0..20_000 {
        let v = if k < 10_000 { 0.05 } else { -0.05 };
        let now = Moment { t: 0.0, q: &Q, dq: &[v; 7], tau: &Q, own: &[z; 7], arm: &arm };
        dahl.rates(&now, &mut rates);
        z += h * rates[0];
        if k == 9_999 {
            assert!((z - (1.0 - (-400.0 * 0.005_f64).exp())).abs() < 1e-3, "{z}");
        }
    }
    let top = 1.0 - (-2.0_f64).exp();
    let want = -1.0 + (1.0 + top) * (-2.0_f64).exp();
    assert!((z - want).abs() < 1e-3, "{z} {want}");
    let now = Moment { t: 0.0, q: &Q, dq: &[0.2; 7], tau: &Q, own: &[0.5; 7], arm: &arm };
    let mut slopes = [OwnSlope::default(); 7];
    dahl.own_slopes(&now, &mut slopes);
    assert!(
        (slopes[3].rate_per_own + 80.0).abs() < 1e-9 && (slopes[3].rate_per_velocity - 200.0).abs() < 1e-9
    );
}

#[test]
fn sensors_err_as_they_should() {
    let line = |slope: f64| (0..100).map(|k| slope * f64::from(k)).collect::<Vec<f64>>();
    let seen = Observed {
        dt: 1e-3,
        q: vec![line(1e-3)],
        dq: vec![vec![1.0; 100]],
        tau: vec![line(0.5)],
        transmitted: vec![line(0.5)],
    };
    let after = |name: &str| {
        let mut seen = seen.clone();
        written(name).observe(&mut seen);
        seen
    };
    let near = |got: f64, want: f64| assert!((got - want).abs() < 1e-12, "{got} {want}");
    near(after("joint_zero_error").q[0][7], 0.007 - 0.02);
    near(after("torque_gain").tau[0][40], 21.0);
    near(after("time_delay").tau[0][40], 20.0 - 0.5 * 4.3);
    let elastic = after("joint_elasticity");
    near(elastic.q[0][40], 0.04 + 20.0 * 1e-4);
    near(elastic.dq[0][40], 1.0 + 500.0 * 1e-4);
    let play = after("backlash");
    near(play.q[0][0], 0.0);
    near(play.q[0][90], 0.09 + 0.001);
    assert!(play.dq[0][1] > 1.2, "the motor hurries through the gap: {}", play.dq[0][1]);
}
