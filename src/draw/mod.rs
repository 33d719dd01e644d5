//! The schematic of a netlist as SVG: standard symbols from left to right, instances as boxes or opened, orthogonal wires.
//!
//! [`graph`] makes nodes, pins and nets of a module's body, [`symbol`] knows what a node looks like, [`layout`] has ELK's
//! layered algorithm place nodes and route wires ([decision 7](../../docs/decisions/0007-elk-lays-out-schematics.md)),
//! [`paint`] writes SVG. This room knows netlists; it knows neither engines nor waveforms nor files.
//!
//! # What a program may rely on in the SVG
//!
//! The picture is a plain file and can as well be put into a page, where a program finds what to colour and to label:
//!
//! | element | attributes | is |
//! |---|---|---|
//! | `svg.schematic` | `data-top`, `data-scope` | the whole; `data-top` is the top scope of a waveform, `data-scope` the path below it of the instance that is drawn (empty: the top itself) |
//! | `g.cell` | `id="cell:PATH"`, `data-cell="PATH"`, `data-kind` | a cell: `register`, `and`, … |
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
//! A wire that carries a constant has `data-constant="0101"` and neither of the others.
//!
//! Colours are custom properties on `svg.schematic`, which a page can set: `--paper`, `--ink`, `--wire`, `--bus`,
//! `--fill`, `--soft`, `--accent`. All names of classes mean something only within `svg.schematic`. Coordinates are pixels
//! from the top left corner, whole or half; all that is drawn is in absolute coordinates, there is no `transform`.
