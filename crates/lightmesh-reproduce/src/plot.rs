//! Lines over labelled axes, as SVG that prints well.

use plotters::coord::Shift;
use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;

pub(crate) use plotters::chart::SeriesLabelPosition;

use crate::error::Error;
use crate::picture::data_uri;
use crate::report::{Figure, Panel};

/// A plot of some lines.
pub(crate) struct Plot<'a> {
    pub(crate) caption: &'a str,
    /// Label of the horizontal axis, with its unit.
    pub(crate) x: &'a str,
    /// Label of the vertical axis, with its unit.
    pub(crate) y: &'a str,
    /// Where the legend has room.
    pub(crate) names: SeriesLabelPosition,
    /// Whether both axes are logarithmic.
    pub(crate) logarithmic: bool,
    pub(crate) lines: Vec<Line>,
}

/// A line and its name in the legend.
pub(crate) struct Line {
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, f64)>,
}

/// Colours of the lines, dark on white.
const COLORS: [RGBColor; 8] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 90, 181),
    RGBColor(200, 40, 30),
    RGBColor(0, 130, 90),
    RGBColor(150, 90, 0),
    RGBColor(120, 60, 160),
    RGBColor(110, 110, 110),
    RGBColor(0, 150, 170),
];

const SIZE: (u32, u32) = (760, 440);

/// Formats a number of an axis with three digits.
fn tick(number: &f64) -> String {
    let digits = (2 - number.abs().max(1e-6).log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{number:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

impl Plot<'_> {
    /// Draws the plot as a figure of one panel.
    pub(crate) fn figure(&self) -> Result<Figure, Error> {
        let mut svg = String::new();
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        self.draw(&area).map_err(|error| Error::Plot(error.to_string()))?;
        drop(area);
        let panel = Panel { label: String::new(), image: data_uri("image/svg+xml", svg.as_bytes()) };
        Ok(Figure { caption: self.caption.to_owned(), panels: vec![panel] })
    }

    fn draw(&self, area: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), Box<dyn std::error::Error>> {
        area.fill(&WHITE)?;
        let points = || self.lines.iter().flat_map(|line| &line.points).filter(|(x, y)| x.is_finite() && y.is_finite());
        let range = |of: fn(&(f64, f64)) -> f64| {
            let (low, high) = points().map(of).fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
            if low <= high { (low, high) } else { (1.0, 2.0) }
        };
        let ((left, right), (bottom, top)) = (range(|p| p.0), range(|p| p.1));
        let mut builder = ChartBuilder::on(area);
        builder.margin(12).x_label_area_size(44).y_label_area_size(64);
        if self.logarithmic {
            // Less than a decade has its ticks at powers of two.
            let wide = |low: f64, high: f64| {
                let (low, high) = (low.max(1e-9) / 1.15, high.max(2e-9) * 1.15);
                (low..high).log_scale().base(if high / low < 20.0 { 2.0 } else { 10.0 })
            };
            let mut chart = builder.build_cartesian_2d(wide(left, right), wide(bottom, top))?;
            self.draw_lines(&mut chart)
        } else {
            let room = 0.05 * (top - bottom).max(1e-9);
            let mut chart = builder.build_cartesian_2d(left..right, bottom - room..top + room)?;
            self.draw_lines(&mut chart)
        }
    }

    fn draw_lines<'b, X, Y>(
        &self,
        chart: &mut ChartContext<'b, SVGBackend<'b>, Cartesian2d<X, Y>>,
    ) -> Result<(), Box<dyn std::error::Error>>
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .axis_desc_style(FONT)
            .label_style(FONT)
            .x_label_formatter(&tick)
            .y_label_formatter(&tick)
            .draw()?;
        for (line, color) in self.lines.iter().zip(COLORS.iter().cycle()) {
            let style = color.stroke_width(2);
            chart
                .draw_series(LineSeries::new(line.points.iter().copied(), style))?
                .label(line.name.as_str())
                .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 22, y)], style));
            if line.points.len() <= 20 {
                chart.draw_series(line.points.iter().map(|&point| Circle::new(point, 3, color.filled())))?;
            }
        }
        let mut labels = chart.configure_series_labels();
        labels.position(self.names.clone());
        labels.background_style(WHITE.mix(0.85)).border_style(BLACK.mix(0.3)).label_font(FONT).draw()?;
        Ok(())
    }
}

const FONT: (&str, u32) = ("sans-serif", 15);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short() {
        assert_eq!(
            [0.0, 0.1 + 0.2, 1.000_000_000_4, 20.0, 1500.0, -0.25].map(|x| tick(&x)),
            ["0", "0.3", "1", "20", "1500", "-0.25"]
        );
    }

    #[test]
    fn a_plot_has_its_lines_and_units() {
        for logarithmic in [false, true] {
            let line = Line { name: "mesh".into(), points: vec![(5.0, 1.0), (10.0, 2.0), (100.0, f64::NAN)] };
            let plot = Plot {
                caption: "times",
                x: "lights",
                y: "seconds",
                names: SeriesLabelPosition::UpperLeft,
                logarithmic,
                lines: vec![line],
            };
            let figure = plot.figure().expect("plot");
            assert!(figure.panels[0].image.starts_with("data:image/svg+xml;base64,"));
        }
    }
}
