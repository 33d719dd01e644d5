//! What the documents say of their methods, held against what was measured.

use serde::Serialize;

use super::equipment::Gates;
use super::{Equipment, Group, Motion, Row, SetKind, Variant};

/// A claim and what was found. Whether it holds is computed from the measures alone.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Claim {
    /// What is claimed, in our words.
    pub claim: String,
    /// The document, and its own words.
    pub source: &'static str,
    /// What was measured.
    pub measured: String,
    /// Whether it holds; none if it could not be measured.
    pub holds: Option<bool>,
}

/// Rows by the name of their method.
struct Measured<'a> {
    groups: &'a [Group],
    equipment: &'a [Equipment],
    bits: u32,
}

/// Every claim.
#[must_use]
pub fn claims(groups: &[Group], equipment: &[Equipment], bits: u32) -> Vec<Claim> {
    let all = Measured { groups, equipment, bits };
    let mut claims = Vec::new();
    claims.extend(all.one_blu());
    claims.extend(all.accumulated());
    claims.extend(all.cycles());
    claims.extend(all.speed());
    claims.extend(all.grossman());
    claims
}

const BLU: &str = "A: «най-голямото отклонение е най-много една дискрета»";
const PULSE: &str = "C: «с точностью до одного импульса»";
const CYCLES: &str = "B: «2^p … независимо от дължината на кривата»";
const BEST: &str = "C: «наиболее выгодной является интерполяция … по методу Гроссмана»";

const GROSSMAN: &str = "grossman (ef-circle)";

fn claim(claim: impl Into<String>, source: &'static str, found: Option<(String, bool)>) -> Claim {
    let (measured, holds) = found.map_or_else(|| ("not measured".to_owned(), None), |(m, h)| (m, Some(h)));
    Claim { claim: claim.into(), source, measured, holds }
}

impl Measured<'_> {
    fn motion(&self, kind: SetKind, name: &str) -> Option<&Motion> {
        let group = self.groups.iter().find(|g| g.kind == kind)?;
        group.rows.iter().find(|r: &&Row| r.method == name).map(|r| &r.motion)
    }

    fn one_blu(&self) -> Vec<Claim> {
        let most = |kind, name: &str| self.motion(kind, name).map(|m| m.deviation.most);
        let of_arcs = |name: &str| Some(most(SetKind::Quarters, name)?.max(most(SetKind::Arcs, name)?));
        let at_most = |found: Option<f64>| found.map(|d| (format!("{d:.4} BLU"), d <= 1.0));
        let both = of_arcs("dda-circle").zip(of_arcs("dda-circle --parallel"));
        let circle = both.map(|(s, p)| (format!("{s:.4} BLU sequential, {p:.4} parallel"), s.max(p) <= 1.0));
        vec![
            claim("At most one BLU off: line by DDA", BLU, at_most(most(SetKind::Lines, "dda-line"))),
            claim("At most one BLU off: circle by DDA", BLU, circle),
            claim("Exact to one pulse: circle by Grossman", PULSE, at_most(of_arcs(GROSSMAN))),
            claim("Exact to one pulse: circle by Karibsky", PULSE, at_most(of_arcs("karibsky"))),
        ]
    }

    fn accumulated(&self) -> Vec<Claim> {
        let of = [(SetKind::Lines, "ef-line"), (SetKind::Quarters, GROSSMAN), (SetKind::Quarters, "karibsky")];
        let motions: Option<Vec<&Motion>> = of.iter().map(|&(kind, name)| self.motion(kind, name)).collect();
        let found = motions.map(|all| {
            let wrong: u64 = all.iter().filter_map(|m| m.f_wrong).sum();
            let missed: u64 = all.iter().map(|m| m.segments - m.exact).sum();
            let segments: u64 = all.iter().map(|m| m.segments).sum();
            let measured = format!("F ≠ F(x, y) after {wrong} clocks; {missed} of {segments} ends missed");
            (measured, wrong == 0 && missed == 0)
        });
        vec![claim(
            "No accumulated error: methods by evaluation function",
            "C: «не имеет накопленной погрешности»",
            found,
        )]
    }

    fn cycles(&self) -> Vec<Claim> {
        let expected = 1_u64 << self.bits;
        let line = self.motion(SetKind::Lines, "dda-line").map(|m| {
            let same = m.clocks.most == expected && m.clocks.mean == expected as f64;
            (format!("{:.1} on the mean, {} at most; 2^p = {expected}", m.clocks.mean, m.clocks.most), same)
        });
        let settings = ["", " --half-preload", " --parallel", " --parallel --half-preload"];
        let all: Option<Vec<[u64; 2]>> = settings
            .iter()
            .map(|with| self.motion(SetKind::Quarters, &format!("dda-circle{with}"))?.clocks.of_long)
            .collect();
        let bounds = all.and_then(|all| Some([all.iter().map(|c| c[0]).min()?, all.iter().map(|c| c[1]).max()?]));
        let circle = bounds.map(|[least, most]| {
            let measured = format!("{least}…{most} a quarter from R = {} on; 2^p = {expected}", expected / 16);
            (measured, least == expected && most == expected)
        });
        vec![
            claim("2^p clocks whatever the length: line by DDA", CYCLES, line),
            claim("2^p clocks whatever the length: circle by DDA", CYCLES, circle),
        ]
    }

    fn speed(&self) -> Vec<Claim> {
        let speed = |kind, name: &str| self.motion(kind, name).and_then(|m| m.speed);
        let of_arcs = speed(SetKind::Quarters, GROSSMAN).zip(speed(SetKind::Quarters, "karibsky"));
        let changes = of_arcs.map(|(g, k)| {
            let measured = format!("{:.2} times by Grossman, {:.2} by Karibsky", g.ratio, k.ratio);
            (measured, [g, k].iter().all(|s| (1.35..1.45).contains(&s.ratio)))
        });
        let slope = speed(SetKind::Lines, "ef-line").map(|s| {
            let measured = format!("{:.3}…{:.3} BLU a clock, {:.3} times", s.least, s.greatest, s.ratio);
            (measured, s.ratio > 1.01)
        });
        let constant = |kind, name: &str| {
            let motion = self.motion(kind, name)?;
            let (raw, longer) = (motion.speed?, motion.speed_141?);
            let measured = format!(
                "{:.3}…{:.3} of the speed commanded, {:.3} times; without it {:.3}…{:.3}, {:.3} times",
                longer.least, longer.greatest, longer.ratio, raw.least, raw.greatest, raw.ratio
            );
            Some((measured, longer.ratio < 1.01))
        };
        let fewer = |kind, fast: &str, standard: &str| {
            let (fast, standard) = (self.motion(kind, fast)?.clocks, self.motion(kind, standard)?.clocks);
            let measured = format!("{:.1} clocks on the mean against {:.1}", fast.mean, standard.mean);
            Some((measured, fast.mean < standard.mean && fast.most <= standard.most))
        };
        const INTERVAL: &str = "B: «постоянна скорост … 1,41 пъти по-дълъг»";
        const FASTER: &str = "B: «С цел ускоряване на процеса»";
        vec![
            claim(
                "The speed changes 1.4 times along an arc: Grossman and Karibsky",
                "C: «изменение скорости в процессе обработки в 1,4 раза»",
                changes,
            ),
            claim(
                "The speed depends on the slope: standard line",
                "C: «зависимость скорости обработки от угла наклона»",
                slope,
            ),
            claim(
                "×1.41 keeps the speed constant: accelerated line",
                INTERVAL,
                constant(SetKind::Lines, "ef-line-fast"),
            ),
            claim(
                "×1.41 and ×1.73 keep the speed constant: line in space",
                INTERVAL,
                constant(SetKind::Space, "ef-line-3d"),
            ),
            claim("The accelerated line takes fewer clocks", FASTER, fewer(SetKind::Lines, "ef-line-fast", "ef-line")),
            claim(
                "The accelerated circle takes fewer clocks",
                FASTER,
                fewer(SetKind::Quarters, "ef-circle-fast", GROSSMAN),
            ),
            claim(
                "Normalising takes fewer clocks: line by DDA",
                "A: «позволява да се ускори изчислителния процес»",
                fewer(SetKind::Lines, "dda-line --normalise", "dda-line"),
            ),
        ]
    }

    /// Document C compares Grossman's method with Karibsky's.
    fn grossman(&self) -> Vec<Claim> {
        let made = |name: &str| self.equipment.iter().find(|e| e.method == name);
        let of_both = || made(GROSSMAN).zip(made("karibsky"));
        let equipment = of_both().and_then(|(g, k)| {
            let (g, k) = (g.gates?, k.gates?);
            let measured = format!(
                "{} gates, {} inverters, {} flip-flops against {}, {}, {}",
                g.gates, g.inverters, g.flip_flops, k.gates, k.inverters, k.flip_flops
            );
            let less = g.gates + g.inverters <= k.gates + k.inverters && g.flip_flops <= k.flip_flops;
            Some((measured, less))
        });
        let least = made(GROSSMAN).and_then(|g| self.least_equipment(g));
        let simple = of_both()
            .map(|(g, k)| (format!("{} elements against {}", g.elements, k.elements), g.elements <= k.elements));
        let motions = self.motion(SetKind::Quarters, GROSSMAN).zip(self.motion(SetKind::Quarters, "karibsky"));
        let accurate = motions.map(|(g, k)| {
            let (g, k) = (g.deviation, k.deviation);
            let measured =
                format!("at most {:.4} BLU, {:.4} on the mean, against {:.4}, {:.4}", g.most, g.mean, k.most, k.mean);
            (measured, g.most <= k.most && g.mean <= k.mean)
        });
        let depth = of_both().and_then(|(g, k)| Some((g.gates?.depth, k.gates?.depth)));
        let quick = motions.zip(depth).map(|((g, k), (deep_g, deep_k))| {
            let (g, k) = (g.clocks.mean, k.clocks.mean);
            (format!("{g:.1} clocks of {deep_g} gates against {k:.1} of {deep_k}"), g <= k && deep_g <= deep_k)
        });
        let against = |what: &str| format!("Grossman against Karibsky: {what}");
        vec![
            claim(against("least equipment"), BEST, equipment),
            claim(against("most accurate"), BEST, accurate),
            claim(against("simplest"), BEST, simple),
            claim(against("fastest"), BEST, quick),
            claim("Grossman against every circle here: least equipment", BEST, least),
        ]
    }

    /// Whether no other method that draws arcs takes fewer gates, with inverters, than this one.
    fn least_equipment(&self, of: &Equipment) -> Option<(String, bool)> {
        let names: Vec<String> = Variant::ARCS.iter().map(Variant::name).collect();
        let all = self.equipment.iter().filter(|e| names.contains(&e.method));
        let (least, method) = all
            .map(|e| Some((e.gates?, &e.method)))
            .collect::<Option<Vec<_>>>()?
            .into_iter()
            .min_by_key(|(g, _)| g.all())?;
        let (own, holds) = (of.gates?, method == &of.method);
        let told = |g: Gates| format!("{} gates, {} inverters, {} flip-flops", g.gates, g.inverters, g.flip_flops);
        Some((format!("{}; the least is {method}: {}", told(own), told(least)), holds))
    }
}
