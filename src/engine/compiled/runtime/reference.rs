//! What the event engine does in place of machine code: forces, and state that is set from outside.
//!
//! Code is made for a circuit in which every net is what drives it. While a net is not, the reference runs; when nothing is
//! forced any more and all that it found has been looked at, machine code goes on from there.

use super::CompiledEngine;
use crate::netlist::NetId;
use crate::{Engine, EventEngine};

/// The event engine, kept once there is one, and whether it is the one that runs.
#[derive(Debug, Default)]
pub(crate) struct Reference {
    engine: Option<Box<EventEngine>>,
    runs: bool,
}

impl Reference {
    #[inline(always)]
    pub fn active(&self) -> Option<&EventEngine> {
        if self.runs { self.engine.as_deref() } else { None }
    }

    #[inline(always)]
    pub fn active_mut(&mut self) -> Option<&mut EventEngine> {
        if self.runs { self.engine.as_deref_mut() } else { None }
    }

    pub fn observe(&mut self, net: NetId) {
        if let Some(engine) = &mut self.engine {
            engine.observe(net);
        }
    }

    /// Machine code goes on.
    pub fn rest(&mut self) {
        self.runs = false;
    }
}

impl CompiledEngine {
    /// The event engine if it is the one that runs, and goes on to.
    #[inline(always)]
    pub(crate) fn by_reference(&mut self) -> Option<&mut EventEngine> {
        if self.reference.runs {
            self.consider();
        }
        self.reference.active_mut()
    }

    /// Goes over to machine code if there is nothing left that needs the event engine.
    fn consider(&mut self) {
        if let Some(engine) = self.reference.active().filter(|engine| engine.is_quiet()) {
            let snapshot = engine.save();
            self.reference.rest();
            self.load(&snapshot);
        }
    }

    /// The event engine, which runs from now on.
    pub(crate) fn reference(&mut self) -> &mut EventEngine {
        if !self.reference.runs {
            let snapshot = self.snapshot();
            let netlist = &self.netlist;
            let nets = &self.observation.nets;
            let engine = self.reference.engine.get_or_insert_with(|| {
                let mut engine = Box::new(EventEngine::new(netlist));
                nets.iter().for_each(|&net| engine.observe(net));
                engine
            });
            engine.restore(&snapshot).expect("it is of the same netlist");
            engine.clear_changes();
            // what has been found but not looked at
            let traced = (0..nets.len()).filter(|&n| self.observation.tracing.changed.contains(n)).map(|n| nets[n]);
            traced.chain(self.observation.changes.iter().copied()).for_each(|net| engine.list_change(net));
            engine.add_unknown_controls(std::mem::take(&mut self.diagnostics.unknown_controls));
            self.observation.tracing.changed.clear();
            self.observation.clear();
            self.reference.runs = true;
        }
        self.reference.engine.as_deref_mut().expect("it was made")
    }
}
