//! A writer of SVG: elements, attributes, text, and numbers that look the same everywhere.

use std::fmt::Write as _;

/// An SVG document that is being written.
pub(crate) struct Svg {
    text: String,
    open: Vec<&'static str>,
}

impl Svg {
    pub(crate) const fn new() -> Svg {
        Svg { text: String::new(), open: Vec::new() }
    }

    fn start(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        for _ in 0..self.open.len() {
            self.text.push_str("  ");
        }
        let _ = write!(self.text, "<{tag}");
        for (name, value) in attributes.iter().filter(|(_, value)| !value.is_empty()) {
            let _ = write!(self.text, " {name}=\"{}\"", escape(value));
        }
    }

    /// Begins an element that has others inside.
    pub(crate) fn open(&mut self, tag: &'static str, attributes: &[(&str, &str)]) {
        self.start(tag, attributes);
        self.text.push_str(">\n");
        self.open.push(tag);
    }

    /// Ends the element that was begun last.
    pub(crate) fn close(&mut self) {
        if let Some(tag) = self.open.pop() {
            for _ in 0..self.open.len() {
                self.text.push_str("  ");
            }
            let _ = writeln!(self.text, "</{tag}>");
        }
    }

    /// An element without content.
    pub(crate) fn leaf(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        self.start(tag, attributes);
        self.text.push_str("/>\n");
    }

    /// An element with text in it.
    pub(crate) fn text(&mut self, tag: &str, attributes: &[(&str, &str)], text: &str) {
        self.start(tag, attributes);
        let _ = writeln!(self.text, ">{}</{tag}>", escape(text));
    }

    /// The style sheet, as it is: it must hold no `]]>`.
    pub(crate) fn style(&mut self, rules: &str) {
        let _ = writeln!(self.text, "  <style><![CDATA[{rules}]]></style>");
    }

    /// A line between two points.
    pub(crate) fn line(&mut self, class: &str, from: [f64; 2], to: [f64; 2]) {
        let [x1, y1, x2, y2] = [from[0], from[1], to[0], to[1]].map(number);
        self.leaf("line", &[("class", class), ("x1", &x1), ("y1", &y1), ("x2", &x2), ("y2", &y2)]);
    }

    /// A circle.
    pub(crate) fn circle(&mut self, class: &str, at: [f64; 2], radius: f64) {
        let [x, y, r] = [at[0], at[1], radius].map(number);
        self.leaf("circle", &[("class", class), ("cx", &x), ("cy", &y), ("r", &r)]);
    }

    /// A rectangle.
    pub(crate) fn rectangle(&mut self, class: &str, [x, y, width, height]: [f64; 4]) {
        let [x, y, width, height] = [x, y, width, height].map(number);
        self.leaf("rect", &[("class", class), ("x", &x), ("y", &y), ("width", &width), ("height", &height)]);
    }

    /// Text at a point; `anchor` is `start`, `middle` or `end`.
    pub(crate) fn label(&mut self, class: &str, at: [f64; 2], anchor: &str, text: &str) {
        let [x, y] = at.map(number);
        self.text("text", &[("class", class), ("x", &x), ("y", &y), ("text-anchor", anchor)], text);
    }

    /// The document.
    pub(crate) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.text
    }
}

/// A number in hundredths, without zeros at its end.
pub(crate) fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Text that can mean no markup. What no XML file may hold is left out.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c if !crate::safe::is_plain(c) || matches!(c, '\u{fffe}' | '\u{ffff}') => {}
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let texts = [0.0, -0.001, 1.0, 1.5, -2.25, 100.0, 3.999].map(number);
        assert_eq!(texts, ["0", "0", "1", "1.5", "-2.25", "100", "4"]);
    }

    #[test]
    fn text_is_no_markup() {
        let mut svg = Svg::new();
        svg.open("g", &[("class", "a\"b")]);
        svg.text("text", &[], "<x> & \u{7}y\"");
        assert_eq!(svg.finish(), "<g class=\"a&quot;b\">\n  <text>&lt;x&gt; &amp; y&quot;</text>\n</g>\n");
    }
}
