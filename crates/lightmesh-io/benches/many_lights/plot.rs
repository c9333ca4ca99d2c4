//! A log-log plot as an SVG file.

use std::fmt::Write as _;

/// One line of the plot.
pub(crate) struct Series<'a> {
    pub name: &'a str,
    /// In units of the axes, all above 0.
    pub points: Vec<(f64, f64)>,
}

/// Lines over two logarithmic axes, named with their units.
pub(crate) struct Plot<'a> {
    pub x: &'a str,
    pub y: &'a str,
    pub series: &'a [Series<'a>],
}

/// Size of the picture and its margins, pixels.
const SIZE: (f64, f64) = (720.0, 440.0);
const MARGIN: (f64, f64, f64, f64) = (70.0, 150.0, 20.0, 55.0);

/// Blue, orange and green that are told apart with any colour vision (Okabe and Ito 2008).
const COLORS: [&str; 3] = ["#0072b2", "#d55e00", "#009e73"];

/// Whole decades, and where values go on the picture.
struct Axis {
    first: i32,
    last: i32,
    start: f64,
    end: f64,
}

impl Axis {
    fn over(values: impl Iterator<Item = f64>, start: f64, end: f64) -> Self {
        let (min, max) = values.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
        Self { first: min.log10().floor() as i32, last: max.log10().ceil() as i32, start, end }
    }

    fn place(&self, value: f64) -> f64 {
        let part = (value.log10() - f64::from(self.first)) / f64::from(self.last - self.first);
        self.start + part * (self.end - self.start)
    }

    fn decades(&self) -> impl Iterator<Item = f64> {
        (self.first..=self.last).map(|d| 10_f64.powi(d))
    }
}

impl Plot<'_> {
    /// The file's text.
    pub(crate) fn svg(&self) -> String {
        let ((width, height), (left, right, top, bottom)) = (SIZE, MARGIN);
        let points = || self.series.iter().flat_map(|s| &s.points);
        let x = Axis::over(points().map(|p| p.0), left, width - right);
        let y = Axis::over(points().map(|p| p.1), height - bottom, top);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"sans-serif\" font-size=\"13\" fill=\"#222\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        );
        let mut line = |text: String| svg.extend([text.as_str(), "\n"]);

        // Decades.
        for value in x.decades() {
            let at = x.place(value);
            line(format!("<path d=\"M{at:.1} {:.1}V{:.1}\" stroke=\"#ddd\"/>", y.start, y.end));
            line(format!("<text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{value}</text>", y.start + 20.0));
        }
        for value in y.decades() {
            let at = y.place(value);
            line(format!("<path d=\"M{:.1} {at:.1}H{:.1}\" stroke=\"#ddd\"/>", x.start, x.end));
            line(format!("<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{value}</text>", x.start - 8.0, at + 4.0));
        }

        // Names of the axes.
        let (middle, low) = (0.5 * (x.start + x.end), height - 12.0);
        line(format!("<text x=\"{middle:.1}\" y=\"{low:.1}\" text-anchor=\"middle\">{}</text>", self.x));
        let middle = 0.5 * (y.start + y.end);
        line(format!(
            "<text transform=\"translate(18 {middle:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            self.y
        ));

        // Lines, their points, and their names at their ends.
        for (series, color) in self.series.iter().zip(COLORS.iter().cycle()) {
            let places: Vec<_> = series.points.iter().map(|p| (x.place(p.0), y.place(p.1))).collect();
            let path = places.iter().fold(String::new(), |mut path, (px, py)| {
                let _ = write!(path, "{}{px:.1} {py:.1}", if path.is_empty() { 'M' } else { 'L' });
                path
            });
            line(format!("<path d=\"{path}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>"));
            for (px, py) in &places {
                line(format!("<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"3.5\" fill=\"{color}\"/>"));
            }
            if let Some((px, py)) = places.last() {
                let (tx, ty) = (px + 9.0, py + 4.0);
                line(format!("<text x=\"{tx:.1}\" y=\"{ty:.1}\" fill=\"{color}\">{}</text>", series.name));
            }
        }
        svg + "</svg>\n"
    }
}
