//! The photographs of the documentation, taken again by their script: they show what the program shows today.

use std::path::Path;
use std::process::Command;

use needs::needs;
use serde_json::Value as Json;

const PICTURES: [&str; 4] = ["view.png", "view-dark.png", "arc-dark.png", "gtkwave.png"];

/// Compares two pictures by squares of 8 × 8 points, in which fonts of another machine make little difference, and tells
/// the share of squares whose mean colour differs.
const COMPARE: &str = "
    const square = async (address) => {
        const image = new Image();
        image.src = address;
        await new Promise((loaded, failed) => [image.onload, image.onerror] = [loaded, failed]);
        const canvas = document.createElement('canvas');
        [canvas.width, canvas.height] = [image.width, image.height];
        const context = canvas.getContext('2d');
        context.drawImage(image, 0, 0);
        const data = context.getImageData(0, 0, image.width, image.height).data;
        const columns = Math.ceil(image.width / 8);
        const means = new Float64Array(columns * Math.ceil(image.height / 8) * 3);
        for (let y = 0; y < image.height; y++)
            for (let x = 0; x < image.width; x++)
                for (let c = 0; c < 3; c++)
                    means[((y >> 3) * columns + (x >> 3)) * 3 + c] += data[(y * image.width + x) * 4 + c] / 64;
        return { size: [image.width, image.height], means };
    };
    (async () => {
        const seen = [];
        for (const pair of pairs) {
            const [old, now] = [await square(pair[0]), await square(pair[1])];
            let differ = 0;
            for (let i = 0; i < now.means.length; i += 3)
                differ += [0, 1, 2].some((c) => Math.abs(now.means[i + c] - old.means[i + c]) > 12);
            seen.push({ old: old.size, now: now.size, differ: differ * 3 / now.means.length });
        }
        const pre = document.createElement('pre');
        pre.id = 'seen';
        pre.textContent = JSON.stringify(seen);
        document.body.append(pre);
    })();";

#[needs(chromium, gtkwave, imagemagick)]
#[test]
fn the_photographs_are_current() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/pictures");
    let made = Command::new(pictures.join("make.sh"))
        .arg(folder.path())
        .env("DISCRETA", env!("CARGO_BIN_EXE_discreta"))
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let address = |path: &Path| format!("file://{}", path.display());
    let pairs = PICTURES.map(|name| [address(&pictures.join(name)), address(&folder.path().join(name))]);
    let page = folder.path().join("compare.html");
    let pairs = serde_json::to_string(&pairs).unwrap();
    std::fs::write(&page, format!("<!doctype html><body><script>const pairs = {pairs};{COMPARE}</script></body>"))
        .unwrap();
    let told = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"])
        .args([
            "--enable-logging=stderr",
            "--v=0",
            "--dump-dom",
            "--virtual-time-budget=60000",
            "--allow-file-access-from-files",
        ])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&told.stdout).into_owned();
    let seen = dom.split_once("<pre id=\"seen\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    let (seen, _) = seen.unwrap_or_else(|| panic!("{}", String::from_utf8_lossy(&told.stderr)));
    let seen: Vec<Json> = serde_json::from_str(seen).unwrap();
    for (name, seen) in PICTURES.iter().zip(&seen) {
        println!("{name}: {seen}");
        let differ = seen["differ"].as_f64().unwrap();
        assert!(
            seen["old"] == seen["now"] && differ < 0.005,
            "docs/pictures/{name} is not current; renew it: docs/pictures/make.sh\n{seen}"
        );
    }
    assert_eq!(seen.len(), PICTURES.len());
}
