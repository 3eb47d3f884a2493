use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::kernels::{Chain, State, Twists, Workspace, regressor};
use crate::linalg::product;

/// The whole regressor at random states.
fn dense(robot: &Robot, states: usize) -> DMatrix<f64> {
    let chain = Chain::new(robot);
    let n = robot.dof();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(0x6c61_6375_6e61);
    let mut y = DMatrix::zeros(states * n, PARAMETERS_PER_LINK * n);
    let (mut ws, mut twists) = (Workspace::new(&chain, 0.0), Twists::new(&chain, 0.0));
    for k in 0..states {
        let mut draw = |reach: f64| -> Vec<f64> { (0..n).map(|_| rng.random_range(-reach..reach)).collect() };
        let (q, dq, ddq) = (draw(std::f64::consts::PI), draw(3.0), draw(5.0));
        regressor(&chain, &mut ws, &mut twists, State::new(&q, &dq, &ddq), |joint, link, columns| {
            for (c, value) in columns.into_iter().enumerate() {
                y[(k * n + joint, PARAMETERS_PER_LINK * link + c)] = value;
            }
        });
    }
    y
}

/// What a search over all columns at once finds; it takes the fourth power of the number of joints.
fn by_all_columns(robot: &Robot) -> BaseParameters {
    let y = dense(robot, 40);
    let largest = y.column_iter().map(|c| c.norm()).fold(0.0, f64::max);
    let (mut basis, mut pivots): (Vec<DVector<f64>>, Vec<usize>) = (Vec::new(), Vec::new());
    let within = |link: usize| (4..10).chain(1..4).chain(0..1).map(move |k| PARAMETERS_PER_LINK * link + k);
    for j in robot.order.iter().flat_map(|&link| within(link)) {
        let mut rest: DVector<f64> = y.column(j).into_owned();
        let size = rest.norm();
        for b in basis.iter().chain(&basis) {
            let part = b.dot(&rest);
            rest.axpy(-part, b, 1.0);
        }
        let left = rest.norm();
        if left > 1e-9 * size && left > 1e-9 * largest {
            basis.push(rest / left);
            pivots.push(j);
        }
    }
    pivots.sort_unstable();
    let qr = y.select_columns(&pivots).qr();
    let mut factors = product(&qr.q().transpose(), &y);
    assert!(qr.r().solve_upper_triangular_mut(&mut factors), "pivots are independent");
    BaseParameters { pivots, map: factors.map(tidy) }
}

/// An arm of `joints` links, each turned and shifted against the one before; every seventh joint pushes.
fn arm(joints: usize) -> Robot {
    let mut text = String::from("<robot name=\"arm\"><link name=\"base\"/>");
    for k in 1..=joints {
        let parent = if k == 1 { "base".to_string() } else { format!("l{}", k - 1) };
        let kind = if k % 7 == 5 { "prismatic" } else { "revolute" };
        let axis = ["0 0 1", "0 1 0", "0 0 1", "0.6 0 0.8"][k % 4];
        text += &format!(
            "<link name=\"l{k}\"/><joint name=\"j{k}\" type=\"{kind}\"><parent link=\"{parent}\"/>\
             <child link=\"l{k}\"/><origin xyz=\"0.1 0 {}\" rpy=\"{} 0 0\"/><axis xyz=\"{axis}\"/>\
             <limit lower=\"-1\" upper=\"1\" effort=\"10\" velocity=\"1\"/></joint>",
            0.05 * (k % 3) as f64,
            [0.0, FRAC_PI_2, -FRAC_PI_2, 0.3][k % 4],
        );
    }
    Robot::from_urdf(&(text + "</robot>")).expect("the arm reads")
}

/// Two arms on a trunk that turns about the vertical.
fn two_arms() -> Robot {
    let mut text = String::from("<robot name=\"two_arms\"><link name=\"base\"/>");
    let parents = ["base", "l1", "l2", "l3", "l1", "l5", "l6"];
    for (k, parent) in (1..).zip(parents) {
        let axis = ["0 1 0", "0 0 1"][k % 2];
        text += &format!(
            "<link name=\"l{k}\"/><joint name=\"j{k}\" type=\"continuous\"><parent link=\"{parent}\"/>\
             <child link=\"l{k}\"/><origin xyz=\"0.1 {} 0.2\"/><axis xyz=\"{axis}\"/></joint>",
            if k < 5 { 0.3 } else { -0.3 },
        );
    }
    Robot::from_urdf(&(text + "</robot>")).expect("the robot reads")
}

#[test]
fn link_by_link_finds_what_all_columns_together_show() {
    let mut robots: Vec<Robot> = ["panda.ron", "two_link.ron", "six_axis.urdf"]
        .map(|file| Robot::open(Path::new("../../robots").join(file)).expect("shipped robots read"))
        .into();
    let mut lying = robots[2].clone();
    lying.gravity = nalgebra::Vector3::new(9.81, 0.0, 0.0);
    robots.extend([lying, arm(3), arm(9), arm(14), two_arms()]);
    for robot in robots {
        let (found, wanted) = (BaseParameters::new(&robot), by_all_columns(&robot));
        assert_eq!(found.pivots, wanted.pivots, "{}, {} joints", robot.name, robot.dof());
        let apart = (&found.map - &wanted.map).amax();
        assert!(apart < 1e-9, "{}, {} joints: {apart:e}", robot.name, robot.dof());
    }
}

#[test]
fn the_combinations_give_the_torque_of_a_long_arm() {
    let robot = arm(40);
    let (base, y) = (BaseParameters::new(&robot), dense(&robot, 2));
    let again = y.select_columns(&base.pivots) * &base.map;
    assert!((&again - &y).amax() < 1e-9 * y.amax(), "{:e}", (&again - &y).amax() / y.amax());
}

#[test]
fn work_grows_with_the_square_of_the_number_of_joints() {
    let (half, whole) = (Grouping::of(&arm(60)), Grouping::of(&arm(120)));
    assert!(whole.work < 5 * half.work, "{} and {} multiplications", half.work, whole.work);
    assert!(whole.work < 100_000_000, "{} multiplications", whole.work);
    assert!(whole.pivots.len() > 120 * 6 && half.pivots.len() > 60 * 6);
}
