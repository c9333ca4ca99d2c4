//! The page: one file, readable on a phone and in print, without scripts or anything from elsewhere.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::report::{Cell, Claim, Figure, Report, Section, Table, Verdict};

const STYLE: &str = "
:root { color-scheme: light; --ink: #1b1b1b; --faint: #666; --rule: #ddd; }
body { font: 16px/1.5 Georgia, 'Times New Roman', serif; color: var(--ink); background: #fff; max-width: 60rem; margin: 0 auto; padding: 1rem; }
h1, h2, th, .verdict, figcaption, nav { font-family: system-ui, sans-serif; }
h1 { font-size: 1.6rem; line-height: 1.25; } h2 { margin-top: 3rem; border-top: 1px solid var(--rule); padding-top: 1rem; font-size: 1.25rem; }
.of { color: var(--faint); margin-top: -.6rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font: 14px/1.4 system-ui, sans-serif; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--faint); padding: .4rem 0; }
th, td { padding: .25rem .7rem; vertical-align: top; border-bottom: 1px solid var(--rule); text-align: right; }
th:first-child, td:first-child, td.words, th.words { text-align: left; } th { font-weight: 600; vertical-align: bottom; }
figure { margin: 1.2rem 0; } figcaption { font-size: .85rem; color: var(--faint); }
.panels { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(15rem, 100%), 1fr)); gap: .6rem; } .panels.single { grid-template-columns: 1fr; }
.panels img { width: 100%; height: auto; display: block; } .panels span { font: 13px system-ui, sans-serif; }
ul.claims { padding-left: 1.1rem; font: 15px/1.45 system-ui, sans-serif; } .claims p { margin: .1rem 0 .7rem; color: var(--faint); font-size: .88em; }
td.words { min-width: 9rem; }
.verdict { font-size: .8rem; font-weight: 600; padding: .05rem .45rem; border-radius: .6rem; white-space: nowrap; }
.holds { background: #d9f0df; } .differently { background: #fdeec8; } .fails { background: #f8d7d3; }
@media print { body { max-width: none; } h2 { break-after: avoid; } figure, table { break-inside: avoid; } }
";

/// The whole page.
pub(crate) fn html(report: &Report) -> String {
    let claims = || report.sections.iter().flat_map(|section| &section.claims);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Light meshes, reproduced" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Light meshes, reproduced" }
                p {
                    "The experiments of V. A. Debelov and I. M. Sevastyanov, “Original approach to simulation of soft shadows and diffuse \
                     color bleeding in ray tracing” (GraphiCon 2001), with lightmesh " (report.version) ", " (report.date) ", "
                    (report.threads) " threads" @if report.quick { ". Sizes are small (--quick): times mean little" } ". Scenes are our own; \
                     error is the root mean square difference from exact shadow rays over the picture's mean."
                }
                nav {
                    @for (i, section) in report.sections.iter().enumerate() {
                        @if i > 0 { " · " }
                        a href={ "#" (section.id) } { (section.title) }
                    }
                }
                @if claims().next().is_some() {
                    h2 { "The paper's claims" }
                    (claims_list(claims()))
                }
                @for section in &report.sections { (section_html(section)) }
            }
        }
    }
    .into_string()
}

fn section_html(section: &Section) -> Markup {
    html! {
        h2 id=(section.id) { (section.title) }
        p.of { (section.paper) }
        @for paragraph in &section.text { p { (paragraph) } }
        @for table in &section.tables { (table_html(table)) }
        @for figure in &section.figures { (figure_html(figure)) }
        @if !section.claims.is_empty() { (claims_list(section.claims.iter())) }
    }
}

fn table_html(table: &Table) -> Markup {
    html! {
        div.wide {
            table {
                caption { (table.caption) }
                thead { tr { @for column in &table.columns { th scope="col" { (column) } } } }
                tbody {
                    @for row in &table.rows {
                        tr { @for cell in row { (cell_html(cell)) } }
                    }
                }
            }
        }
    }
}

fn cell_html(cell: &Cell) -> Markup {
    match cell {
        Cell::Nothing(()) => html! { td { "–" } },
        Cell::Count(number) => html! { td { (grouped(&number.to_string())) } },
        Cell::Number(number) => html! { td { (rounded(*number)) } },
        Cell::Text(text) => html! { td.words { (text) } },
    }
}

fn figure_html(figure: &Figure) -> Markup {
    html! {
        figure {
            div.panels.single[figure.panels.len() == 1] {
                @for panel in &figure.panels {
                    div {
                        img src=(panel.image) alt=(if panel.label.is_empty() { &figure.caption } else { &panel.label });
                        @if !panel.label.is_empty() { span { (panel.label) } }
                    }
                }
            }
            figcaption { (figure.caption) }
        }
    }
}

fn claims_list<'a>(claims: impl Iterator<Item = &'a Claim>) -> Markup {
    html! {
        ul.claims {
            @for claim in claims {
                @let class = match claim.verdict { Verdict::Holds => "holds", Verdict::Differently => "differently", Verdict::Fails => "fails" };
                li {
                    (claim.claim) " " span class={ "verdict " (class) } { (claim.verdict.words()) }
                    p {
                        @if let Some(paper) = claim.paper { "paper " (with_unit(paper, &claim.unit)) ", " }
                        "here " b { (with_unit(claim.ours, &claim.unit)) } ". " (claim.note)
                    }
                }
            }
        }
    }
}

/// A number and its unit, which stands close to it where it is a sign.
fn with_unit(number: f64, unit: &str) -> String {
    let space = if unit.starts_with(['×', '%']) || unit.is_empty() { "" } else { "\u{a0}" };
    format!("{}{space}{unit}", rounded(number))
}

/// Three digits.
fn rounded(number: f64) -> String {
    let digits = match number.abs() {
        0.0 => 0,
        x if x >= 100.0 => 0,
        x => (2 - x.log10().floor() as i32).clamp(0, 6) as usize,
    };
    let plain = format!("{:.digits$}", number.abs());
    let (whole, rest) = plain.split_once('.').map_or((plain.as_str(), None), |(whole, rest)| (whole, Some(rest)));
    let sign = if number < 0.0 { "−" } else { "" };
    sign.to_owned() + &grouped(whole) + &rest.map_or(String::new(), |rest| format!(".{rest}"))
}

/// Digits with thousands set apart.
fn grouped(digits: &str) -> String {
    let mut grouped = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let texts = [1_234_567.0, 123.4, 12.345, 1.5, 0.012_34, -0.5, 0.0, 999.0].map(rounded);
        assert_eq!(texts, ["1,234,567", "123", "12.3", "1.50", "0.0123", "−0.500", "0", "999"]);
    }
}
