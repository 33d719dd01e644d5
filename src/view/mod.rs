//! The page that shows a circuit at work: schematic, waveform and path under one time cursor, in one HTML file.
//!
//! A [`Page`] is what it is made of; [`html`](Page::html) puts it into the sources of the page (`page/`), which need no
//! network and no server. [`pack`] makes a waveform small enough to be carried in it, [`route`] finds the path that two or
//! three coordinates draw, and the curve they follow. This room knows waveforms and pictures; it knows nothing of
//! circuits, engines or the command line.

pub mod pack;
pub mod route;

use serde::Serialize;

use crate::Timescale;
use pack::Signals;
use route::Route;

/// What a page shows.
#[derive(Debug)]
pub struct Page {
    /// What is looked at.
    pub title: String,
    /// What there is to say of it, in one line.
    pub note: String,
    /// How long a tick is.
    pub timescale: Option<Timescale>,
    /// The schematic as SVG, or why there is none.
    pub schematic: Result<String, String>,
    /// The signals over time.
    pub signals: Signals,
    /// The path of an interpolator.
    pub route: Option<Route>,
}

/// What the page's program reads.
#[derive(Serialize)]
struct Data<'a> {
    title: &'a str,
    /// A tick: so many of a unit.
    tick: Option<(u32, &'static str)>,
    #[serde(flatten)]
    signals: &'a Signals,
    route: Option<&'a Route>,
}

/// The program, part by part; each uses those before it.
const PROGRAM: &[&str] = &[
    include_str!("page/signals.js"),
    include_str!("page/cursor.js"),
    include_str!("page/schematic.js"),
    include_str!("page/waveform.js"),
    include_str!("page/route.js"),
    include_str!("page/controls.js"),
    include_str!("page/main.js"),
];

impl Page {
    /// The file. The same page gives the same bytes.
    #[must_use]
    pub fn html(&self) -> String {
        let tick = self.timescale.map(|t| (t.count(), t.unit().as_str()));
        let data = Data { title: &self.title, tick, signals: &self.signals, route: self.route.as_ref() };
        // numbers, texts and lists: this cannot fail
        let data = crate::safe::json(&serde_json::to_string(&data).unwrap_or_default()).into_owned();
        let schematic = match &self.schematic {
            Ok(svg) => svg
                .split_once("?>")
                .filter(|_| svg.starts_with("<?xml"))
                .map_or(svg.as_str(), |(_, svg)| svg)
                .to_owned(),
            Err(why) => format!("<p class=\"none\">{}</p>", escape(why)),
        };
        let parts = [
            ("{{title}}", escape(&self.title)),
            ("{{note}}", escape(&self.note)),
            ("{{style}}", include_str!("page/page.css").to_owned()),
            ("{{schematic}}", schematic),
            // no text in it may end the element around it
            ("{{data}}", data.replace('<', "\\u003c")),
            ("{{program}}", PROGRAM.concat()),
        ];
        let mut html = String::new();
        let mut rest = include_str!("page/page.html");
        while let Some(at) = rest.find("{{") {
            html.push_str(&rest[..at]);
            rest = &rest[at..];
            match parts.iter().find(|(name, _)| rest.starts_with(name)) {
                Some((name, text)) => {
                    html.push_str(text);
                    rest = &rest[name.len()..];
                }
                None => {
                    html.push_str("{{");
                    rest = &rest[2..];
                }
            }
        }
        html.push_str(rest);
        html
    }
}

/// Text that can mean no markup.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_no_markup_and_parts_are_not_read_again() {
        let page = Page {
            title: "</title><script>{{data}}".into(),
            note: "a & b".into(),
            timescale: None,
            schematic: Err("<none>".into()),
            signals: Signals::default(),
            route: None,
        };
        let html = page.html();
        assert!(html.contains("&lt;/title&gt;&lt;script&gt;{{data}}") && html.contains("a &amp; b"));
        assert!(html.contains("<p class=\"none\">&lt;none&gt;</p>"));
        assert!(html.contains(r#"{"title":"\u003c/title>\u003cscript>{{data}}""#));
        assert_eq!(html.matches("</script>").count(), 2);
        assert!(
            !html.contains("http://") || html.matches("http://").count() == html.matches("http://www.w3.org/").count()
        );
    }
}
