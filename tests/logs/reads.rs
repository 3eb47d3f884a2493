//! What reads.

use super::*;
use lacuna::log::StaticPoses;

#[test]
fn a_plain_log() -> lacuna::Result<()> {
    let log = Log::open(fixture("two_link.csv"), &chain(2), None)?;
    assert_eq!(log.name, "two_link.csv");
    assert_eq!(log.rows(), 3);
    assert_same(&log.t, &[0.0, 0.001, 0.002]);
    assert_same(&log.q[1], &[-0.20, -0.21, -0.22]);
    assert_same(&log.dq.as_ref().expect("dq is logged")[0], &[0.0, 10.0, 10.0]);
    assert_same(&log.tau[0], &[12.5, 12.6, 12.7]);
    assert_same(&log.channels["temperature1"], &[31.5, 31.5, 31.6]);
    assert!(log.ddq.is_none() && log.dropped.is_empty() && log.ignored.is_empty() && !log.named_joints);
    Ok(())
}

#[test]
fn joint_names_stand_for_numbers_in_any_column_order() -> lacuna::Result<()> {
    let log = Log::open(fixture("named.csv"), &arm(&["shoulder", "elbow"]), None)?;
    assert!(log.named_joints);
    assert_same(&log.q[0], &[0.1, 0.11]);
    assert_same(&log.q[1], &[-0.2, -0.21]);
    assert_same(&log.tau[1], &[3.25, 3.26]);
    assert_same(&log.channels["time_of_day"], &[7.0, 8.0]);
    Ok(())
}

#[test]
fn every_harmless_dress_gives_the_same_log() -> lacuna::Result<()> {
    let robot = chain(1);
    let plain = "t,q1,tau1\n0,1.5,-0\n1,2.5,3e-3\n";
    let expected = read(plain, &robot)?;
    assert_same(&expected.tau[0], &[-0.0, 3e-3]);
    let dressed: [Vec<u8>; 8] = [
        plain.replace('\n', "\r\n").into(),
        [b"\xEF\xBB\xBF".as_slice(), plain.as_bytes()].concat(),
        plain.replace('\n', "\n\n  \n").into(),
        plain.trim_end().into(),
        plain.replace(',', " , ").into(),
        "\"t\",\"q1\",tau1\n\"0\",1.5,\"-0\"\n1,\"2.5\",\" 3e-3 \"\n".into(),
        gzip(plain.as_bytes()),
        [gzip(&plain.as_bytes()[..14]), gzip(&plain.as_bytes()[14..])].concat(),
    ];
    for text in dressed {
        let log = read(&text, &robot)?;
        assert_eq!(log, expected, "{}", String::from_utf8_lossy(&text));
        assert_same(&log.tau[0], &expected.tau[0]);
    }
    Ok(())
}

#[test]
fn repeated_rows_and_time_going_back_are_kept() -> lacuna::Result<()> {
    let log = read("t,q1,tau1\n0,1,1\n0,1,1\n2,1,1\n1,1,1\n", &chain(1))?;
    assert_same(&log.t, &[0.0, 0.0, 2.0, 1.0]);
    assert!(log.dropped.is_empty());
    Ok(())
}

#[test]
fn bad_rows_are_left_out_and_counted_with_their_first_place() -> lacuna::Result<()> {
    let bad = "0.5,1,x\n0.5,oops,1\n0.5,NaN,1\n0.5,1\n0.5,1,1,1\n0.5,,1\n0.5,1,1e999\n0.5,1,-inf\n";
    let good: String = (0..9).map(|k| format!("{k},{k},{k}\n")).collect();
    let log = read(format!("t,q1,tau1\n{bad}{good}"), &chain(1))?;
    assert_same(&log.q[0], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    let dropped: Vec<_> = log
        .dropped
        .iter()
        .map(|(reason, d)| (reason.as_str(), d.rows, d.first_line, d.first_column))
        .collect();
    let expected = [
        ("NaN or infinite", 3, 4, 2),
        ("empty field", 1, 7, 2),
        ("not a number", 2, 2, 3),
        ("wrong number of fields", 2, 5, 3),
    ];
    assert_eq!(dropped, expected);
    Ok(())
}

#[test]
fn a_channel_costs_rows_only_where_it_is_mostly_there() -> lacuna::Result<()> {
    let text = "t,q1,tau1,note,force,\n0,1,1,start,2,\n1,1,1,,2,\n2,1,1,,,\n3,1,1,,4,\n4,1,1,stop,5,\n";
    let log = read(text, &chain(1))?;
    assert_same(&log.t, &[0.0, 1.0, 3.0, 4.0]);
    assert_same(&log.channels["force"], &[2.0, 2.0, 4.0, 5.0]);
    assert!(!log.channels.contains_key("note"));
    let gap = log.dropped["no number in `force`"];
    assert_eq!((gap.rows, gap.first_line, gap.first_column), (1, 4, 5));
    assert_eq!(log.ignored["note"], "no number in 5 of 5 rows, first in line 2");
    assert_eq!(log.ignored["column 6"], "it has no name");
    Ok(())
}

#[test]
fn motions_and_states_do_without_torque_or_time() -> lacuna::Result<()> {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let path = folder.path().join("states.csv");
    std::fs::write(&path, "q_elbow,dq_elbow,ddq_elbow\n1,2,3\n4,5,6\n").expect("the folder is writable");
    let states = Log::open_states(&path, &arm(&["elbow"]))?;
    assert!(states.named_joints && states.t.is_empty() && states.tau.is_empty());
    assert_eq!(states.rows(), 2);
    assert_same(&states.ddq.expect("ddq is there")[0], &[3.0, 6.0]);
    std::fs::write(&path, "t,q1,tau1\n0,1,2\n").expect("the folder is writable");
    assert_same(&Log::open_without_torque(&path, &chain(1), None)?.tau[0], &[2.0]);
    std::fs::write(&path, "t,q1\n0,1\n").expect("the folder is writable");
    assert!(Log::open_without_torque(&path, &chain(1), None)?.tau.is_empty());
    let error = Log::open(&path, &chain(1), None).expect_err("torque is missing");
    assert!(error.message().contains("`tau1`"), "{error}");
    let error = Log::open_states(&path, &chain(1)).expect_err("velocity is missing");
    assert!(error.message().contains("`dq1`"), "{error}");
    Ok(())
}

#[test]
fn static_poses_keep_the_lower_triangle_by_rows() -> lacuna::Result<()> {
    let text = "q1,q2,g1,g2,m11,m12,m21,m22,remark\n1,2,3,4,5,6,7,8,\n1,2,3,4,5,6,7,?,\n0,0,0,0,1,2,3,4,x\n";
    for bytes in [text.as_bytes().to_vec(), gzip(text.as_bytes())] {
        let poses = StaticPoses::from_reader(bytes.as_slice(), "poses", &chain(2))?;
        assert_eq!(poses.rows(), 2);
        assert_eq!(poses.name, "poses");
        assert_same(&poses.g[1], &[4.0, 0.0]);
        let last: Vec<f64> = poses.m.iter().map(|m| m[1]).collect();
        assert_same(&last, &[1.0, 3.0, 4.0]);
        assert_eq!(poses.dropped["not a number"].first_column, 8);
    }
    let missing = StaticPoses::from_reader("q1,g1,M11\n0,0,1\n".as_bytes(), "poses", &chain(1));
    let missing = missing.expect_err("m11 is missing").to_string();
    assert!(missing.contains("`m11`") && missing.contains("did you mean `M11`"), "{missing}");
    Ok(())
}
