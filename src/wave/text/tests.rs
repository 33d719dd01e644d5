use super::*;

fn trace(scope: &str, name: &str, width: u32, changes: &[(u64, &str)]) -> Trace {
    let changes = changes.iter().map(|(t, v)| (*t, (*v).to_owned())).collect();
    let (scope, name, kind) = (scope.into(), name.into(), ValueKind::Bits(width));
    Trace { scope, name, kind, radix: Radix::Auto, values: None, changes }
}

/// One column a tick, as the gaps of 10 ticks make it.
fn picture(traces: &[Trace], to: u64, style: Style, mark: Option<u64>) -> String {
    let axis = Axis::new(traces, 0, to, 60, Legible::Whole);
    let mark = mark.map(|time| (time, "here".to_owned()));
    Picture { traces, timescale: Some(Timescale::default()), axis, mark, style }.to_string()
}

fn example() -> Vec<Trace> {
    let q = [(0, "xxxx"), (10, "0101"), (30, "1100"), (40, "zzzz")];
    vec![
        trace("top", "clk", 1, &[(0, "0"), (10, "1"), (20, "0"), (30, "1"), (40, "0")]),
        trace("top", "q", 4, &q),
        trace("top.u", "d", 1, &[(0, "x"), (10, "z"), (20, "1"), (30, "1")]),
    ]
}

#[test]
fn rows_by_hand() {
    let expected = r#"
       |0 ns-----|10-------|20-------|30-------|40--
top
  clk  __________/"""""""""\_________/"""""""""\____
  q    xxxxxxxxxx| 5                 | 12      |zzzz
top.u
  d    xxxxxxxxxxzzzzzzzzzz"""""""""""""""""""""""""
                           ^ here
"#;
    let drawn = picture(&example(), 44, Style { ascii: true, color: false }, Some(20));
    assert_eq!(drawn, expected[1..]);
    let drawn = picture(&example(), 44, Style::default(), None);
    let expected = "
       ├0 ns─────├10───────├20───────├30───────├40──
top
  clk  ▁▁▁▁▁▁▁▁▁▁╱▔▔▔▔▔▔▔▔▔╲▁▁▁▁▁▁▁▁▁╱▔▔▔▔▔▔▔▔▔╲▁▁▁▁
  q    xxxxxxxxxx╳ 5                 ╳ 12      ╳zzzz
top.u
  d    xxxxxxxxxxzzzzzzzzzz▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔
";
    assert_eq!(drawn, expected[1..]);
}
