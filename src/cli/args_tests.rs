use clap::CommandFactory;

use super::shared::{assignment, clock, condition};
use super::*;

fn parse(line: &str) -> Result<Command, String> {
    let words = std::iter::once("discreta").chain(line.split_whitespace());
    Cli::try_parse_from(words).map(|cli| cli.command).map_err(|error| error.to_string())
}

#[test]
fn clap_finds_no_fault() {
    Cli::command().debug_assert();
}

#[test]
fn everything_that_can_be_said_to_run() {
    let line = "run c.json -p W=8 -p K=2 -s dx=5 -s dy=-3 --cycles 7 --until end=1 -o a.vcd -o - --trace **.q \
                --engine event --x-control error --limit width=100 --format json -v";
    let Command::Run(args) = parse(line).unwrap() else { panic!() };
    let pair = |name: &str, value: &str| Assignment { name: name.into(), value: value.into() };
    assert_eq!(args.elaboration.parameter, [pair("W", "8"), pair("K", "2")]);
    assert_eq!(args.scenario.set, [pair("dx", "5"), pair("dy", "-3")]);
    assert_eq!(args.scenario.until, Some(Condition { net: "end".into(), value: Some("1".into()) }));
    assert_eq!(args.output, [PathBuf::from("a.vcd"), PathBuf::from("-")]);
    assert_eq!((args.scenario.cycles, args.scenario.time, args.trace), (Some(7), None, vec!["**.q".to_owned()]));
    assert_eq!((args.engine.engine, args.engine.x_control), (EngineChoice::Event, XControl::Error));
    assert_eq!(args.elaboration.limit, [pair("width", "100")]);
    assert!(args.format.format == Format::Json && args.verbose);

    let Command::Run(args) = parse("run c.json --time 5us --until end").unwrap() else { panic!() };
    assert_eq!(args.scenario.time.as_deref(), Some("5us"));
    assert_eq!(args.scenario.until, Some(Condition { net: "end".into(), value: None }));
    assert_eq!((args.engine.engine, args.engine.x_control), (EngineChoice::Auto, XControl::Warn));
}

#[test]
fn what_cannot_be_meant() {
    assert!(parse("run c.json --cycles 5 --time 5us").unwrap_err().contains("cannot be used with"));
    for line in ["run c.json -s dx", "run c.json -s =5", "run c.json -p W="] {
        assert!(parse(line).unwrap_err().contains("write it as NAME=VALUE"), "{line}");
    }
    for line in ["run c.json --until =1", "run c.json --until end="] {
        assert!(parse(line).unwrap_err().contains("write it as NET or NET=VALUE"), "{line}");
    }
    for to in ["5", "5,", "5,x", "1,2,3,4", "1.5,2"] {
        assert!(parse(&format!("interpolate ef-line --to {to}")).unwrap_err().contains("two whole numbers"), "{to}");
    }
    assert!(parse("check").is_err());
    assert!(parse("interpolate").is_err());
    assert!(parse("interpolate ef-circle --to 1,2 --cw --ccw").unwrap_err().contains("cannot be used with"));
}

#[test]
fn points_may_be_negative() {
    let Command::Interpolate(args) = parse("interpolate ef-line --to -5,3 --from 1,-2").unwrap() else { panic!() };
    let point = |x, y, z| Some(Point { x, y, z });
    assert_eq!((args.drawing.to, args.drawing.from), (point(-5, 3, None), point(1, -2, None)));
    let Command::Interpolate(args) = parse("interpolate ef-line-3d --to -5,3,-1").unwrap() else { panic!() };
    assert_eq!((args.drawing.to, args.drawing.from), (point(-5, 3, Some(-1)), None));
}

#[test]
fn clocks_and_escaped_names() {
    assert_eq!(
        clock("clk=20ns, high=5ns,phase=0"),
        Ok(ClockOption { net: "clk".into(), period: "20ns".into(), high: Some("5ns".into()), phase: Some("0".into()) })
    );
    for bad in ["clk", "clk=", "clk=,high=5", "clk=5,duty=3", "clk=5,high", "clk=5,high=", "clk=5,high=1,high=2"] {
        assert!(clock(bad).is_err(), "{bad}");
    }
    let pair = |name: &str, value: &str| Ok(Assignment { name: name.into(), value: value.into() });
    assert_eq!(assignment("\\a=b =5"), pair("a=b", "5"));
    assert_eq!(assignment("\\a.b  = 4'b1"), pair("a.b", "4'b1"));
    assert!(assignment("\\a=5").is_err());
    assert_eq!(condition("\\a=b "), Ok(Condition { net: "a=b".into(), value: None }));
}

#[test]
fn defaults() {
    let Command::Test(args) = parse("test").unwrap() else { panic!() };
    assert_eq!(args.path, [PathBuf::from("traces")]);
    let Command::Schema(args) = parse("schema").unwrap() else { panic!() };
    assert_eq!(args.of, SchemaKind::Circuit);
}

/// An option is the same wherever it is: one help text, one short form, one name of its value.
#[test]
fn an_option_means_the_same_in_every_command() {
    let (mut seen, mut differ) = (std::collections::HashMap::new(), Vec::new());
    for command in Cli::command().get_subcommands() {
        for arg in command.get_arguments().filter(|arg| !arg.is_positional()) {
            let long = arg.get_long().unwrap().to_owned();
            // What an interpolation prints is no report, and tests have more forms of it; a picture, a netlist, a table are no
            // waveform; a comparison needs bits; times of a record and of a comparison are no points; `why` drives from the
            // waveform that it compares with; an export goes to a format, where a path goes to a point; what is shown is not
            // recorded; and a machine has pulses and directions where a circuit shows coordinates.
            const OTHER: [(&str, &str); 25] = [
                ("interpolate", "format"),
                ("test", "format"),
                ("run", "from"),
                ("run", "to"),
                ("diff", "from"),
                ("diff", "to"),
                ("why", "expect"),
                ("plot", "output"),
                ("draw", "output"),
                ("view", "output"),
                ("view", "trace"),
                ("view", "center"),
                ("view", "cw"),
                ("export", "output"),
                ("export", "to"),
                ("wave", "from"),
                ("wave", "to"),
                ("wave", "signed"),
                ("sweep", "output"),
                ("compare", "bits"),
                ("feed", "tick"),
                ("machine", "output"),
                ("machine", "x"),
                ("machine", "y"),
                ("machine", "z"),
            ];
            if OTHER.contains(&(command.get_name(), long.as_str())) {
                continue;
            }
            let help = arg.get_help().unwrap_or_else(|| panic!("--{long} has no help")).to_string();
            let names: Vec<_> = arg.get_value_names().into_iter().flatten().map(|name| name.to_string()).collect();
            let meaning = (help, arg.get_short(), names);
            let known = seen.entry(long.clone()).or_insert_with(|| meaning.clone());
            if *known != meaning {
                differ.push((long, known.clone(), meaning));
            }
        }
    }
    assert!(differ.is_empty(), "{differ:#?}");
    assert!(seen.len() > 15, "{}", seen.len());
}
