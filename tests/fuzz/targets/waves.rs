//! Reads a waveform whole, as the commands do.

use std::path::Path;

use discreta_wave::play::Tracks;
use discreta_wave::read::Waves;

/// More values than this, as text, are not looked at: one change of a wide variable is many bytes.
const MANY: u64 = 1 << 20;

/// Reads the bytes of a file, loads all of its variables and goes through them.
pub fn read(bytes: &[u8], format: &str) {
    let Ok(mut waves) = Waves::of_bytes(Path::new(format), bytes.to_vec()) else { return };
    let all: Vec<usize> = (0..waves.vars().len()).collect();
    assert!(waves.end() >= waves.start());
    let names: std::collections::HashSet<&str> = waves.vars().iter().map(|var| var.name.as_str()).collect();
    assert_eq!(names.len(), all.len(), "a name stands for two variables");
    let Ok(loaded) = waves.load_all(&all) else { return };
    let mut size = 0;
    for series in &loaded {
        let mut before = None;
        for (time, value) in series.changes() {
            assert!(before.is_none_or(|before| before < time), "time does not go on");
            before = Some(time);
            size += value.len() as u64 + 1;
            if size > MANY {
                return;
            }
        }
    }
    drop(loaded);
    let Ok(tracks) = Tracks::load(&mut waves, &all) else { return };
    let mut player = tracks.play(&waves);
    while player.time().is_some() {
        player.step(&mut |_, _| {});
    }
}
