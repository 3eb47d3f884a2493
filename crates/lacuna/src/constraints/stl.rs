//! Corner points of an STL mesh, ASCII or binary.

use nalgebra::Vector3;

use crate::error::{Error, Result};

/// Bytes before the first triangle of a binary file: header and count.
const HEADER: usize = 84;
/// Bytes of one triangle of a binary file: normal, three corners, attribute.
const TRIANGLE: usize = 50;

/// The corners of all triangles, in the file's unit and order, repeated as often as they stand there.
///
/// # Errors
/// When the bytes are no STL, a number is not finite, or the triangle count does not fit the size; with line
/// and column for ASCII.
pub(super) fn corners(bytes: &[u8]) -> Result<Vec<Vector3<f64>>> {
    let count = bytes.get(80..HEADER).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let promised = count.map(|n| HEADER as u64 + TRIANGLE as u64 * u64::from(n));
    // Binary files may begin with "solid" too, so the size decides first.
    if let (Some(count), Some(promised)) = (count, promised)
        && promised == bytes.len() as u64
    {
        return binary(&bytes[HEADER..], count);
    }
    let text = std::str::from_utf8(bytes).ok();
    if let Some(text) = text.filter(|t| t.trim_start().starts_with("solid")) {
        return ascii(text);
    }
    match (count, promised) {
        (Some(count), Some(promised)) => Err(Error::new(format!(
            "the file says that it has {count} triangles, which take {promised} bytes, but it has {} bytes",
            bytes.len()
        ))
        .help("the mesh is cut off or damaged, or no STL: export it again")),
        _ => Err(Error::new(format!("{} bytes are too few for an STL mesh", bytes.len()))
            .help("the file is cut off, or no STL: export it again")),
    }
}

fn binary(triangles: &[u8], count: u32) -> Result<Vec<Vector3<f64>>> {
    if count == 0 {
        return Err(empty());
    }
    let mut corners = Vec::with_capacity(3 * count as usize);
    for (number, triangle) in triangles.chunks_exact(TRIANGLE).enumerate() {
        let number_at = |i: usize| {
            let bytes = [triangle[i], triangle[i + 1], triangle[i + 2], triangle[i + 3]];
            f64::from(f32::from_le_bytes(bytes))
        };
        for corner in 1..4 {
            let x = Vector3::from_fn(|axis, _| number_at(12 * corner + 4 * axis));
            if x.iter().any(|x| !x.is_finite()) {
                let text = format!("corner {corner} of triangle {} is not finite", number + 1);
                return Err(Error::new(text).help("the mesh is damaged: export it again"));
            }
            corners.push(x);
        }
    }
    Ok(corners)
}

fn ascii(text: &str) -> Result<Vec<Vector3<f64>>> {
    let mut corners = Vec::new();
    let mut closed = false;
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("vertex") => {
                let x: Vec<f64> =
                    words.filter_map(|w| w.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
                let column = 1 + line.len() - line.trim_start().len();
                if x.len() != 3 || line.split_whitespace().count() != 4 {
                    return Err(Error::new("a vertex is not three finite numbers").at(number + 1, column));
                }
                corners.push(Vector3::new(x[0], x[1], x[2]));
            }
            Some("endsolid") => closed = true,
            _ => {}
        }
    }
    if corners.is_empty() {
        return Err(empty());
    }
    if !closed || !corners.len().is_multiple_of(3) {
        return Err(Error::new("the mesh ends in the middle")
            .at(text.lines().count(), 1)
            .help("an ASCII STL ends with `endsolid`: export it again"));
    }
    Ok(corners)
}

fn empty() -> Error {
    Error::new("the mesh has no triangles").help("export it again")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary_file(corners: &[[f32; 3]], claimed: u32) -> Vec<u8> {
        let mut bytes = b"solid but binary all the same".to_vec();
        bytes.resize(80, b' ');
        bytes.extend(claimed.to_le_bytes());
        for triangle in corners.chunks_exact(3) {
            bytes.extend([0; 12]);
            triangle.iter().flatten().for_each(|x| bytes.extend(x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.25], [0.0, -2.0, 0.5]];

    #[test]
    fn both_kinds_give_the_same_corners() {
        let text = "solid part\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 2.5e-1\n   \
                    vertex 0 -2 0.5\n  endloop\n endfacet\nendsolid part\n";
        let expected = CORNERS.map(|c| Vector3::from(c.map(f64::from))).to_vec();
        assert_eq!(corners(text.as_bytes()), Ok(expected.clone()));
        assert_eq!(corners(&binary_file(&CORNERS, 1)), Ok(expected));
    }

    #[test]
    fn a_count_that_lies_is_found_without_allocating_for_it() {
        let error = corners(&binary_file(&CORNERS, u32::MAX)).expect_err("refused");
        assert!(error.message().contains("4294967295 triangles"), "{error}");
        assert!(corners(&binary_file(&CORNERS, 0)).is_err());
    }

    #[test]
    fn damaged_files_are_refused_with_their_place() {
        let message = |bytes: &[u8]| corners(bytes).expect_err("refused").to_string();
        assert!(message(b"").contains("0 bytes are too few"));
        assert!(message(b"solid x\nendsolid x\n").contains("no triangles"));
        assert!(message(b"solid x\n  vertex 1 2 inf\nendsolid").contains(":2:3"));
        assert!(
            message(b"solid x\nvertex 1 2 3\nvertex 1 2 3\nvertex 3 4 5\n").contains("ends in the middle")
        );
        let mut nan = CORNERS;
        nan[1][2] = f32::NAN;
        assert!(message(&binary_file(&nan, 1)).contains("corner 2 of triangle 1"));
    }
}
