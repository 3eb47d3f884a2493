//! Column maps, the ready ones too.

use super::*;
use lacuna::log::{Time, Torque};

const PI: f64 = std::f64::consts::PI;

#[test]
fn units_signs_offsets_numbers_and_decimal_commas() -> lacuna::Result<()> {
    let map = ColumnMap::open(fixture("degrees.ron"))?;
    let log = Log::open(fixture("degrees.csv"), &chain(2), Some(&map))?;
    assert_same(&log.t, &[0.0, 0.002, 0.004]);
    assert_same(&log.q[0], &[-PI, -PI / 2.0, -PI / 4.0]);
    for (found, degrees) in log.q[1].iter().zip([90.0_f64, 45.0, 22.5]) {
        assert!((found - (0.5 - degrees.to_radians())).abs() < 1e-15);
    }
    assert_same(&log.tau[0], &[0.25, 0.251, 0.252]);
    assert_same(&log.tau[1], &[-1.5005, -1.5015, -1.5025]);
    assert_eq!(log.ignored["note"], "no number in 3 of 3 rows, first in line 2");
    Ok(())
}

#[test]
fn ur_rtde_multiplies_currents_with_gains_and_keeps_them() -> lacuna::Result<()> {
    let mut map = ColumnMap::open("ur_rtde")?;
    let robot = chain(6);
    let error = Log::open(fixture("ur_rtde.csv"), &robot, Some(&map)).expect_err("blanks are no commas");
    assert!(error.to_string().contains("delimiter: ' '"), "{error}");
    map.delimiter = ' ';
    let log = Log::open(fixture("ur_rtde.csv"), &robot, Some(&map))?;
    assert_same(&log.t, &[72.008, 72.016]);
    assert_same(&log.q[5], &[0.6, 0.7]);
    assert_same(&log.dq.as_ref().expect("dq is logged")[2], &[0.03, 0.04]);
    assert_same(&log.tau[0], &[14.87, 0.5 * 14.87]);
    assert_same(&log.tau[5], &[-6.0 * 11.47, -3.0 * 11.47]);
    assert_same(&log.channels["current6"], &[-6.0, -3.0]);
    assert_same(&log.channels["joint_temperatures_0"], &[30.25, 30.5]);
    assert!(!log.channels.contains_key("actual_current_5"));
    Ok(())
}

#[test]
fn ur_rtde_torque_takes_the_controller_s_torque() -> lacuna::Result<()> {
    let text = std::fs::read_to_string(fixture("ur_rtde.csv")).expect("the fixture is there");
    let text = text.replace("actual_current_", "actual_current_as_torque_").replace(' ', ",");
    let map = ColumnMap::open("ur_rtde_torque")?;
    let log = Log::from_reader(text.as_bytes(), "ur.csv", &chain(6), Some(&map))?;
    assert_same(&log.tau[3], &[-4.0, -2.0]);
    Ok(())
}

#[test]
fn libfranka_reads_what_log_to_csv_writes() -> lacuna::Result<()> {
    let map = ColumnMap::open("libfranka")?;
    let log = Log::open(fixture("libfranka.csv"), &chain(7), Some(&map))?;
    assert_same(&log.t, &[0.017, 0.018, 0.019]);
    assert_same(&log.q[2], &[1.25, 2.25, 3.25]);
    assert_same(&log.dq.as_ref().expect("dq is logged")[0], &[3.0, 4.0, 5.0]);
    assert_same(&log.tau[6], &[5.75, 6.75, 7.75]);
    assert_same(&log.channels["state.tau_ext_hat_filtered[0]"], &[6.0, 7.0, 8.0]);
    assert_eq!(log.channels.len(), 1 + 3 * 7 + 43);
    Ok(())
}

#[test]
fn files_without_header_go_by_number_and_rate() -> lacuna::Result<()> {
    let map = "(header: false, delimiter: ' ', time: (rate_hz: 500), position: (columns: [2]), torque: (columns: [1]))";
    let log = read_mapped("  1.5 \t 2\n3.5 oops\n 5.5 6 \n", &chain(1), map)?;
    // The bad row in between took its time.
    assert_same(&log.t, &[0.0, 0.004]);
    assert_same(&log.q[0], &[2.0, 6.0]);
    assert_same(&log.tau[0], &[1.5, 5.5]);
    let error = read_mapped("a b\n1 2\n", &chain(1), map).expect_err("there is a header");
    assert!(error.to_string().contains("header: true"), "{error}");
    let error = read_mapped("1\n1\n", &chain(1), map).expect_err("there is no second column");
    assert!(error.message().contains("the file has 1 columns"), "{error}");
    Ok(())
}

#[test]
fn channels_are_renamed_kept_or_ignored() -> lacuna::Result<()> {
    let text = "t,q1,q2,tau1,tau2,temp_0,temp_1,x,y\n0,1,2,3,4,5,6,7,8\n";
    let map = r#"(channels: {"temperature{1}": "temp_{0}", "force": "y"}, other_columns: Ignore)"#;
    let log = read_mapped(text, &chain(2), map)?;
    let names: Vec<&str> = log.channels.keys().map(String::as_str).collect();
    assert_eq!(names, ["force", "temperature1", "temperature2"]);
    assert_same(&log.channels["temperature2"], &[6.0]);
    let log = read_mapped(text, &chain(2), r#"(channels: {"x": "y"})"#)?;
    assert_same(&log.channels["x"], &[8.0]);
    assert!(log.ignored.contains_key("x") && log.channels.contains_key("temp_1"));
    Ok(())
}

#[test]
fn joint_names_fill_patterns() -> lacuna::Result<()> {
    let robot = arm(&["lift", "turn"]);
    let map = r#"(position: (columns: "{name}/pos"), torque: (columns: ["b", "a"]))"#;
    let log = read_mapped("t,turn/pos,lift/pos,a,b\n0,1,2,3,4\n", &robot, map)?;
    assert_same(&log.q[0], &[2.0]);
    assert_same(&log.tau[1], &[3.0]);
    Ok(())
}

#[test]
fn prismatic_joints_have_their_own_unit() -> lacuna::Result<()> {
    let mut robot = chain(2);
    robot.joints[1].kind = JointKind::Prismatic;
    let map = r#"(position: (columns: "q{1}", unit: Degrees, linear_unit: Millimeters))"#;
    let log = read_mapped("t,q1,q2,tau1,tau2\n0,180,250,0,0\n", &robot, map)?;
    assert_same(&log.q[0], &[PI]);
    assert_same(&log.q[1], &[0.25]);
    Ok(())
}

#[test]
fn wrong_maps_point_at_line_and_column() {
    let wrong = [
        ("(\n  delimitor: ';')", "delimitor", Some(2)),
        ("(\n\n  delimiter: 'e')", "must be an ASCII character", Some(3)),
        ("(position: (columns: 5))", "a list of columns", Some(1)),
        ("(position: (columns: [0]))", "numbered from 1", Some(1)),
        ("(time: (unit: Seconds))", "either a column or rate_hz", Some(1)),
        ("(time: (rate_hz: -1))", "`rate_hz` is -1", Some(1)),
        ("(time: (column: \"t\", unit: Hours))", "Hours", Some(1)),
        ("(torque: (current: \"i{0}\"))", "current and gains", Some(1)),
        ("(torque: (columns: \"i{0}\", gain: 3))", "gain", Some(1)),
        ("(", "ends in the middle", Some(1)),
    ];
    for (text, words, line) in wrong {
        let error = ColumnMap::parse(text).expect_err(text);
        assert!(error.message().contains(words), "{text}: {error}");
        assert_eq!(error.place().and_then(|p| p.line), line, "{text}: {error}");
    }
    let deep = format!("(channels: {}", "[".repeat(100_000));
    assert!(ColumnMap::parse(&deep).is_err());
    let absent = ColumnMap::open("no_such_map").expect_err("no such file").to_string();
    assert!(absent.contains("libfranka, ur_rtde, ur_rtde_torque"), "{absent}");
}

#[test]
fn maps_that_do_not_fit_the_log_or_robot() {
    let text = "t,q1,q2,tau1,tau2\n0,1,2,3,4\n";
    let wrong = [
        (r#"(position: (columns: "p{0}"))"#, "no column `p0`"),
        (r#"(position: (columns: ["q1"]))"#, "gives 1 columns for `q`"),
        (r#"(position: (columns: "q1"))"#, "`q1` is used twice"),
        (r#"(position: (columns: "q{1}", sign: [1]))"#, "gives 1 numbers as `sign`"),
        (r#"(position: (columns: "q{1}", sign: [1, 2]))"#, "`2` in the column map is no sign"),
        (r#"(torque: (current: "tau{1}", gains: [1, 2, 3]))"#, "gives 3 numbers as `gains`"),
        (r#"(velocity: (columns: "q{1}"))"#, "`q1` is used twice"),
        (r#"(channels: {"x": "y"})"#, "no column `y`"),
    ];
    for (map, words) in wrong {
        let error = read_mapped(text, &chain(2), map).expect_err(map);
        assert!(error.message().contains(words), "{map}: {error}");
        assert!(error.place().is_some_and(|p| p.line == Some(1)), "{map}: {error}");
    }
}

#[test]
fn a_map_survives_being_written() -> Result<(), ron::Error> {
    for name in ColumnMap::ready() {
        let map = ColumnMap::open(name).expect("ready maps are maps");
        assert!(matches!(map.time, Some(Time::Column { .. })));
        assert_eq!(matches!(map.torque, Some(Torque::Current { .. })), name == "ur_rtde");
        let text = ron::to_string(&map)?;
        assert_eq!(ColumnMap::parse(&text).map_err(|e| e.to_string()), Ok(map), "{text}");
    }
    Ok(())
}
