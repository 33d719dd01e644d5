//! `diff` of a part in time, without some signals, or of signals that are called otherwise.

use crate::support::folder;
use crate::support::program::run;

#[test]
fn parts_and_names() {
    let folder = folder("diff_options");
    let file = |name: &str, second: &str, changes: &str| {
        let text = format!(
            "$timescale 1 ns $end $scope module t $end $var wire 1 ! a $end $var wire 1 \" {second} $end \
             $upscope $end $enddefinitions $end\n{changes}"
        );
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    // `a` differs from 5 to 10 and from 20 on
    let a = file("a.vcd", "b", "#0\n0!\n0\"\n#10\n1!\n#20\n0!\n1\"\n#40\n");
    let same = file("s.vcd", "b", "#0\n0!\n0\"\n#5\n1!\n#20\n1\"\n#40\n");
    let other = file("o.vcd", "c", "#0\n0!\n0\"\n#5\n1!\n#20\n1\"\n#40\n");
    for (b, options, status, part) in [
        (&same, "", 1, "First difference at 5 ns: t.a"),
        (&same, "--from 10 --to 19", 0, "The same"),
        (&same, "--from 10ns", 1, "First difference at 20 ns: t.a"),
        // what differs when the part begins, though nothing changes then
        (&same, "--from 7 --to 8", 1, "First difference at 7 ns: t.a"),
        (&same, "--from 30", 1, "First difference at 30 ns: t.a"),
        (&same, "--to 4", 0, "The same"),
        (&same, "--ignore a", 0, "The same"),
        (&other, "--ignore a --map b=c", 0, "The same"),
        (&other, "--ignore t.a --map t.b=t.c", 0, "The same"),
        (&other, "--ignore a", 2, "have no signal of the same name"),
        (&same, "--from 9 --to 3", 2, "--from is after --to"),
    ] {
        let mut line = vec!["diff", &a, b];
        line.extend(options.split_whitespace());
        let (found, text, told) = run(&line);
        assert_eq!(found, status, "{options}: {text}{told}");
        assert!(text.contains(part) || told.contains(part), "{options}: {text}{told}");
    }
}
