//! Where the cells and signals of a netlist stand in the file, and where they come from in the source that Yosys read.

use crate::diag::{FileId, Sources, Span};
use crate::netlist::{CellId, SignalId};

const NONE: u32 = u32::MAX;

/// Where everything stands; 20 bytes a cell and 8 a signal.
#[derive(Debug)]
pub struct Origins {
    file: FileId,
    /// For each cell of the file its name and its source, as offsets.
    cells: Vec<[u32; 4]>,
    /// For each cell of the netlist that of the file.
    of: Vec<u32>,
    signals: Vec<[u32; 2]>,
}

impl Origins {
    pub(super) fn new(file: FileId) -> Origins {
        Origins { file, cells: Vec::new(), of: Vec::new(), signals: Vec::new() }
    }

    pub(super) fn places(&self) -> u32 {
        self.cells.len() as u32
    }

    pub(super) fn add(&mut self, name: Span, source: Option<Span>) {
        let (start, end) = source.map_or((NONE, NONE), |s| (s.start, s.end));
        self.cells.push([name.start, name.end, start, end]);
    }

    pub(super) fn signal(&mut self, name: Span) {
        self.signals.push([name.start, name.end]);
    }

    /// The cells of the netlist up to here come from cell `at` of the file, as far as nothing else was said.
    pub(super) fn fill(&mut self, cells: usize, at: u32) {
        self.of.resize(cells, at);
    }

    fn cell(&self, cell: CellId) -> Option<&[u32; 4]> {
        self.cells.get(*self.of.get(cell.index())? as usize)
    }

    /// Where a cell stands in the file.
    #[must_use]
    pub fn of_cell(&self, cell: CellId) -> Option<Span> {
        self.cell(cell).map(|c| Span::new(self.file, c[0], c[1]))
    }

    /// Where a signal stands in the file.
    #[must_use]
    pub fn of_signal(&self, signal: SignalId) -> Option<Span> {
        self.signals.get(signal.index()).map(|s| Span::new(self.file, s[0], s[1]))
    }

    /// Where a cell comes from in the source that Yosys read: `cpu.v:12.3-14.8`.
    #[must_use]
    pub fn source<'s>(&self, cell: CellId, sources: &'s Sources) -> Option<&'s str> {
        let c = self.cell(cell).filter(|c| c[2] != NONE)?;
        Some(sources.slice(Span::new(self.file, c[2], c[3])))
    }
}
