//! No bytes make the reader panic, and what it accepts is what a naive reader finds.

use super::*;
use lacuna::log::StaticPoses;
use proptest::prelude::*;

/// Rows of a comma-separated text without quotes, as a beginner would read them: `(good rows, all rows)`.
fn naive(body: &[u8], columns: usize) -> (Vec<Vec<f64>>, usize) {
    let mut good = Vec::new();
    let mut all = 0;
    for line in body.split(|b| *b == b'\n').filter(|line| !line.trim_ascii().is_empty()) {
        all += 1;
        let numbers: Vec<f64> = String::from_utf8_lossy(line)
            .split(',')
            .filter_map(|field| field.trim_matches([' ', '\t', '\r', '\u{c}']).parse().ok())
            .filter(|x: &f64| x.is_finite())
            .collect();
        if numbers.len() == columns && line.iter().filter(|b| **b == b',').count() + 1 == columns {
            good.push(numbers);
        }
    }
    (good, all)
}

fn agrees(body: &[u8]) -> Result<(), TestCaseError> {
    let (good, all) = naive(body, 3);
    let text = [b"t,q1,tau1\n", body].concat();
    match read(&text, &chain(1)) {
        Ok(log) => {
            let rows: Vec<Vec<f64>> =
                (0..log.rows()).map(|k| vec![log.t[k], log.q[0][k], log.tau[0][k]]).collect();
            prop_assert_eq!(format!("{:?}", rows), format!("{good:?}"));
            let dropped: usize = log.dropped.values().map(|d| d.rows).sum();
            prop_assert_eq!(rows.len() + dropped, all);
        }
        Err(e) => prop_assert!(all == 0 || 2 * good.len() < all, "refused without need: {e}"),
    }
    Ok(())
}

/// Fields that are easy to get wrong, and ordinary numbers.
fn field() -> impl Strategy<Value = String> {
    prop_oneof![
        8 => any::<f64>().prop_map(|x| format!("{x}")),
        8 => any::<f64>().prop_map(|x| format!("{x:e}")),
        4 => any::<i32>().prop_map(|x| x.to_string()),
        1 => prop::sample::select(vec![
            "", " ", ".5", "5.", "+1", "1_0", "0x1", "-", "e5", "1e", "nan", "Infinity", " 7 ", "\r", "1e400",
            "179769313486231580793728971405303415079934132710037826936173778980444968292764750946649017977587", "\u{a0}1",
        ]).prop_map(str::to_owned),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400), packed: bool) {
        let text = if packed { gzip(&bytes) } else { bytes };
        for map in ["()", "(delimiter: ' ', header: false, time: (rate_hz: 1), position: (columns: [1]), torque: (columns: [2]))"] {
            // Success is as fine as an error; only a panic would fail.
            let _ = read_mapped(&text, &chain(1), map);
        }
    }

    #[test]
    fn any_text_is_a_map_or_none(text in "[ -~]{0,60}", place in any::<prop::sample::Index>(), byte in b' '..b'~') {
        let _ = ColumnMap::parse(&text);
        let mut map = include_str!("../../columns/ur_rtde.ron").to_owned().into_bytes();
        let place = place.index(map.len());
        map[place] = byte;
        let map = String::from_utf8(map).expect("the map is ASCII");
        if let Ok(map) = ColumnMap::parse(&map) {
            let _ = Log::open(fixture("ur_rtde.csv"), &chain(6), Some(&map));
        }
    }

    #[test]
    fn any_poses_are_read_or_refused(body in prop::collection::vec(any::<u8>(), 0..200)) {
        let text = [b"q1,g1,m11\n", body.as_slice()].concat();
        if let Ok(poses) = StaticPoses::from_reader(text.as_slice(), "poses", &chain(1)) {
            prop_assert!(poses.g[0].iter().chain(&poses.m[0]).all(|x| x.is_finite()));
        }
    }

    #[test]
    fn damaged_gzip_is_read_or_refused(place: prop::sample::Index, byte: u8, cut: prop::sample::Index) {
        let mut packed = gzip(&b"t,q1,tau1\n0,1,2\n1,2,3\n".repeat(20));
        let place = place.index(packed.len());
        packed[place] = byte;
        packed.truncate(1 + cut.index(packed.len()));
        let _ = read(&packed, &chain(1));
    }

    #[test]
    fn tables_of_odd_fields(rows in prop::collection::vec(prop::collection::vec(field(), 2..=4), 0..12), end: bool) {
        let lines: Vec<String> = rows.iter().map(|r| r.join(",")).collect();
        agrees((lines.join("\n") + if end { "\n" } else { "" }).as_bytes())?;
    }

    #[test]
    fn mutated_tables(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3_u8), 1..8)) {
        let mut text: Vec<u8> =
            (0..8).flat_map(|k| format!("{k},{},{}\n", 0.1 * f64::from(k), 1.0 / f64::from(k + 3)).into_bytes()).collect();
        for (place, byte, action) in edits {
            let place = place.index(text.len());
            // Quotes are beyond the naive reader.
            let byte = if byte == b'"' { b',' } else { byte };
            match action {
                0 => text[place] = byte,
                1 => text.insert(place, byte),
                _ => { text.remove(place); }
            }
        }
        agrees(&text)?;
    }

    #[test]
    fn quoted_tables_read_like_bare_ones(rows in prop::collection::vec((any::<i32>(), any::<i32>(), any::<i32>()), 1..9)) {
        let bare: String = rows.iter().map(|(a, b, c)| format!("{a},{b},{c}\n")).collect();
        let quoted: String = rows.iter().map(|(a, b, c)| format!("\"{a}\",{b},\"{c}\"\n")).collect();
        let [bare, quoted] = [bare, quoted].map(|body| read(format!("t,q1,tau1\n{body}"), &chain(1)));
        prop_assert_eq!(bare, quoted);
    }
}
