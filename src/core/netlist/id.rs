//! Dense indices into a netlist.

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        pub struct $name(pub u32);

        impl $name {
            /// The position in the netlist's list.
            #[inline(always)]
            #[must_use]
            pub const fn index(self) -> usize {
                self.0 as usize
            }

            /// The id of that position.
            ///
            /// # Panics
            /// Beyond 2^32 - 1.
            #[must_use]
            pub fn new(index: usize) -> Self {
                Self(u32::try_from(index).expect("a netlist has fewer than 2^32 of anything: the limits are far below"))
            }
        }
    };
}

id!(
    /// A net: what one output pin of a cell, or one input of the circuit, drives.
    NetId
);
id!(
    /// A cell.
    CellId
);
id!(
    /// A scope: the top module, an instance or a block within it.
    ScopeId
);
id!(
    /// A signal: a name for some bits of nets.
    SignalId
);
