//! Names for what has none: wires between cells, bits that cross a boundary, variants of a module.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::super::Netlist;
use super::Module;
use super::flat::{Flat, Home};

/// The names of an instance's own parts, and new ones beside them.
pub(super) struct Names<'f, 'n> {
    flat: &'f Flat<'n>,
    used: HashSet<String>,
}

impl<'f, 'n> Names<'f, 'n> {
    pub(super) fn new(flat: &'f Flat<'n>, home: &Home) -> Names<'f, 'n> {
        let netlist = flat.netlist;
        let mut used: HashSet<String> = home.signals.iter().map(|&s| netlist.signal(s).name.clone()).collect();
        let scopes = home.blocks.iter().chain(&home.children);
        used.extend(scopes.map(|s| netlist.scopes()[s.index()].name.clone()));
        used.extend(home.cells.iter().map(|&c| netlist.cell(c).name.clone()));
        Names { flat, used }
    }

    /// A new name for what begins at a bit: the cell that drives it, and the pin unless the cell has but one.
    pub(super) fn of_bit(&mut self, bit: u32) -> String {
        let base = match self.flat.driver(bit) {
            Some((id, pin, _)) => {
                let cell = self.flat.netlist.cell(id);
                let name = cell.name.replace(['[', '.'], "_").replace(']', "");
                format!("{name}_{}", cell.kind.outputs()[pin as usize])
            }
            None => "in".to_owned(),
        };
        fresh(base, &mut self.used)
    }
}

/// A name that is not used yet.
fn fresh(base: String, used: &mut HashSet<String>) -> String {
    if used.insert(base.clone()) {
        return base;
    }
    let name = (2u32..).map(|n| format!("{base}_{n}")).find(|name| !used.contains(name)).unwrap_or(base);
    used.insert(name.clone());
    name
}

/// Gives the variants of a module names that tell them apart: by the parameters that differ, or else by numbers.
pub(super) fn name_modules(netlist: &Netlist, modules: &mut [Module]) {
    let mut variants: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (i, module) in modules.iter().enumerate() {
        variants.entry(&module.origin).or_default().push(i);
    }
    let parameters = |i: usize| &netlist.scopes()[modules[i].scope.index()].parameters;
    let mut named: HashMap<usize, String> = HashMap::new();
    let mut used: HashSet<String> = variants.keys().map(|&name| name.to_owned()).collect();
    let mut groups: Vec<&Vec<usize>> = variants.values().collect();
    groups.sort_by_key(|group| group[0]);
    for group in groups {
        // one variant has the name itself, and so has the top
        let varies = |k: &str| {
            let value = |i: usize| parameters(i).iter().find(|p| p.0 == k).map(|p| p.1);
            group.iter().any(|&i| value(i) != value(group[0]))
        };
        for &i in group {
            let tell = parameters(i).iter().filter(|p| varies(&p.0));
            let suffix: String = tell.map(|(k, v)| format!("_{k}{}", v.to_string().replace('-', "m"))).collect();
            let origin = &modules[i].origin;
            let name = match i == 0 || suffix.is_empty() && i == group[0] || group.len() == 1 {
                true => origin.clone(),
                false => fresh(format!("{origin}{suffix}"), &mut used),
            };
            named.insert(i, name);
        }
    }
    for (i, module) in modules.iter_mut().enumerate() {
        module.name = named.remove(&i).unwrap_or_default();
    }
}
