//! Random designs through Yosys, and every command on what it makes of them: the exported Verilog runs on Icarus as the
//! netlist runs here, Yosys takes it and what it makes of it runs the same, as does the netlist as Yosys' JSON; `check`,
//! `stats`, `draw`, `view`, `wave` and graphs do what they are asked.
//!
//! Without end, from a number of one's choice, in parts of so many:
//!
//!     DISCRETA_SEED=1 DISCRETA_CASES=100000 cargo test --test oracle campaign_export random -- --nocapture

use std::collections::HashMap;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::random_verilog::{Design, Net};
use crate::support::rng::Rng;
use discreta::Logic;
use discreta::wave::read::Waves;
use needs::needs;
use serde_json::{Value as Json, json};

/// How far Yosys takes a design.
const PASSES: [&str; 6] = [
    "hierarchy -top top; proc",
    "hierarchy -top top; proc; memory",
    "prep -top top",
    "prep -flatten -top top",
    "synth -top top",
    "synth -flatten -top top",
];

/// What one net does: when it changes, to what.
type Changes = Vec<(u64, String)>;

fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().map_or(otherwise, |text| text.parse().unwrap_or_else(|_| panic!("{name}={text}")))
}

/// One design, in a folder of its own.
struct Case {
    folder: PathBuf,
    seed: u64,
}

impl Case {
    fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.folder.join(name), text).unwrap();
    }

    /// Runs a tool, which must succeed and stay silent.
    fn tool(&self, name: &str, arguments: &[&str]) {
        let done = Command::new(name).current_dir(&self.folder).args(arguments).output().unwrap();
        let told = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(done.status.success(), "{name} {}: {told}", arguments.join(" "));
    }

    fn yosys(&self, script: &str) {
        self.tool("yosys", &["-q", "-p", script]);
    }

    fn discreta(&self, arguments: &[&str]) {
        let done = Command::new(env!("CARGO_BIN_EXE_discreta"))
            .current_dir(&self.folder)
            .args(arguments)
            .output()
            .unwrap_or_else(|e| panic!("{e}"));
        let told = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success(), "discreta {}: {}: {told}", arguments.join(" "), done.status);
    }

    /// Runs a netlist and reads the waveform.
    fn run(&self, netlist: &str, simulation: &Json) -> HashMap<String, Changes> {
        self.write("run.json", json!({ "circuit": netlist, "simulation": simulation }).to_string());
        self.discreta(&["run", "run.json", "-o", "run.vcd", "--x-control", "ignore"]);
        waves(&self.folder.join("run.vcd"), "")
    }

    fn same(&self, what: &str, ours: &HashMap<String, Changes>, theirs: &HashMap<String, Changes>) -> usize {
        // what is called as something around it gets another name
        let renamed: HashMap<String, &Changes> = theirs.iter().map(|(n, c)| (plain(n), c)).collect();
        for (name, changes) in ours {
            let found = theirs.get(name).or_else(|| renamed.get(name).copied());
            let found = found.unwrap_or_else(|| panic!("{what}: `{name}` is not there"));
            if changes != found {
                let first =
                    changes.iter().zip(found).position(|(a, b)| a != b).unwrap_or(changes.len().min(found.len()));
                panic!("{what}: `{name}`: {:?} and {:?}", changes.get(first), found.get(first));
            }
        }
        ours.len()
    }

    /// Does everything with a design; how many nets were compared.
    fn all(&self, design: &Design, passes: &str) -> usize {
        let mut rng = Rng::new(self.seed);
        self.write("design.v", &design.text);
        self.yosys(&format!("read_verilog design.v; {passes}; write_json design.json"));
        let unknown = *rng.pick(&[u64::MAX, u64::MAX, 8]);
        let mut stimulus = Vec::new();
        for at in 0..24u64 {
            for input in &design.inputs {
                if at == 0 || rng.one_in(2) {
                    // of z two tools think differently: docs/export.md
                    let mut value = rng.known(input.width);
                    (0..input.width).filter(|_| rng.one_in(unknown)).for_each(|b| value.set_bit(b, Logic::X));
                    let value = format!("{}'b{}", value.width(), value.bit_string());
                    stimulus.push(json!({ "at": at * 4, "set": { (&*input.name): value } }));
                }
            }
        }
        let simulation = json!({ "clocks": { "clk": { "period": 10, "phase": 5 } }, "stimulus": stimulus,
            "limit": { "time": 100 }, "trace": ["**"] });
        let ours = self.run("design.json", &simulation);

        self.discreta(&["export", "run.json", "--to", "verilog", "-o", "again.v", "--testbench", "bench.v"]);
        self.tool("iverilog", &["-g2005", "-o", "bench.vvp", "again.v", "bench.v"]);
        self.tool("vvp", &["-n", "bench.vvp"]);
        let mut nets = self.same("on Icarus", &ours, &waves(&self.folder.join("bench.vcd"), "testbench."));

        self.yosys("read_verilog again.v; hierarchy -check -auto-top; proc; check -assert; write_json back.json");
        // Yosys makes of `if` what is not Verilog's where its condition is x
        if unknown == u64::MAX {
            let ports = ours.iter().filter(|n| n.0.matches('.').count() == 1 && is_port(n.0));
            let ports = ports.map(|(n, c)| (n.clone(), c.clone())).collect();
            nets += self.same("back through Yosys", &ports, &self.run("back.json", &simulation));
        }

        self.discreta(&["export", "design.json", "--to", "yosys-json", "-o", "again.json"]);
        self.yosys("read_json again.json; hierarchy -check -auto-top; check");
        nets += self.same("as Yosys' JSON", &ours, &self.run("again.json", &simulation));

        self.discreta(&["check", "design.json", "run.json"]);
        self.discreta(&["stats", "design.json"]);
        self.discreta(&["stats", "design.json", "--format", "json"]);
        self.discreta(&["export", "design.json", "--to", "dot", "-o", "design.dot"]);
        self.discreta(&["draw", "design.json", "-o", "design.svg"]);
        self.discreta(&["view", "run.json", "-o", "design.html"]);
        self.discreta(&["wave", "run.vcd"]);
        nets
    }
}

/// A path without the numbers that tell names apart.
fn plain(path: &str) -> String {
    let name = |name: &str| match name.rsplit_once('_') {
        Some((base, n)) if n.chars().all(|c| c.is_ascii_digit()) => base.to_owned(),
        _ => name.to_owned(),
    };
    path.split('.').map(name).collect::<Vec<_>>().join(".")
}

fn is_port(name: &str) -> bool {
    name.rsplit('.').next().is_some_and(|n| n.starts_with('o') && n[1..].chars().all(|c| c.is_ascii_digit()))
}

fn waves(path: &Path, scope: &str) -> HashMap<String, Changes> {
    let mut waves = Waves::open(path).unwrap_or_else(|e| panic!("{e}"));
    let names: Vec<String> = waves.vars().iter().map(|v| v.name.clone()).collect();
    let changes = |(i, name): (usize, String)| {
        (name.strip_prefix(scope).unwrap_or(&name).to_owned(), waves.load(i).unwrap().changes().collect())
    };
    names.into_iter().enumerate().map(changes).collect()
}

/// Each seed from the one that was asked for, in a folder of its own, which stays if there is something wrong.
fn campaign(name: &str, cases: u64, one: impl Fn(PathBuf, u64) -> usize + std::panic::RefUnwindSafe) -> usize {
    let (seed, cases) = (number("DISCRETA_SEED", 1), number("DISCRETA_CASES", cases));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let (mut compared, mut bad) = (0, Vec::new());
    for seed in seed..seed.saturating_add(cases) {
        let folder = folder.join(seed.to_string());
        std::fs::create_dir_all(&folder).unwrap();
        match catch_unwind(|| one(folder.clone(), seed)) {
            Ok(more) => {
                compared += more;
                std::fs::remove_dir_all(&folder).unwrap();
            }
            Err(_) => bad.push(seed),
        }
    }
    println!("{name}: {cases} cases from {seed}, {compared} compared, {} findings: {bad:?}", bad.len());
    assert!(bad.is_empty(), "look into {}", folder.display());
    assert!(compared as u64 >= 5 * cases);
    compared
}

#[needs(iverilog, yosys)]
#[test]
fn random_netlists_through_every_command() {
    campaign("campaign_export", 6, |folder, seed| {
        let mut rng = Rng::new(seed);
        let design = Design::new(&mut rng);
        Case { folder, seed }.all(&design, PASSES[rng.below(PASSES.len() as u64) as usize])
    });
}

/// Seed 196 found a memory of one word, without an address, that nothing writes.
#[needs(iverilog, yosys)]
#[test]
fn a_memory_without_an_address_stays_mended() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("campaign_found");
    std::fs::create_dir_all(&folder).unwrap();
    let (seed, mut rng) = (196, Rng::new(196));
    let design = Design::new(&mut rng);
    assert!(Case { folder, seed }.all(&design, PASSES[rng.below(PASSES.len() as u64) as usize]) > 0);
}

/// Shapes of ports that are hard, one by one, at every level of synthesis.
#[needs(iverilog, yosys)]
#[test]
fn shapes_of_ports_through_every_command() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("shapes_of_ports");
    std::fs::create_dir_all(&folder).unwrap();
    let text = include_str!("../verilog/ports.v").to_owned();
    let inputs = vec![Net::bit("r"), Net::vector("a", 1, 0), Net::vector("b", 0, 64)];
    let design = Design { text, inputs };
    for (passes, seed) in PASSES.into_iter().zip(1..) {
        let nets = Case { folder: folder.clone(), seed }.all(&design, passes);
        assert!(nets > 60, "{passes}: {nets}");
    }
}

/// Anything that a file may hold in place of something else.
fn wrong(rng: &mut Rng) -> Json {
    let sizes = [0, 1, 63, 64, 65, 65_535, 65_536, 1 << 31, 1 << 32, i64::MAX];
    match rng.below(8) {
        0 => Json::Null,
        1 => json!([]),
        2 => json!({}),
        3 => json!(""),
        4 => json!("x"),
        5 => json!(-1),
        6 => json!(format!("{:b}", rng.pick(&sizes))),
        _ => json!(rng.pick(&sizes)),
    }
}

/// Takes something out of a file, or puts something else in its place.
fn spoil(rng: &mut Rng, json: &mut Json) {
    let here = rng.one_in(6);
    match json {
        Json::Object(map) if !map.is_empty() => {
            let key = rng.pick(&map.keys().cloned().collect::<Vec<_>>()).clone();
            match here {
                true if rng.one_in(2) => _ = map.remove(&key),
                true => map[&key] = wrong(rng),
                false => spoil(rng, &mut map[&key]),
            }
        }
        Json::Array(list) if !list.is_empty() => {
            let at = rng.below(list.len() as u64) as usize;
            match here {
                true => _ = list.remove(at),
                false => spoil(rng, &mut list[at]),
            }
        }
        other => *other = wrong(rng),
    }
}

/// Files with something missing or wrong: where `check` finds a fault nothing is made of them, and nothing panics.
#[test]
fn faulty_netlists_through_every_command() {
    const FILES: [&str; 5] = [
        "tests/netlists/rom.json",
        "tests/netlists/hierarchy.json",
        "circuits/evaluation/line.json",
        "circuits/dda/line.json",
        "circuits/feed/system.json",
    ];
    campaign("campaign_faulty", 12, |folder, seed| {
        let mut rng = Rng::new(seed);
        let path = *rng.pick(&FILES);
        let mut file: Json = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        for _ in 0..1 + rng.below(3) {
            spoil(&mut rng, &mut file);
        }
        // where a circuit finds what it imports
        let text = file.to_string().replace("../", &format!("{}/circuits/", env!("CARGO_MANIFEST_DIR")));
        std::fs::write(folder.join("faulty.json"), text).unwrap();
        let run = |line: &str| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_discreta"));
            let done = command.current_dir(&folder).args(line.split(' ')).output().unwrap();
            let told = String::from_utf8_lossy(&done.stderr).into_owned();
            assert!(matches!(done.status.code(), Some(0..=2)), "discreta {line}: {}: {told}", done.status);
            done.status.code().unwrap()
        };
        let sound = run("check faulty.json") == 0;
        const LINES: [&str; 7] = [
            "stats faulty.json",
            "export faulty.json --to verilog -o faulty.v",
            "export faulty.json --to yosys-json -o again.json",
            "export faulty.json --to dot -o faulty.dot",
            "draw faulty.json -o faulty.svg",
            "view faulty.json --time 100ns -o faulty.html",
            "run faulty.json --time 100ns -o faulty.vcd",
        ];
        for line in LINES {
            let status = run(line);
            let writes = line.split(' ').skip_while(|w| *w != "-o").nth(1);
            let wrote = writes.is_some_and(|file| folder.join(file).exists());
            assert!(sound || status == 2 && !wrote || line.contains("--time"), "discreta {line}: {status}");
        }
        LINES.len()
    });
}
