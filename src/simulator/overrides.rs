//! What overrides the circuit: forced nets, deposited state.

use super::{IntoValue, Simulator, SimulatorError};
use crate::engine::Refused;
use crate::value::Word;
use crate::value::word::{extract, words};

impl Simulator {
    /// Holds a signal at a value, whatever drives it, until it is [released](Simulator::release). It takes effect at the next
    /// [`settle`](Simulator::settle) or [`tick`](Simulator::tick).
    ///
    /// # Errors
    /// If there is no such signal, the value does not fit it, or constants decide what it is.
    pub fn force(&mut self, name: &str, value: impl IntoValue) -> Result<(), SimulatorError> {
        self.each_slice(name, value, |sim, bits, value| sim.engine.force(bits, value))
    }

    /// Lets go of a forced signal: at the next [`settle`](Simulator::settle) it is what drives it; storage keeps what it was
    /// held at until it samples.
    ///
    /// # Errors
    /// If there is no such signal.
    pub fn release(&mut self, name: &str) -> Result<(), SimulatorError> {
        let probe = self.known_probe(name)?;
        probe.bits.iter().for_each(|&bits| self.engine.release(bits));
        Ok(())
    }

    /// Sets a register, latch or input once, as if it had come to that by itself. It takes effect at the next
    /// [`settle`](Simulator::settle) or [`tick`](Simulator::tick).
    ///
    /// # Errors
    /// If there is no such signal, the value does not fit it, or nothing would keep it.
    pub fn deposit(&mut self, name: &str, value: impl IntoValue) -> Result<(), SimulatorError> {
        self.each_slice(name, value, |sim, bits, value| sim.engine.deposit(bits, value))
    }

    fn each_slice(
        &mut self,
        name: &str,
        value: impl IntoValue,
        act: impl Fn(&mut Simulator, crate::netlist::Slice, &[Word]) -> Result<(), Refused>,
    ) -> Result<(), SimulatorError> {
        let probe = self.known_probe(name)?;
        let value = value.into_value(probe.width);
        let value = value.map_err(|why| SimulatorError::BadValue { name: name.to_owned(), why })?;
        let all: Vec<Word> = value.words().collect();
        let mut at = 0;
        for &bits in &probe.bits {
            let mut part = vec![Word::ZERO; words(bits.width)];
            extract(&mut part, &all, at, bits.width);
            act(self, bits, &part).map_err(|why| SimulatorError::Refused(why.text(&self.netlist)))?;
            at += bits.width;
        }
        Ok(())
    }
}
