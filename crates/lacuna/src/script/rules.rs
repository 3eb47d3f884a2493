//! From all ways through a script to forms: a rule that differs from way to way becomes a choice.

use std::collections::BTreeMap;

use super::budget::TOO_LARGE;
use super::conic::{self, Cones, Naming};
use super::engine::{Limits, Machine};
use super::graph::{Graph, Id, Spot};
use super::paths::{Entry, Taken, Way, explore};
use super::tracer::{Demand, Relation};
use super::{Lowered, LoweredRule, Subject, trouble};
use crate::error::{Error, Result};
use crate::form::Form;

/// The same statement at the same turn of a loop, whichever way led to it.
type Key = (Spot, usize);

/// What a rule takes in the table of all ways, beside its relations \[bytes\].
const ROW: usize = 128;

struct Builder<'a> {
    machine: &'a Machine,
    cones: Cones,
    forms: Vec<Form>,
    rules: Vec<LoweredRule>,
    labels: BTreeMap<String, usize>,
}

/// Runs the calls and lowers what they state.
pub(super) fn lower(
    machine: &Machine,
    calls: &[Entry],
    subject: &Subject,
    stem: &str,
    limits: &Limits,
) -> Result<Lowered> {
    let (mut runs, mut rules_seen) = (0, 0);
    let mut builder = Builder {
        machine,
        cones: Cones::default(),
        forms: Vec::new(),
        rules: Vec::new(),
        labels: BTreeMap::new(),
    };
    for entry in calls {
        let ways = explore(machine, entry, limits, (&mut runs, &mut rules_seen))?;
        let prefix = entry.link.map_or_else(String::new, |i| format!("{}: ", subject.bodies[i].name));
        builder.add(&ways, &prefix, stem, limits)?;
    }
    if builder.forms.is_empty() {
        let (line, column) = calls.first().map_or((1, 1), |entry| machine.place(entry.function));
        return Err(Error::new("the script states no rule, whichever way it goes")
            .at(line, column)
            .help("return a list of rules; is the list of links empty?"));
    }
    Ok(Lowered { forms: builder.forms, rules: builder.rules, runs, settings: Default::default() })
}

/// Rules of a way by key.
fn keyed(way: &Way) -> Vec<(Key, &Relation)> {
    let mut turns: BTreeMap<Spot, usize> = BTreeMap::new();
    let key = |relation: &Relation| {
        let turn = turns.entry(relation.spot).or_default();
        *turn += 1;
        (relation.spot, *turn)
    };
    way.rules.iter().map(key).collect::<Vec<_>>().into_iter().zip(&way.rules).collect()
}

impl Builder<'_> {
    fn add(&mut self, ways: &[Way], prefix: &str, stem: &str, limits: &Limits) -> Result<()> {
        let mut order: Vec<Key> = Vec::new();
        let mut table: BTreeMap<Key, Vec<Option<&Relation>>> = BTreeMap::new();
        for (number, way) in ways.iter().enumerate() {
            self.machine.in_time(limits)?;
            for (key, relation) in keyed(way) {
                if !table.contains_key(&key) {
                    let room = ROW + size_of::<Option<&Relation>>() * ways.len();
                    let charged = self.machine.shared.borrow_mut().graph.charge(room);
                    charged.map_err(|what| trouble::stated(what).at(key.0.0, key.0.1))?;
                    order.push(key);
                }
                let row = table.entry(key).or_insert_with(|| vec![None; ways.len()]);
                row[number] = Some(relation);
            }
        }
        for key in order {
            let leaves = &table[&key];
            let (line, column) = key.0;
            self.machine.in_time(limits).map_err(|e| e.at(line, column))?;
            self.rule(ways, leaves, prefix, stem).map_err(|what| {
                let error = trouble::stated(what.clone()).at(line, column);
                let others = "`lacuna check` on the script shows its other rules";
                if what == TOO_LARGE { error } else { error.help(others) }
            })?;
        }
        Ok(())
    }

    fn rule(
        &mut self,
        ways: &[Way],
        leaves: &[Option<&Relation>],
        prefix: &str,
        stem: &str,
    ) -> Result<(), String> {
        let first = leaves.iter().flatten().next().ok_or("no way leads to this rule")?;
        let mut tracer = self.machine.shared.borrow_mut();
        let graph = &mut tracer.graph;
        let same = leaves.iter().all(|leaf| leaf.is_some_and(|r| r.demand == first.demand));
        let demand = if same {
            first.demand.clone()
        } else {
            let ids: Vec<Id> =
                leaves.iter().map(|leaf| margin(graph, *leaf, first)).collect::<Result<_, _>>()?;
            Demand::Margin(choice(graph, &ways.iter().map(|w| &w.taken).collect::<Vec<_>>(), &ids, 0)?)
        };
        let label = first.label.clone().unwrap_or_else(|| format!("{stem} line {}", first.spot.0));
        let label = self.unique(format!("{prefix}{label}"));
        let naming = naming(graph, first, &demand, label.clone());
        let forms = lowered(graph, &mut self.cones, &demand, &naming)?;
        if forms.iter().all(|f| f.support().is_empty()) {
            return Err("this rule depends on no unknown, so it restricts nothing".into());
        }
        let start = self.forms.len();
        self.forms.extend(forms);
        self.rules.push(LoweredRule { label, place: first.spot, forms: start..self.forms.len() });
        Ok(())
    }

    fn unique(&mut self, label: String) -> String {
        let count = self.labels.entry(label.clone()).or_default();
        *count += 1;
        if *count == 1 { label } else { format!("{label} [{count}]") }
    }
}

fn naming(graph: &Graph, stated: &Relation, demand: &Demand, label: String) -> Naming {
    let id = match demand {
        Demand::Margin(id) | Demand::Zero(id) => Some(*id),
        Demand::Psd { lower, .. } => lower.first().copied(),
    };
    let known = id.and_then(|id| graph.dimension(id)).map(|d| d.to_string());
    let unit = stated.unit.clone().or(known).filter(|u| !u.is_empty()).unwrap_or_else(|| "1".to_string());
    Naming { label, unit, scale: stated.scale }
}

/// The margin of a rule on one way; a rule that does not apply holds with its own bound to spare.
fn margin(graph: &mut Graph, leaf: Option<&Relation>, like: &Relation) -> Result<Id, String> {
    let Some(relation) = leaf else { return graph.constant(like.scale) };
    match &relation.demand {
        Demand::Margin(id) => Ok(*id),
        Demand::Zero(id) => {
            let other = graph.negative(*id)?;
            graph.least(*id, other)
        }
        Demand::Psd { lower, size } => graph.eigenvalue(lower, *size, 0),
    }
}

/// The node that takes the value of the way that the unknowns choose.
pub(super) fn choice(graph: &mut Graph, ways: &[&Taken], ids: &[Id], depth: usize) -> Result<Id, String> {
    let (Some(first), [one, rest @ ..]) = (ways.first(), ids) else {
        return Err("no way leads here".into());
    };
    if rest.iter().all(|id| id == one) {
        return Ok(*one);
    }
    let test = first.get(depth).ok_or("the script behaves differently from run to run")?.0;
    let split = ways.partition_point(|w| w.get(depth).is_some_and(|t| t.1));
    if split == 0 || split == ways.len() {
        return choice(graph, ways, ids, depth + 1);
    }
    let yes = choice(graph, &ways[..split], &ids[..split], depth + 1)?;
    let no = choice(graph, &ways[split..], &ids[split..], depth + 1)?;
    graph.choose(test, yes, no)
}

fn lowered(
    graph: &mut Graph,
    cones: &mut Cones,
    demand: &Demand,
    naming: &Naming,
) -> Result<Vec<Form>, String> {
    match demand {
        Demand::Margin(id) => conic::forms(graph, cones, *id, naming),
        Demand::Zero(id) => {
            let other = graph.negative(*id)?;
            let side = |sign: &str| Naming { label: format!("{} ({sign})", naming.label), ..naming.clone() };
            let mut all = conic::forms(graph, cones, *id, &side(">="))?;
            all.extend(conic::forms(graph, cones, other, &side("<="))?);
            Ok(all)
        }
        Demand::Psd { lower, size } => Ok(vec![conic::psd(graph, cones, lower, *size, naming)?]),
    }
}
