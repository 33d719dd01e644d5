//! `#[needs(iverilog, yosys)]` before `#[test]`: where a tool is missing the test is ignored, with what to install as the
//! reason. It is a crate of its own, used by tests alone, so that who uses `discreta` builds and runs nothing for it.

use proc_macro::{TokenStream, TokenTree};

include!("tools.rs");

/// Ignores the test below where one of these tools is not on `PATH`.
#[proc_macro_attribute]
pub fn needs(tools: TokenStream, test: TokenStream) -> TokenStream {
    let mut attributes = test.clone().into_iter().take_while(|t| !matches!(t, TokenTree::Ident(_)));
    if !attributes.any(|t| t.to_string() == "[test]") {
        return fault("`#[needs(…)]` stands before `#[test]`");
    }
    let mut reasons = Vec::new();
    for token in tools {
        let name = match token {
            TokenTree::Ident(name) => name.to_string(),
            TokenTree::Punct(p) if p.as_char() == ',' => continue,
            other => return fault(&format!("no tool: `{other}`")),
        };
        let Some((_, _, install)) = TOOLS.iter().find(|t| t.0 == name) else {
            return fault(&format!("`{name}` is no tool that `tests/needs` knows"));
        };
        if env!("MISSING_TOOLS").split(' ').any(|m| m == name) {
            reasons.push(*install);
        }
    }
    if reasons.is_empty() {
        return test;
    }
    let mut ignored: TokenStream = format!("#[ignore = \"needs {}\"]", reasons.join("; ")).parse().unwrap();
    ignored.extend(test);
    ignored
}

fn fault(message: &str) -> TokenStream {
    format!("compile_error!({message:?});").parse().unwrap()
}
