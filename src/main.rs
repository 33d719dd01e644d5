//! The command `discreta`.

use std::process::ExitCode;

fn main() -> ExitCode {
    discreta::cli::main()
}
