//! Contents of a memory, as `$readmemh` and `--memory` read them. Before them stand the width and the size of the memory.
#![no_main]

use discreta::diag::{Diagnostics, Sources};
use discreta::import::readmem::{Shape, read};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let [width, size, offset, rest @ ..] = bytes else { return };
    let Ok(text) = std::str::from_utf8(rest) else { return };
    let shape = Shape { width: u32::from(*width) + 1, size: u32::from(*size) + 1, offset: i32::from(*offset as i8) };
    let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
    let file = sources.add("memory.hex", text.to_owned());
    read(text, file, shape, &mut diagnostics, |place, value| {
        assert!(place < shape.size && value.width() == shape.width);
    });
    let _ = diagnostics.render(&sources, false);
});
