//! The comparison as a whole, and how it is written.

use std::fmt::{self, Write as _};

use serde::Serialize;

use super::motion::Speed;
use super::{Claim, Equipment, MEASURES, Motion, Sample, SetKind};

/// What was measured.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Comparison {
    /// Bits of a coordinate.
    pub bits: u32,
    /// If not all segments were drawn.
    pub sample: Option<Sample>,
    /// The circuits.
    pub equipment: Vec<Equipment>,
    /// How the methods draw, by what they draw.
    pub groups: Vec<Group>,
    /// What the documents say.
    pub claims: Vec<Claim>,
}

/// Methods that drew the same segments.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Group {
    /// The kind of segments.
    pub kind: SetKind,
    /// Which segments.
    pub set: String,
    /// The methods.
    pub rows: Vec<Row>,
}

/// A method and how it draws.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Row {
    /// The method with its options.
    pub method: String,
    /// What was measured.
    #[serde(flatten)]
    pub motion: Motion,
}

/// Rows of cells under a header; the first column is text, the others are numbers unless `text` says otherwise.
struct Table {
    head: Vec<&'static str>,
    rows: Vec<Vec<String>>,
    /// All columns are text.
    text: bool,
}

impl Comparison {
    /// As a page of Markdown, with the definitions.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut page = String::from("# The methods compared\n\n");
        let _ = writeln!(page, "<!-- made by `discreta compare --bits {} --format markdown` -->\n", self.bits);
        let _ = writeln!(page, "{}\n\n## What the documents claim\n", self.about());
        page += &self.claims_table().markdown();
        page += "\n## The circuits\n\n";
        page += &self.equipment_table().markdown();
        for group in &self.groups {
            let _ = writeln!(page, "\n## {}\n\n{}\n", group.title(), group.set);
            page += &group.table().markdown();
        }
        page += "\n## The measures\n\n| measure | |\n|---|---|\n";
        for (name, meaning) in MEASURES {
            let _ = writeln!(page, "| {name} | {meaning} |");
        }
        page
    }

    fn about(&self) -> String {
        format!(
            "Document C closes with a comparison of methods by equipment, accuracy, simplicity and speed, in words. Here \
             it is measured: the circuits of `circuits/` with coordinates of {0} bits are counted, and every method draws \
             with registers of {0} bits, from what is said below to the last segment.",
            self.bits
        )
    }

    fn claims_table(&self) -> Table {
        let rows = self.claims.iter().map(|c| {
            let holds = match c.holds {
                Some(true) => "true",
                Some(false) => "**false**",
                None => "–",
            };
            vec![c.claim.clone(), c.source.to_owned(), c.measured.clone(), holds.to_owned()]
        });
        Table { head: vec!["claim", "where", "measured", "holds"], rows: rows.collect(), text: true }
    }

    fn equipment_table(&self) -> Table {
        let rows = self.equipment.iter().map(|e| {
            let mut row =
                vec![e.method.clone(), e.elements.to_string(), e.adders.to_string(), e.adder_bits.to_string()];
            match &e.gates {
                Some(g) => {
                    row.extend([g.gates, g.inverters, g.flip_flops, u64::from(g.depth)].map(|n| n.to_string()));
                }
                None => row.extend(["no all-gates form", "", "", ""].map(str::to_owned)),
            }
            row
        });
        let head = ["method", "elements", "adders", "their bits", "gates", "inverters", "flip-flops", "depth"];
        Table { head: head.to_vec(), rows: rows.collect(), text: false }
    }
}

/// For people, without the definitions.
impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "What the documents claim\n\n{}", self.claims_text())?;
        writeln!(f, "The circuits, {} bits\n\n{}", self.bits, self.equipment_table().text())?;
        for group in &self.groups {
            writeln!(f, "{}\n\n  {}\n\n{}", group.title(), group.set, group.table().text())?;
        }
        Ok(())
    }
}

impl Comparison {
    fn claims_text(&self) -> String {
        let mut text = String::new();
        for c in &self.claims {
            let holds = match c.holds {
                Some(true) => "true ",
                Some(false) => "FALSE",
                None => "  –  ",
            };
            let _ = writeln!(text, "  {holds}  {}\n         {}", c.claim, c.measured);
        }
        text
    }
}

impl Group {
    fn title(&self) -> &'static str {
        match self.kind {
            SetKind::Lines => "Lines",
            SetKind::Quarters => "Quarter circles",
            SetKind::Arcs => "Arcs with rounded ends",
            SetKind::Circles => "Full circles",
            SetKind::Space => "Lines in space",
        }
    }

    fn table(&self) -> Table {
        let speeds = self.rows.iter().any(|r| r.motion.speed.is_some());
        let mut head = vec!["method", "clocks, mean", "most", "deviation +", "−", "mean"];
        let longer = self.rows.iter().any(|r| r.motion.speed_141.is_some());
        let functions = self.rows.iter().any(|r| r.motion.f_wrong.is_some());
        if speeds {
            head.extend(["speed", "ratio"]);
        }
        if longer {
            head.extend(["×1.41", "ratio"]);
        }
        head.push("end exact");
        if functions {
            head.push("F wrong");
        }
        let rows = self.rows.iter().map(|r| {
            let m = &r.motion;
            let mut row = vec![r.method.clone(), format!("{:.1}", m.clocks.mean), m.clocks.most.to_string()];
            let d = &m.deviation;
            row.extend([d.outside, d.inside.abs(), d.mean].map(|v| format!("{v:.3}")));
            if speeds {
                row.extend(speed(m.speed));
            }
            if longer {
                row.extend(speed(m.speed_141));
            }
            row.push(ends(m));
            if functions {
                row.push(m.f_wrong.map_or_else(String::new, |n| n.to_string()));
            }
            row
        });
        Table { head, rows: rows.collect(), text: false }
    }
}

/// From where to where, and how many times.
fn speed(speed: Option<Speed>) -> [String; 2] {
    speed.map_or_else(Default::default, |s| [format!("{:.3}…{:.3}", s.least, s.greatest), format!("{:.3}", s.ratio)])
}

fn ends(m: &Motion) -> String {
    let mut text = format!("{} of {}", m.exact, m.segments);
    if m.exact < m.segments {
        let _ = write!(text, ", up to {:.1} BLU off", m.end_error);
    }
    if m.unfinished > 0 {
        let _ = write!(text, "; {} without end", m.unfinished);
    }
    text
}

impl Table {
    fn markdown(&self) -> String {
        let mut text = format!("| {} |\n|---|", self.head.join(" | "));
        for _ in 1..self.head.len() {
            text += if self.text { "---|" } else { "---:|" };
        }
        text.push('\n');
        for row in &self.rows {
            let _ = writeln!(text, "| {} |", row.join(" | "));
        }
        text
    }

    /// Columns as wide as what is in them.
    fn text(&self) -> String {
        let width = |i: usize| {
            let cells = self.rows.iter().map(|row| row[i].chars().count());
            cells.chain([self.head[i].chars().count()]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.head.len()).map(width).collect();
        let mut text = String::new();
        let head: Vec<String> = self.head.iter().map(|&h| h.to_owned()).collect();
        for row in [&head].into_iter().chain(&self.rows) {
            let mut line = format!("  {:<w$}", row[0], w = widths[0]);
            for (cell, width) in row.iter().zip(&widths).skip(1) {
                let _ = write!(line, "  {cell:>width$}");
            }
            text += line.trim_end();
            text.push('\n');
        }
        text
    }
}
