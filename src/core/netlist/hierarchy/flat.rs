//! The flat netlist seen from its instances: which bits are one wire, who drives them, where they are present, and
//! which of them cross the boundary of an instance.

use std::collections::HashMap;

use super::super::{CellId, Direction, Driver, NetId, Netlist, ScopeId, SignalId, Slice};
use crate::Logic;
use crate::cell::CellKind;

/// No scope.
const NONE: u32 = u32::MAX;
/// Outside of the circuit.
const OUTSIDE: u32 = u32::MAX - 1;

/// What stands in an instance.
#[derive(Default)]
pub(super) struct Home {
    /// The blocks' scopes, the instance's own first.
    pub blocks: Vec<ScopeId>,
    /// Those that are ports first.
    pub signals: Vec<SignalId>,
    /// How many of the signals are ports.
    pub ports: usize,
    /// Which way each port goes indeed.
    pub ways: Vec<Direction>,
    pub cells: Vec<CellId>,
    /// The scopes of the instances within.
    pub children: Vec<ScopeId>,
    /// Bits that cross the boundary without a port, in runs that go one way, and whether that is inwards.
    pub crossing: Vec<(Vec<u32>, bool)>,
}

pub(super) struct Flat<'n> {
    pub netlist: &'n Netlist,
    /// The number of each net's bit 0, and after the last how many there are.
    start: Vec<u32>,
    /// The net of each bit.
    net: Vec<NetId>,
    /// For bits that share a wire the one that stands for it.
    shared: HashMap<u32, u32>,
    /// The homes of all that drives a shared bit.
    sharers: HashMap<u32, Vec<u32>>,
    /// Whether a net is a constant that belongs nowhere: written out wherever it is used.
    literal: Vec<bool>,
    /// The home of what drives each net.
    driver: Vec<u32>,
    /// The instance that each scope belongs to.
    home_of: Vec<u32>,
    /// The place of each scope among the blocks of its home.
    pub block_of: Vec<u32>,
    /// The home around each home, by scope.
    up: Vec<u32>,
    depth: Vec<u32>,
    /// The numbers of a home's first descendant and of the first that is none, by scope.
    interval: Vec<(u32, u32)>,
    pub homes: Vec<Home>,
    /// The innermost instance in which all of a bit's uses are.
    around: Vec<u32>,
}

impl<'n> Flat<'n> {
    pub(super) fn new(netlist: &'n Netlist) -> Flat<'n> {
        let mut start = vec![0u32];
        for net in netlist.nets() {
            start.push(start[start.len() - 1] + net.width);
        }
        let scopes = netlist.scopes().len();
        let mut flat = Flat {
            netlist,
            start,
            net: netlist.net_ids().flat_map(|n| std::iter::repeat_n(n, netlist.net(n).width as usize)).collect(),
            shared: HashMap::new(),
            sharers: HashMap::new(),
            literal: netlist.net_ids().map(|net| is_literal(netlist, net)).collect(),
            driver: Vec::new(),
            home_of: vec![0; scopes],
            block_of: vec![0; scopes],
            up: vec![NONE; scopes],
            depth: vec![0; scopes],
            interval: vec![(0, 0); scopes],
            homes: (0..scopes).map(|_| Home::default()).collect(),
            around: Vec::new(),
        };
        flat.settle_scopes();
        flat.driver = netlist
            .nets()
            .iter()
            .map(|net| match net.driver {
                Driver::Cell(cell, _) => flat.home_of[netlist.cell(cell).scope.index()],
                Driver::Input(_) => OUTSIDE,
            })
            .collect();
        flat.share();
        flat.settle_members();
        flat.locate();
        flat.direct();
        flat.cross();
        flat
    }

    fn settle_scopes(&mut self) {
        let scopes = self.netlist.scopes();
        for (i, scope) in scopes.iter().enumerate() {
            let parent = scope.parent.map_or(NONE, |p| self.home_of[p.index()]);
            if scope.module.is_some() || parent == NONE {
                self.home_of[i] = i as u32;
                self.up[i] = parent;
                if parent != NONE {
                    self.depth[i] = self.depth[parent as usize] + 1;
                    self.homes[parent as usize].children.push(ScopeId::new(i));
                }
            } else {
                self.home_of[i] = parent;
            }
            let home = self.home_of[i] as usize;
            self.block_of[i] = self.homes[home].blocks.len() as u32;
            self.homes[home].blocks.push(ScopeId::new(i));
        }
        // sizes of the subtrees, then numbers from the top down
        let mut size = vec![1u32; scopes.len()];
        for i in (1..scopes.len()).rev().filter(|&i| self.up[i] != NONE) {
            size[self.up[i] as usize] += size[i];
        }
        let mut next = vec![0; scopes.len()];
        for i in 0..scopes.len() {
            if self.home_of[i] != i as u32 {
                continue;
            }
            let first = if self.up[i] == NONE {
                0
            } else {
                let up = self.up[i] as usize;
                next[up] += size[i];
                next[up] - size[i]
            };
            self.interval[i] = (first, first + size[i]);
            next[i] = first + 1;
        }
    }

    /// Makes what drives one wire together one.
    fn share(&mut self) {
        let netlist = self.netlist;
        for cell in netlist.cell_ids() {
            let CellKind::Resolve { width, .. } = netlist.cell(cell).kind else { continue };
            let to = self.start[netlist.output(cell, 0).index()];
            let mut at = 0;
            for slice in netlist.input(cell, 0) {
                let home = self.driver[slice.net.index()];
                for bit in
                    self.start[slice.net.index()] + slice.lo..self.start[slice.net.index()] + slice.lo + slice.width
                {
                    let wire = to + at % width;
                    self.shared.insert(bit, wire);
                    self.sharers.entry(wire).or_default().push(home);
                    at += 1;
                }
            }
        }
    }

    fn settle_members(&mut self) {
        let mut ports: Vec<Vec<SignalId>> = self.homes.iter().map(|_| Vec::new()).collect();
        let mut others = ports.clone();
        for id in self.netlist.signal_ids() {
            let signal = self.netlist.signal(id);
            let home = self.home_of[signal.scope.index()];
            let is_port = signal.port.is_some() && signal.scope.0 == home;
            let list = if is_port { &mut ports } else { &mut others };
            list[home as usize].push(id);
        }
        for ((home, ports), others) in self.homes.iter_mut().zip(ports).zip(others) {
            home.ports = ports.len();
            home.signals = ports;
            home.signals.extend(others);
        }
        for id in self.netlist.cell_ids() {
            let cell = self.netlist.cell(id);
            let drives = |net: NetId| self.net_bits(net).any(|b| self.wire_of(b) != b);
            let left_out = match cell.kind {
                CellKind::Resolve { .. } => true,
                CellKind::Constant(_) => {
                    let net = self.netlist.output(id, 0);
                    self.literal[net.index()] && !drives(net)
                }
                _ => false,
            };
            if !left_out {
                self.homes[self.home_of[cell.scope.index()] as usize].cells.push(id);
            }
        }
    }

    /// How many bits there are.
    pub(super) fn bits(&self) -> usize {
        self.start[self.start.len() - 1] as usize
    }

    fn net_bits(&self, net: NetId) -> std::ops::Range<u32> {
        self.start[net.index()]..self.start[net.index() + 1]
    }

    fn wire_of(&self, bit: u32) -> u32 {
        if self.shared.is_empty() { bit } else { *self.shared.get(&bit).unwrap_or(&bit) }
    }

    /// The wires of some slices, bit by bit.
    fn of_slices<'a>(&'a self, slices: &'a [Slice]) -> impl Iterator<Item = u32> + 'a {
        slices.iter().flat_map(|s| {
            let first = self.start[s.net.index()] + s.lo;
            (first..first + s.width).map(|b| self.wire_of(b))
        })
    }

    /// What an input pin is connected to, bit by bit.
    pub(super) fn input(&self, cell: CellId, pin: usize) -> impl Iterator<Item = u32> + '_ {
        self.of_slices(self.netlist.input(cell, pin))
    }

    /// What an output pin drives, bit by bit.
    pub(super) fn output(&self, cell: CellId, pin: usize) -> impl Iterator<Item = u32> + '_ {
        self.net_bits(self.netlist.output(cell, pin)).map(|b| self.wire_of(b))
    }

    /// What a signal shows, bit by bit.
    pub(super) fn signal(&self, id: SignalId) -> impl Iterator<Item = u32> + '_ {
        self.of_slices(self.netlist.bits(id))
    }

    fn net_of(&self, bit: u32) -> NetId {
        self.net[bit as usize]
    }

    /// The value of a bit that is written out wherever it is used.
    pub(super) fn literal(&self, bit: u32) -> Option<Logic> {
        let net = self.net_of(bit);
        if !self.literal[net.index()] {
            return None;
        }
        match self.netlist.net(net).driver {
            Driver::Cell(cell, _) => match &self.netlist.cell(cell).kind {
                CellKind::Constant(value) => Some(value.bit(bit - self.start[net.index()])),
                _ => None,
            },
            Driver::Input(_) => None,
        }
    }

    /// The cell that drives a bit, its pin, and which of the pin's bits it is.
    pub(super) fn driver(&self, bit: u32) -> Option<(CellId, u8, u32)> {
        let net = self.net_of(bit);
        match self.netlist.net(net).driver {
            Driver::Cell(cell, pin) => Some((cell, pin, bit - self.start[net.index()])),
            Driver::Input(_) => None,
        }
    }

    /// Whether what drives a bit is in an instance, and whether it is elsewhere.
    pub(super) fn driven(&self, bit: u32, home: ScopeId) -> (bool, bool) {
        let (first, end) = self.interval[home.index()];
        let is_in = |driver: u32| driver != OUTSIDE && (first..end).contains(&self.interval[driver as usize].0);
        match self.sharers.get(&bit) {
            Some(homes) => (homes.iter().any(|&h| is_in(h)), homes.iter().any(|&h| !is_in(h))),
            None => {
                let inside = is_in(self.driver[self.net_of(bit).index()]);
                (inside, !inside)
            }
        }
    }

    /// Whether a bit is used outside of an instance in which it is present.
    pub(super) fn leaves(&self, bit: u32, home: ScopeId) -> bool {
        self.around[bit as usize] != home.0
    }

    fn common(&self, mut a: u32, mut b: u32) -> u32 {
        while a != b {
            if self.depth[a as usize] >= self.depth[b as usize] {
                a = self.up[a as usize];
            } else {
                b = self.up[b as usize];
            }
        }
        a
    }

    /// The bits that an instance's own members use or drive.
    fn present(&self, home: &Home, mut f: impl FnMut(u32)) {
        for &cell in &home.cells {
            let kind = &self.netlist.cell(cell).kind;
            (0..kind.inputs().len()).for_each(|pin| self.input(cell, pin).for_each(&mut f));
            (0..kind.outputs().len()).for_each(|pin| self.output(cell, pin).for_each(&mut f));
        }
        home.signals.iter().for_each(|&s| self.signal(s).for_each(&mut f));
    }

    /// Finds for each bit the innermost instance around all that use or drive it.
    fn locate(&mut self) {
        let mut around = vec![NONE; self.bits()];
        let mut touch = |bit: u32, home: u32| {
            let at = &mut around[bit as usize];
            *at = if *at == NONE { home } else { self.common(*at, home) };
        };
        for (i, home) in self.homes.iter().enumerate() {
            self.present(home, |bit| touch(bit, i as u32));
            for &port in &home.signals[..home.ports] {
                // an input is connected to something outside
                let outer = self.netlist.signal(port).port != Some(Direction::Output) && i > 0;
                if outer {
                    self.signal(port).for_each(|bit| touch(bit, self.up[i]));
                }
            }
        }
        self.around = around;
    }

    /// Finds which way ports go indeed: with several drivers some go both ways.
    fn direct(&mut self) {
        for i in 0..self.homes.len() {
            let home = &self.homes[i];
            let ports = &home.signals[..home.ports];
            let shown = |is: fn(Direction) -> bool| -> std::collections::HashSet<u32> {
                let ports = ports.iter().filter(|&&p| self.netlist.signal(p).port.is_some_and(is));
                ports.flat_map(|&p| self.signal(p)).collect()
            };
            let ins = shown(|d| d != Direction::Output);
            let outs = shown(|d| d != Direction::Input);
            let way = |&port: &SignalId| {
                let here = ScopeId::new(i);
                match self.netlist.signal(port).port {
                    Some(Direction::Input) if i > 0 => {
                        let inside = |bit| self.driven(bit, here).0 && !outs.contains(&bit) && self.leaves(bit, here);
                        if self.signal(port).any(inside) { Direction::Inout } else { Direction::Input }
                    }
                    Some(Direction::Output) if i > 0 => {
                        let outside = |bit| {
                            let (inside, outside) = self.driven(bit, here);
                            outside && (inside || !ins.contains(&bit)) && self.literal(bit).is_none()
                        };
                        if self.signal(port).any(outside) { Direction::Inout } else { Direction::Output }
                    }
                    way => way.unwrap_or(Direction::Input),
                }
            };
            let ways = ports.iter().map(way).collect();
            self.homes[i].ways = ways;
        }
    }

    /// Finds the bits that cross the boundary of an instance without a port.
    fn cross(&mut self) {
        let mut passing: Vec<Vec<u32>> = self.homes.iter().map(|_| Vec::new()).collect();
        let mut seen = vec![NONE; self.bits()];
        for i in (1..self.homes.len()).rev().filter(|&i| self.home_of[i] == i as u32) {
            let (home, here) = (&self.homes[i], ScopeId::new(i));
            for &port in &home.signals[..home.ports] {
                self.signal(port).for_each(|bit| seen[bit as usize] = i as u32);
                // what comes or goes through a port is present around it
                let leaving = self.signal(port).filter(|&bit| self.leaves(bit, here));
                passing[self.up[i] as usize].extend(leaving);
            }
            let mut crossing = Vec::new();
            let inner = std::mem::take(&mut passing[i]);
            let mut find = |bit: u32| {
                if seen[bit as usize] != i as u32 && self.leaves(bit, here) && self.literal(bit).is_none() {
                    crossing.push(bit);
                }
                seen[bit as usize] = i as u32;
            };
            self.present(home, &mut find);
            inner.into_iter().for_each(find);
            passing[self.up[i] as usize].extend(&crossing);
            let mut runs: Vec<(Vec<u32>, bool)> = Vec::new();
            for bit in crossing {
                let inwards = !self.driven(bit, here).0;
                match runs.last_mut() {
                    Some((run, way))
                        if *way == inwards
                            && run.last() == Some(&bit.wrapping_sub(1))
                            && self.net_of(bit) == self.net_of(bit - 1) =>
                    {
                        run.push(bit);
                    }
                    _ => runs.push((vec![bit], inwards)),
                }
            }
            self.homes[i].crossing = runs;
        }
    }
}

/// Whether a constant is one that the builder made for a literal or for what nothing drives.
fn is_literal(netlist: &Netlist, net: NetId) -> bool {
    let Driver::Cell(cell, _) = netlist.net(net).driver else { return false };
    let cell = netlist.cell(cell);
    match &cell.kind {
        CellKind::Constant(value) => cell.name == crate::netlist::UNDRIVEN || cell.name == value.to_string(),
        _ => false,
    }
}
