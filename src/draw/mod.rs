//! The schematic of a netlist as SVG: standard symbols from left to right, instances as boxes or opened, orthogonal wires.
//!
//! `graph` makes nodes, pins and nets of a module's body, `symbol` knows what a node looks like, `layout` has ELK's
//! layered algorithm place nodes and route wires (docs/decisions/0007-elk-lays-out-schematics.md), `paint` writes SVG.
//! This room knows netlists; it knows neither engines nor waveforms nor files.
//!
//! # What a program may rely on in the SVG
//!
//! The picture is a plain file and can as well be put into a page, where a program finds what to colour and to label:
//!
//! | element | attributes | is |
//! |---|---|---|
//! | `svg.schematic` | `data-top`, `data-scope` | the whole; `data-top` is the top scope of a waveform, `data-scope` the path below it of the instance that is drawn (without it: the top itself) |
//! | `g.cell` | `id="cell:PATH"`, `data-cell="PATH"`, `data-kind` | a cell: `register`, `and`, …; `memory[7:0]` is the cells `memory[0]` to `memory[7]` side by side, drawn as one |
//! | `g.instance` | `id="cell:PATH"`, `data-cell="PATH"`, `data-module`, and class `open` | an instance of a module; `open` if its inside is drawn in it |
//! | `g.port` | `id="port:PATH"`, `data-port="PATH"`, `data-net`, `data-direction` | a port of the drawn module, or of an opened instance: `input`, `output`, `inout` |
//! | `g.bar` | `data-kind` | `join`, `split` or `repeat`: bits put together or taken apart |
//! | `g.net` | `id="net:NAME"`, `data-net`, `data-bits`, `data-width`, and class `bus` if wider than 1 | a wire with all its branches, dots and labels |
//! | `g.pin` | `data-pin`, `data-at="X Y"` | where a cell, instance, port or bar is connected |
//! | `text.value` | | within `g.net`: an empty text near what drives the wire, for a program to fill |
//!
//! `data-net` is the path of a signal below the top, as `--trace` and waveforms have it without the top scope: `f`,
//! `adder.fa[3].s`. `data-bits` says which of its bits the wire carries: `8:0`, `8`, always by place, 0 the lowest. What
//! no signal shows has no `data-net` but `data-driver="CELL.PIN"`. An `id` is `net:` and the name, with `[bits]` if these
//! are not the whole signal, and `~2`, `~3`… where a wire is drawn in several places; every place has `data-net`.
//! A net that is drawn by its name at both ends (a clock, a reset) is one `g.net` with a `text.label` at each end.
//! A constant at a pin has `data-constant` as it is written (`1`, `8'hff`) and neither of the others.
//!
//! Colours are custom properties on `svg.schematic`, which a page can set: `--paper`, `--ink`, `--wire`, `--bus`,
//! `--fill`, `--soft`, `--accent`. All names of classes mean something only within `svg.schematic`. Coordinates are pixels
//! from the top left corner, whole or half; all that is drawn is in absolute coordinates, there is no `transform`.

mod array;
mod graph;
mod layout;
mod paint;
mod pins;
mod scene;
mod symbol;
mod wire;

use crate::netlist::{Hierarchy, Netlist};

/// The most cells and instances that are drawn; beyond it a picture helps nobody.
pub const MOST: usize = 2_000;

/// What is drawn.
#[derive(Clone, Copy, Default, Debug)]
pub struct Options<'a> {
    /// How many levels of instances are opened: 0 draws each as a box.
    pub depth: usize,
    /// The module, by its name in the circuit; the top without one.
    pub module: Option<&'a str>,
}

/// Why there is no drawing.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Refusal {
    /// There is no such module; these there are.
    NoModule(Vec<String>),
    /// So many cells and instances would be drawn.
    TooLarge(usize),
    /// The layout failed.
    Layout(String),
    /// The crate was built without its feature `draw`.
    NotBuilt,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Refusal::NoModule(_) => f.write_str("there is no such module"),
            Refusal::TooLarge(count) => write!(f, "{count} cells are too many for one drawing: {MOST} at most"),
            Refusal::Layout(why) => write!(f, "the drawing could not be laid out: {why}"),
            Refusal::NotBuilt => f.write_str("this build cannot draw: it has no layout"),
        }
    }
}

impl std::error::Error for Refusal {}

/// The schematic of a netlist, as SVG; the same netlist gives the same bytes.
///
/// # Errors
/// A module that is not there, or more cells than a picture can show.
///
/// ```
/// # #[cfg(feature = "draw")] {
/// use discreta::draw::{Options, svg};
/// let circuit = discreta::circuit::load("circuits/evaluation/line.json")?;
/// let picture = svg(&circuit.netlist, &Options::default())?;
/// assert!(picture.contains("data-cell=\"adder\""));
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn svg(netlist: &Netlist, options: &Options<'_>) -> Result<String, Refusal> {
    let hierarchy = Hierarchy::of(netlist);
    let modules = hierarchy.modules();
    let module = match options.module {
        None => 0,
        Some(name) => {
            let exact = modules.iter().position(|m| m.name == name);
            let named = exact.or_else(|| modules.iter().position(|m| m.origin == name));
            named.ok_or_else(|| Refusal::NoModule(modules.iter().map(|m| m.name.clone()).collect()))?
        }
    };
    let count = count(&hierarchy, module, options.depth);
    if count > MOST {
        return Err(Refusal::TooLarge(count));
    }
    let placed = layout::Layout::new(netlist, &hierarchy).place(module, options.depth)?;
    Ok(paint::svg(netlist, &modules[module], &placed))
}

/// How many levels of instances are below each module.
fn heights(hierarchy: &Hierarchy) -> Vec<usize> {
    let modules = hierarchy.modules();
    let mut heights = vec![0; modules.len()];
    // a module comes before those that it has instances of
    for (m, module) in modules.iter().enumerate().rev() {
        heights[m] = module.instances.iter().map(|i| 1 + heights[i.module]).max().unwrap_or(0);
    }
    heights
}

/// How many cells and instances a drawing shows.
fn count(hierarchy: &Hierarchy, module: usize, depth: usize) -> usize {
    let modules = hierarchy.modules();
    let own = |m: usize| modules[m].cells.len() + modules[m].instances.len();
    let mut counts: Vec<usize> = (0..modules.len()).map(own).collect();
    for _ in 0..depth.min(heights(hierarchy)[module]) {
        let opened =
            |m: usize| modules[m].instances.iter().map(|i| counts[i.module]).fold(own(m), usize::saturating_add);
        counts = (0..modules.len()).map(opened).collect();
    }
    counts[module]
}
