//! Counts over many examinations.

use serde::Serialize;

use super::Examination;
use super::judge::Mark;

/// Counts of one part of the examination.
#[derive(Debug, Clone, Serialize)]
pub struct Table {
    /// The part.
    pub part: String,
    /// Data sets that were judged.
    pub sets: usize,
    /// Draws that could not be made.
    pub excluded: usize,
    /// Data sets with at least one answer.
    pub answered: usize,
    /// First answer right.
    pub first: usize,
    /// Right answer among the first three.
    pub among_three: usize,
    /// First answer on the right joint.
    pub joint: usize,
    /// Outside the catalogue: joint and variable right.
    pub variable: usize,
    /// Outside the catalogue, where a formula can express it: the exact term.
    pub exact: usize,
    /// Hidden effects, and how many were named.
    pub hidden: usize,
    /// Of these named.
    pub named: usize,
    /// Answers that name nothing hidden.
    pub extras: usize,
    /// Data sets with such an answer.
    pub with_extras: usize,
    /// Median over the sets of the unseen error before, over that with nothing hidden.
    pub before: Option<f64>,
    /// The same after.
    pub after: Option<f64>,
    /// The worst tenth after.
    pub after_worst_tenth: Option<f64>,
}

/// One table per part, in the order of first appearance.
pub fn tables(all: &[Examination]) -> Vec<Table> {
    let mut parts: Vec<&str> = Vec::new();
    for one in all {
        if !parts.contains(&one.part.as_str()) {
            parts.push(&one.part);
        }
    }
    parts.iter().map(|part| table(part, all)).collect()
}

fn table(part: &str, all: &[Examination]) -> Table {
    let own: Vec<&Examination> = all.iter().filter(|e| e.part == part).collect();
    let marks: Vec<&Mark> = own.iter().filter_map(|e| e.mark.as_ref()).collect();
    let count = |which: &dyn Fn(&Mark) -> bool| marks.iter().filter(|m| which(m)).count();
    let sum = |which: &dyn Fn(&Mark) -> usize| marks.iter().map(|m| which(m)).sum();
    let values = |which: &dyn Fn(&Mark) -> f64| -> Vec<f64> {
        let mut list: Vec<f64> = marks.iter().map(|m| which(m)).filter(|x| x.is_finite()).collect();
        list.sort_by(f64::total_cmp);
        list
    };
    let (before, after) = (values(&|m| m.before), values(&|m| m.after));
    let at = |list: &[f64], part: f64| list.get((part * list.len() as f64) as usize).copied();
    Table {
        part: part.to_string(),
        sets: marks.len(),
        excluded: own.iter().filter(|e| e.excluded.is_some()).count(),
        answered: count(&|m| !m.answers.is_empty()),
        first: count(&|m| m.first),
        among_three: count(&|m| m.among_three),
        joint: count(&|m| m.joint),
        variable: count(&|m| m.variable),
        exact: count(&|m| m.exact),
        hidden: sum(&|m| m.hidden.len()),
        named: sum(&|m| m.named),
        extras: sum(&|m| m.extras),
        with_extras: count(&|m| m.extras > 0),
        before: at(&before, 0.5),
        after: at(&after, 0.5),
        after_worst_tenth: at(&after, 0.9),
    }
}

impl Table {
    /// The table as lines for people, at most 80 columns.
    pub fn text(&self) -> String {
        let mut text = format!("{}: {} data sets", self.part, self.sets);
        if self.excluded > 0 {
            text += &format!(", {} draws excluded", self.excluded);
        }
        text += "\n";
        let mut line = |what: &str, count: usize, of: usize| {
            if of > 0 {
                let (low, high) = interval(count, of);
                text += &format!(
                    "  {what:<34} {count:>4} of {of:<4} {:>5.1} %   [{:.0}, {:.0}] %\n",
                    100.0 * count as f64 / of as f64,
                    100.0 * low,
                    100.0 * high
                );
            }
        };
        if self.hidden == 0 {
            line("sets with a false alarm", self.answered, self.sets);
        } else {
            line("first answer right", self.first, self.sets);
            line("right one among the first three", self.among_three, self.sets);
            line("first answer on the right joint", self.joint, self.sets);
            line("hidden effects that were named", self.named, self.hidden);
            line("sets with an answer too many", self.with_extras, self.sets);
        }
        if self.variable > 0 || self.part == super::Part::Outside.name() {
            line("joint and variable right", self.variable, self.sets);
            line("exact term first", self.exact, self.sets);
        }
        if let (Some(before), Some(after), Some(worst)) = (self.before, self.after, self.after_worst_tenth) {
            text += &format!(
                "  unseen log, error over that with nothing hidden, median: \n    {before:.2} before, {after:.3} after (worst tenth {worst:.2})\n"
            );
        }
        text
    }
}

/// Wilson's 95 % interval of a proportion (Wilson 1927).
fn interval(count: usize, of: usize) -> (f64, f64) {
    const Z: f64 = 1.959_963_984_540_054;
    let (n, p) = (of as f64, count as f64 / of as f64);
    let middle = p + Z * Z / (2.0 * n);
    let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    let whole = 1.0 + Z * Z / n;
    (((middle - half) / whole).max(0.0), ((middle + half) / whole).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::interval;

    #[test]
    fn wilson_of_published_values() {
        // Newcombe 1998 (Statistics in Medicine 17, 857), table I: 81 of 263, and 0 of 20.
        let (low, high) = interval(81, 263);
        assert!((low - 0.2553).abs() < 5e-5 && (high - 0.3662).abs() < 5e-5, "{low} {high}");
        let (low, high) = interval(0, 20);
        assert!(low.abs() < 1e-12 && (high - 0.1611).abs() < 5e-5, "{high}");
    }
}
