//! What is refused: each with the words that tell where and why, and a remedy.

use super::*;
use std::io::Read;

/// Reads `text` for a robot of two joints; checks place, words and that there is help.
#[track_caller]
fn refused(text: impl AsRef<[u8]>, place: (usize, usize), words: &[&str]) {
    refused_by(&chain(2), text, place, words);
}

#[track_caller]
fn refused_by(robot: &Robot, text: impl AsRef<[u8]>, (line, column): (usize, usize), words: &[&str]) {
    let error = read(text, robot).expect_err("this must be refused");
    let message = error.to_string();
    assert!(message.starts_with(&format!("log.csv:{line}:{column}: ")), "{message}");
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
    assert!(message.contains("\n  help: "), "{message}");
    assert!(message.len() < 1000, "{message}");
}

const HEADER: &str = "t,q1,q2,tau1,tau2\n";

#[test]
fn nothing_to_read() {
    refused("", (1, 1), &["empty"]);
    refused("\n \r\n\n", (1, 1), &["empty"]);
    refused(HEADER, (1, 1), &["no row"]);
}

#[test]
fn no_header() {
    refused("0,1,2,3,4\n1,1,2,3,4\n", (1, 1), &["no header line", "column map", "header: false"]);
    refused("# t q1 q2\n0 1 2\n", (1, 1), &["comment", "remove only the `#`"]);
}

#[test]
fn missing_columns_name_what_is_there() {
    refused(
        "t,q1,q2,tau1,Tau2\n0,1,2,3,4\n",
        (1, 1),
        &["`tau2`", "t, q1, q2, tau1, Tau2", "did you mean `Tau2`"],
    );
    refused("time,q1,q2,tau1,tau2\n0,1,2,3,4\n", (1, 1), &["`t`", "did you mean `time`"]);
    refused("t,p1,p2\n0,1,2\n", (1, 1), &["no column `q1`", "t, p1, p2"]);
    let arm7 = chain(7);
    let header = "t,q1,q2,q3,q4,q5,q6,q7,dq1,dq3,dq7\n0,1,2\n";
    refused_by(&arm7, header, (1, 1), &["dq2, dq4, dq5, dq6", "all 7 joints", "or none"]);
}

#[test]
fn wrong_joint_count_says_both_numbers() {
    let header = "t,q1,q2,q3,q4,q5,q6,tau1,tau2,tau3,tau4,tau5,tau6\n";
    refused_by(&chain(7), header, (1, 1), &["q1 to q6", "6 joints", "`arm` has 7"]);
    refused(header, (1, 1), &["6 joints", "has 2"]);
    refused("t,q0,q1,tau0,tau1\n0,1,2,3,4\n", (1, 1), &["`q0`", "from 1", "columns: \"q{0}\""]);
}

#[test]
fn two_columns_of_one_name() {
    refused("t,q1,q2,tau1,q1\n0,1,2,3,4\n", (1, 5), &["`q1`", "number 2 and 5"]);
    refused("t,q1,q_joint1,q2,tau1,tau2\n", (1, 1), &["`q1` and `q_joint1` are the same joint"]);
}

#[test]
fn too_many_columns() {
    let header = (0..100_000).map(|i| format!("c{i},")).collect::<String>();
    refused(&header, (1, 1), &["100001 columns", "4096"]);
    refused(header.repeat(10), (1, 1), &["longer than 1048576 bytes"]);
    let endless = std::io::repeat(b'7');
    let error = Log::from_reader(endless, "endless", &chain(1), None).expect_err("there is no end");
    assert!(error.message().contains("longer than"), "{error}");
}

#[test]
fn values_that_are_none() {
    refused(format!("{HEADER}0,1,NaN,3,4\n"), (2, 3), &["`NaN` in `q2`", "finite", "1 of 1 rows"]);
    refused(format!("{HEADER}0,1,2,3,4e999\n"), (2, 5), &["`4e999` in `tau2`", "finite"]);
    refused(format!("{HEADER}0,1,2,12a,4\n"), (2, 4), &["`12a` in `tau1` is not a number"]);
    refused(format!("{HEADER}0,,2,3,4\n"), (2, 2), &["nothing in `q1`"]);
    let text = format!("{HEADER}0,1,2,3,4\n0,1,2,3\n0,1,2,3\n");
    refused(text, (3, 5), &["2 of 3 rows", "4 fields instead of 5"]);
    refused(format!("{HEADER}0,\"1,2,3,4\n"), (2, 3), &["2 fields instead of 5"]);
    let long = "x".repeat(100_000);
    refused(format!("{HEADER}0,1,2,3,{long}\n"), (2, 5), &["is not a number"]);
    let gaps = "t,q1,tau1,a,b\n0,1,2,3,\n0,1,2,3,\n0,1,2,,3\n0,1,2,,3\n0,1,2,3,3\n";
    refused_by(&chain(1), gaps, (4, 4), &["4 of 5 rows", "`a`", "other_columns: Ignore"]);
}

#[test]
fn other_dialects() {
    refused(HEADER.replace(',', ";"), (1, 1), &["separated by ';'", "delimiter: ';'"]);
    refused(HEADER.replace(',', "\t"), (1, 1), &["separated by '\\t'", "delimiter: '\\t'"]);
    refused(HEADER.replace(',', " "), (1, 1), &["separated by ' '"]);
    refused(format!("{HEADER}0,0,1,5,2,5,3,5,4,5\n"), (2, 6), &["10 fields", "decimal commas"]);
    refused(format!("{HEADER}0,1,\"2,5\",3,4\n"), (2, 3), &["`2,5`", "decimal_comma: true"]);
    refused(format!("{HEADER}# begin\n# end\n0,1,2,3,4\n"), (2, 2), &["1 fields", "comment lines"]);
    refused(HEADER.replace('\n', "\r") + "0,1,2,3,4\r", (1, 18), &["carriage return"]);
}

#[test]
fn what_is_no_text() {
    refused(b"\xFF\xFEt\0,\0", (1, 1), &["UTF-16", "UTF-8"]);
    refused(b"t\0,\0q\x001\0\n\0", (1, 2), &["NUL byte", "UTF-16"]);
    refused(b"t,q\xE4,tau1\n0,1,2\n", (1, 4), &["not UTF-8"]);
    refused(b"\x7FELF\x02\x01\x01\0\0\0\n", (1, 5), &["control character"]);
    refused(b"PK\x03\x04......\n", (1, 1), &["Excel"]);
    refused(gzip(b"PAR1....\n"), (1, 1), &["Parquet"]);
    refused([HEADER.as_bytes(), b"0,1,2,3,\xFF\n"].concat(), (2, 5), &["is not a number"]);
    let noise: Vec<u8> = (0..100_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 23) as u8).collect();
    assert!(read(&noise, &chain(2)).is_err());
}

#[test]
fn broken_gzip() {
    let rows: String = (0..5000).map(|k| format!("{k},{},2,3,4\n", f64::from(k).sqrt())).collect();
    let packed = gzip(format!("{HEADER}{rows}").as_bytes());
    for cut in [packed.len() - 1, packed.len() - 9, packed.len() / 2] {
        let error = read(&packed[..cut], &chain(2)).expect_err("cut off").to_string();
        assert!(error.contains("cut off") && error.contains("help"), "{error}");
    }
    refused(&packed[..5], (1, 1), &["cut off"]);
    let mut damaged = packed.clone();
    let middle = damaged.len() / 2;
    damaged[middle..middle + 8].fill(0xA5);
    let error = read(&damaged, &chain(2)).expect_err("damaged").to_string();
    assert!(error.contains("damaged") || error.contains("rows are of no use"), "{error}");
}

/// Gzip members that repeat the same million blank lines, without ever standing in memory.
fn bomb(member: &[u8], members: u64) -> impl Read + '_ {
    let mut read = Box::new(std::io::empty()) as Box<dyn Read>;
    for _ in 0..members {
        read = Box::new(read.chain(member));
    }
    read
}

#[test]
fn gzip_bombs_are_defused() {
    let lines = gzip(&vec![b'\n'; 1 << 24]);
    let error = Log::from_reader(bomb(&lines, 300), "bomb.csv.gz", &chain(2), None).expect_err("a bomb");
    let message = error.to_string();
    assert!(message.contains("gzip bomb") && message.contains("unpacks to more than 64 MiB"), "{message}");
    let no_lines = gzip(&vec![b'0'; 1 << 24]);
    let error = Log::from_reader(bomb(&no_lines, 300), "bomb.csv.gz", &chain(2), None).expect_err("a bomb");
    assert!(error.message().contains("longer than"), "{error}");
}

#[test]
fn files_that_cannot_be_read() {
    let robot = chain(2);
    let absent = Log::open(fixture("absent.csv"), &robot, None).expect_err("no such file").to_string();
    assert!(absent.contains("absent.csv: cannot read the file"), "{absent}");
    let folder = Log::open(fixture(""), &robot, None).expect_err("a folder").to_string();
    assert!(folder.contains("a folder"), "{folder}");
}
