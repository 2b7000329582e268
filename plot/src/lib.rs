//! Line pictures as SVG: curves over a thin grid, the legend above the plot where it covers nothing. However many points a curve
//! has, the file stays small: what cannot be seen is left out (`thin`).
//!
//! Knows nothing of friction and needs no font on this machine.

mod thin;

use std::ops::Range;

use anyhow::{Result, anyhow};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;
pub use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A colour that stays apart from the others for the colour-blind (Okabe and Ito).
pub const BLUE: RGBColor = RGBColor(0, 114, 178);
/// As [`BLUE`].
pub const ORANGE: RGBColor = RGBColor(213, 94, 0);
/// As [`BLUE`].
pub const GREEN: RGBColor = RGBColor(0, 158, 115);
/// As [`BLUE`].
pub const GREY: RGBColor = RGBColor(120, 120, 120);

/// A colour for part 0 to 1 of a family of curves, from dark to light (viridis, which the colour-blind see as well); its lightest
/// end, too faint on white, is left out.
pub fn ramp(part: f64) -> RGBColor {
    ViridisRGB::get_color(0.9 * part)
}

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stroke {
    /// A line.
    Solid,
    /// A broken line.
    Dashed,
    /// Open circles at some of the points, to lie on another curve.
    Marks,
}

/// A curve and its entry in the legend.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Its name in the legend; none if empty.
    pub label: String,
    /// Its points, in their order.
    pub points: Vec<[f64; 2]>,
    /// How it is drawn.
    pub stroke: Stroke,
    /// Its colour.
    pub colour: RGBColor,
}

/// A picture with one pair of axes.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Above the legend.
    pub title: String,
    /// Below the axis.
    pub x_label: String,
    /// Beside the axis.
    pub y_label: String,
    /// Later ones over earlier ones.
    pub curves: Vec<Curve>,
    /// One unit is as long on both axes.
    pub equal_axes: bool,
}

// The picture on the screen, in pixels. The drawing library places everything on whole pixels, so it works on a
// canvas FINE times as large, and the file says how large to show it.
const FINE: i32 = 10;
const WIDTH: i32 = 860;
const EQUAL_WIDTH: i32 = 640;
const HEIGHT: i32 = 620;
const MARGIN: i32 = 18;
const TITLE_HEIGHT: i32 = 38;
const LEGEND_ROW: i32 = 24;
const LEFT_LABELS: i32 = 78;
const BOTTOM_LABELS: i32 = 56;
const TITLE_SIZE: i32 = 21;
const AXIS_SIZE: i32 = 17;
const TICK_SIZE: i32 = 15;
const LEGEND_SIZE: i32 = 15;
const LEGEND_SAMPLE: i32 = 34;
/// What varies by less than this part of its size is flat: its variation is rounding, and no ticks could tell it apart.
const FLAT: f64 = 1e-12;
/// What varies by less than this cannot be divided into ticks: its decimal logarithm is that of the smallest numbers.
const SMALLEST: f64 = 1e-290;
/// Sums of such numbers are numbers.
const LARGEST: f64 = 1e300;
/// Characters of a tick's label, sign included, that fit beside the axis.
const LABEL: usize = 7;
const SUPERSCRIPT: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
/// Marks along a curve.
const MARKS: usize = 42;

/// The area that many points of a curve cover lets what is below show through.
const AREA_OPACITY: f64 = 0.45;

const INK: RGBColor = RGBColor(40, 40, 40);
const GRID: RGBColor = RGBColor(222, 222, 222);

/// Several pictures below each other as one SVG file.
///
/// # Errors
/// As [`Figure::svg`].
pub fn stacked(figures: &[Figure]) -> Result<String> {
    let width = figures.iter().map(Figure::width).max().unwrap_or(WIDTH);
    let height = HEIGHT * figures.len() as i32;
    let mut text = format!(
        "<svg width=\"{width}\" height=\"{height}\" xmlns=\"http://www.w3.org/2000/svg\">\n"
    );
    for (k, figure) in figures.iter().enumerate() {
        let place = format!("<svg y=\"{}\" ", HEIGHT * k as i32);
        text += &figure.svg()?.replacen("<svg ", &place, 1);
    }
    Ok(text + "</svg>\n")
}

impl Figure {
    /// The picture as the text of an SVG file.
    ///
    /// # Errors
    /// A point beyond 1e300, and what the drawing library refuses.
    pub fn svg(&self) -> Result<String> {
        let mut numbers = self.curves.iter().flat_map(|c| c.points.iter().flatten());
        if let Some(number) = numbers.find(|number| number.is_nan() || number.abs() > LARGEST) {
            return Err(anyhow!(
                "picture {}: {number:e} cannot be drawn, only numbers up to {LARGEST:e}",
                self.title
            ));
        }
        let mut text = String::new();
        let width = self.width();
        let size = ((width * FINE) as u32, (HEIGHT * FINE) as u32);
        self.draw(SVGBackend::with_string(&mut text, size).into_drawing_area())
            .map_err(|error| anyhow!("picture {}: {error}", self.title))?;
        let canvas = format!("width=\"{}\" height=\"{}\"", width * FINE, HEIGHT * FINE);
        Ok(text.replacen(
            &canvas,
            &format!("width=\"{width}\" height=\"{HEIGHT}\""),
            1,
        ))
    }

    /// Width of the picture; near square when the units are to be equal.
    fn width(&self) -> i32 {
        if self.equal_axes { EQUAL_WIDTH } else { WIDTH }
    }

    fn plot_width(&self) -> i32 {
        self.width() - LEFT_LABELS - 2 * MARGIN
    }

    fn draw(&self, canvas: DrawingArea<SVGBackend, plotters::coord::Shift>) -> DrawResult {
        canvas.fill(&WHITE)?;
        let legend = self.legend_rows();
        let top = MARGIN + TITLE_HEIGHT + LEGEND_ROW * legend.len() as i32;
        canvas.draw_text(
            &self.title,
            &text(TITLE_SIZE, HPos::Center),
            at(
                (LEFT_LABELS + self.width()) / 2,
                MARGIN + TITLE_HEIGHT / 2 - 4,
            ),
        )?;
        self.draw_legend(&canvas, &legend)?;

        let width = self.plot_width();
        let height = HEIGHT - top - BOTTOM_LABELS - MARGIN;
        let [mut x, mut y] = [0, 1].map(|axis| self.range(axis));
        if self.equal_axes {
            stretch(&mut x, &mut y, f64::from(width) / f64::from(height));
        }
        let (x_axis, y_axis) = (Axis::new(x, 10), Axis::new(y, 8));
        let x_label = self.x_label.clone() + &x_axis.unit();
        let y_label = self.y_label.clone() + &y_axis.unit();
        let mut chart = ChartBuilder::on(&canvas)
            .margin_top(top * FINE)
            .margin_left(MARGIN * FINE)
            .margin_right(MARGIN * FINE)
            .margin_bottom(MARGIN * FINE)
            .x_label_area_size(BOTTOM_LABELS * FINE)
            .y_label_area_size(LEFT_LABELS * FINE)
            .build_cartesian_2d(x_axis, y_axis)?;
        chart
            .configure_mesh()
            .bold_line_style(GRID.stroke_width(FINE as u32))
            .light_line_style(TRANSPARENT)
            .axis_style(INK.stroke_width(FINE as u32))
            .set_all_tick_mark_size(5 * FINE)
            .label_style(font(TICK_SIZE))
            .axis_desc_style(font(AXIS_SIZE))
            .x_desc(x_label)
            .y_desc(y_label)
            .draw()?;
        // The axes through zero, where they are inside.
        let zero = GREY.stroke_width(FINE as u32);
        if x[0] < 0.0 && x[1] > 0.0 {
            chart.draw_series([PathElement::new([(0.0, y[0]), (0.0, y[1])], zero)])?;
        }
        if y[0] < 0.0 && y[1] > 0.0 {
            chart.draw_series([PathElement::new([(x[0], 0.0), (x[1], 0.0)], zero)])?;
        }
        let place = |p: &[f64; 2]| {
            let (x, y) = chart.backend_coord(&(p[0], p[1]));
            [x, y]
        };
        let dense = thin::dense(&self.curves, place);
        for (k, curve) in self.curves.iter().enumerate() {
            let points = curve.points.iter().map(|p| (p[0], p[1]));
            let style = curve.style();
            match curve.stroke {
                Stroke::Solid => match &dense[k] {
                    thin::Seen::Line(points) => {
                        canvas.draw(&PathElement::new(points.clone(), style))?;
                    }
                    thin::Seen::Area { runs, mean } => {
                        let colour = curve.colour.mix(AREA_OPACITY);
                        let area = colour.stroke_width(thin::COLUMN as u32);
                        for &[x, top, bottom] in runs {
                            canvas.draw(&PathElement::new([(x, top), (x, bottom)], area))?;
                        }
                        canvas.draw(&PathElement::new(mean.clone(), style))?;
                    }
                    thin::Seen::Nothing => {}
                },
                Stroke::Dashed => {
                    let (dash, gap) = (8 * FINE, 5 * FINE);
                    chart.draw_series(DashedLineSeries::new(points, dash, gap, style))?;
                }
                Stroke::Marks => {
                    let some = spaced(&curve.points, x, y);
                    let circles = some.into_iter().map(|p| Circle::new(p, 4 * FINE, style));
                    chart.draw_series(circles)?;
                }
            };
        }
        canvas.present()
    }

    /// Indices of the curves with a label, broken into rows that fit the width.
    fn legend_rows(&self) -> Vec<Vec<usize>> {
        let mut rows: Vec<Vec<usize>> = Vec::new();
        let mut used = 0;
        for (i, curve) in self.curves.iter().enumerate() {
            if curve.label.is_empty() {
                continue;
            }
            let width = curve.legend_width();
            if rows.is_empty() || used + width > self.plot_width() {
                rows.push(Vec::new());
                used = 0;
            }
            used += width;
            rows.last_mut().expect("a row was just pushed").push(i);
        }
        rows
    }

    fn draw_legend(
        &self,
        canvas: &DrawingArea<SVGBackend, plotters::coord::Shift>,
        rows: &[Vec<usize>],
    ) -> DrawResult {
        for (k, row) in rows.iter().enumerate() {
            let width: i32 = row.iter().map(|&i| self.curves[i].legend_width()).sum();
            let mut x = (LEFT_LABELS + self.width() - width) / 2;
            let y = MARGIN + TITLE_HEIGHT + LEGEND_ROW * k as i32 + LEGEND_ROW / 2 - 4;
            for &i in row {
                let curve = &self.curves[i];
                let ends = [at(x, y), at(x + LEGEND_SAMPLE, y)];
                let style = curve.style();
                match curve.stroke {
                    Stroke::Solid => canvas.draw(&PathElement::new(ends, style))?,
                    Stroke::Dashed => {
                        for dash in 0..3 {
                            let start = x + 13 * dash;
                            canvas
                                .draw(&PathElement::new([at(start, y), at(start + 8, y)], style))?;
                        }
                    }
                    Stroke::Marks => {
                        canvas.draw(&Circle::new(at(x + LEGEND_SAMPLE / 2, y), 4 * FINE, style))?
                    }
                }
                canvas.draw_text(
                    &curve.label,
                    &text(LEGEND_SIZE, HPos::Left),
                    at(x + LEGEND_SAMPLE + 8, y),
                )?;
                x += curve.legend_width();
            }
        }
        Ok(())
    }

    /// What the curves cover on one axis, and a twentieth beyond.
    fn range(&self, axis: usize) -> [f64; 2] {
        let values = self.curves.iter().flat_map(|c| &c.points).map(|p| p[axis]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        if low > high {
            return [0.0, 1.0];
        }
        let size = high.abs().max(low.abs());
        let margin = match high - low > FLAT * size {
            true => (0.05 * (high - low)).max(SMALLEST),
            false if size > 0.0 => (0.05 * size).max(SMALLEST),
            false => 1.0,
        };
        [low - margin, high + margin]
    }
}

type DrawResult = std::result::Result<(), DrawingAreaErrorKind<std::io::Error>>;

impl Curve {
    fn style(&self) -> ShapeStyle {
        let width = match self.stroke {
            Stroke::Solid | Stroke::Dashed => 20,
            Stroke::Marks => 14,
        };
        self.colour.stroke_width((width * FINE / 10) as u32)
    }

    /// Width of the entry in the legend, the gap to the next one included; a letter is taken as half as wide as high.
    fn legend_width(&self) -> i32 {
        LEGEND_SAMPLE + 8 + self.label.chars().count() as i32 * LEGEND_SIZE * 11 / 20 + 22
    }
}

fn at(x: i32, y: i32) -> (i32, i32) {
    (x * FINE, y * FINE)
}

fn font(size: i32) -> TextStyle<'static> {
    ("sans-serif", size * FINE).into_font().color(&INK)
}

fn text(size: i32, horizontal: HPos) -> TextStyle<'static> {
    font(size).pos(Pos::new(horizontal, VPos::Center))
}

/// MARKS points of a curve at equal distances along it, as the eye sees them; all of them if they are no more.
fn spaced(points: &[[f64; 2]], x: [f64; 2], y: [f64; 2]) -> Vec<(f64, f64)> {
    if points.len() <= MARKS {
        return points.iter().map(|p| (p[0], p[1])).collect();
    }
    let mut along = 0.0;
    let mut distances = vec![0.0];
    for pair in points.windows(2) {
        let dx = (pair[1][0] - pair[0][0]) / (x[1] - x[0]);
        let dy = (pair[1][1] - pair[0][1]) / (y[1] - y[0]);
        along += dx.hypot(dy);
        distances.push(along);
    }
    let gap = along / MARKS as f64;
    let mut next = 0.0;
    let mut some = Vec::new();
    for (point, distance) in points.iter().zip(distances) {
        if distance >= next {
            some.push((point[0], point[1]));
            next = distance + gap;
        }
    }
    some
}

/// One axis: its range and the round numbers on it.
struct Axis {
    range: [f64; 2],
    ticks: Vec<f64>,
    places: usize,
    /// The labels are in this power of ten.
    exponent: i32,
}

impl Axis {
    fn new(range: [f64; 2], most: usize) -> Axis {
        let ticks = ticks(range, most);
        let mut axis = Axis {
            range,
            places: places(&ticks),
            ticks,
            exponent: 0,
        };
        let labels = axis.ticks.iter().map(|tick| axis.format_ext(tick));
        if labels.map(|label| label.chars().count()).max() > Some(LABEL) {
            let largest = axis
                .ticks
                .iter()
                .fold(0.0, |most: f64, t| most.max(t.abs()));
            // A multiple of three, as units are named; the rounding of 1e-9 must not make it 999e-12.
            axis.exponent = ((largest.log10() + 1e-9) / 3.0).floor() as i32 * 3;
            let scaled: Vec<f64> = axis.ticks.iter().map(|tick| axis.scaled(*tick)).collect();
            axis.places = places(&scaled);
        }
        axis
    }

    fn scaled(&self, value: f64) -> f64 {
        value / 10f64.powi(self.exponent)
    }

    /// What is to be added to the name of the axis.
    fn unit(&self) -> String {
        if self.exponent == 0 {
            return String::new();
        }
        let exponent = self.exponent.to_string();
        let digits = exponent.chars().map(|c| match c.to_digit(10) {
            Some(digit) => SUPERSCRIPT[digit as usize],
            None => '\u{207b}',
        });
        format!(", ticks in 10{}", digits.collect::<String>())
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, pixels: (i32, i32)) -> i32 {
        let part = (value - self.range[0]) / (self.range[1] - self.range[0]);
        pixels.0 + (part * f64::from(pixels.1 - pixels.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            Vec::new()
        } else {
            self.ticks.clone()
        }
    }

    fn range(&self) -> Range<f64> {
        self.range[0]..self.range[1]
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        number(self.scaled(*value), self.places)
    }
}

/// Widens one of the ranges about its middle until a unit is as long on both axes.
fn stretch(x: &mut [f64; 2], y: &mut [f64; 2], aspect: f64) {
    let (width, height) = (x[1] - x[0], y[1] - y[0]);
    let widen = |range: &mut [f64; 2], length: f64| {
        let middle = 0.5 * (range[0] + range[1]);
        *range = [middle - 0.5 * length, middle + 0.5 * length];
    };
    if width < aspect * height {
        widen(x, aspect * height);
    } else {
        widen(y, width / aspect);
    }
}

/// At most `most` round numbers (1, 2 or 5 times a power of ten apart) inside the range.
fn ticks(range: [f64; 2], most: usize) -> Vec<f64> {
    let length = range[1] - range[0];
    let power = 10f64.powf((length / most as f64).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|m| m * power)
        .into_iter()
        .find(|step| length / step <= most as f64)
        .unwrap_or(10.0 * power);
    let first = (range[0] / step).ceil() as i64;
    let last = (range[1] / step).floor() as i64;
    (first..=last).map(|k| k as f64 * step).collect()
}

/// Decimals that the distance of the ticks needs.
fn places(ticks: &[f64]) -> usize {
    match ticks {
        [a, b, ..] => (-(b - a).log10() - 1e-9).ceil().max(0.0) as usize,
        _ => 2,
    }
}

/// A number with a real minus sign, and none on zero.
fn number(value: f64, places: usize) -> String {
    let text = format!("{value:.places$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().any(|c| c.is_ascii_digit() && c != '0') => {
            format!("\u{2212}{digits}")
        }
        Some(zero) => zero.to_string(),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(equal_axes: bool) -> Figure {
        let points = (0..=100)
            .map(|k| f64::from(k) / 10.0)
            .map(|x| [x, 3.0 * x.sin()]);
        let curve = |stroke| Curve {
            label: format!("{stroke:?}"),
            points: points.clone().collect(),
            stroke,
            colour: BLUE,
        };
        Figure {
            title: "A wave".to_string(),
            x_label: "x (mm)".to_string(),
            y_label: "y (N)".to_string(),
            curves: [Stroke::Solid, Stroke::Dashed, Stroke::Marks]
                .map(curve)
                .into(),
            equal_axes,
        }
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks([-0.1, 2.1], 5), [0.0, 0.5, 1.0, 1.5, 2.0]);
        assert_eq!(
            ticks([-6.6, 6.6], 7),
            [-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0]
        );
        assert_eq!(places(&[0.0, 0.5]), 1);
        assert_eq!(places(&[0.0, 0.02]), 2);
        assert_eq!(places(&[0.0, 10.0]), 0);
        assert_eq!(number(-0.0, 1), "0.0");
        assert_eq!(number(-2.5, 1), "\u{2212}2.5");
    }

    #[test]
    fn long_labels_are_scaled() {
        for (range, first, last, unit) in [
            (
                [-1.1e-9, 1.1e-9],
                "\u{2212}1.0",
                "1.0",
                ", ticks in 10\u{207b}⁹",
            ),
            ([-6.6e8, 6.6e8], "\u{2212}600", "600", ", ticks in 10⁶"),
            ([0.0, 3.1e302], "0", "300", ", ticks in 10³⁰⁰"),
            (
                [-2.2e-302, 2.2e-302],
                "\u{2212}20",
                "20",
                ", ticks in 10\u{207b}³⁰³",
            ),
            // As they are where they fit.
            ([-0.022, 0.022], "\u{2212}0.02", "0.02", ""),
            ([-110000.0, 110000.0], "\u{2212}100000", "100000", ""),
        ] {
            let axis = Axis::new(range, 8);
            let labels: Vec<String> = axis.ticks.iter().map(|t| axis.format_ext(t)).collect();
            assert_eq!(labels[0], first);
            assert_eq!(labels[labels.len() - 1], last);
            assert!(labels.iter().all(|label| label.chars().count() <= LABEL));
            assert_eq!(axis.unit(), unit);
        }
        let mut small = wave(false);
        for point in &mut small.curves[0].points {
            point[1] *= 1e-9;
        }
        small.curves.truncate(1);
        assert!(small.svg().unwrap().contains("y (N), ticks in 10\u{207b}⁹"));
    }

    #[test]
    fn equal_axes_have_equal_units() {
        let (mut x, mut y) = ([0.0, 1.0], [0.0, 1.0]);
        stretch(&mut x, &mut y, 1.5);
        assert_eq!((x, y), ([-0.25, 1.25], [0.0, 1.0]));
        stretch(&mut x, &mut y, 1.0);
        assert_eq!(y, [-0.25, 1.25]);
    }

    #[test]
    fn svg_holds_everything_inside_its_canvas() {
        for equal_axes in [false, true] {
            let svg = wave(equal_axes).svg().unwrap();
            for part in [
                "A wave",
                "x (mm)",
                "y (N)",
                "Solid",
                "Dashed",
                "Marks",
                if equal_axes {
                    "viewBox=\"0 0 6400 6200\""
                } else {
                    "viewBox=\"0 0 8600 6200\""
                },
            ] {
                assert!(svg.contains(part), "{part}");
            }
            for polyline in svg.split("points=\"").skip(1) {
                for point in polyline.split('"').next().unwrap().split_whitespace() {
                    let (x, y) = point.split_once(',').unwrap();
                    let width = if equal_axes { 6400 } else { 8600 };
                    assert!((0..=width).contains(&x.parse::<i32>().unwrap()), "{point}");
                    assert!((0..=6200).contains(&y.parse::<i32>().unwrap()), "{point}");
                }
            }
        }
    }

    #[test]
    fn the_smallest_and_the_largest_numbers_are_drawn_or_refused() {
        let scaled = |factor: f64| {
            let mut figure = wave(false);
            for curve in &mut figure.curves {
                curve.points.iter_mut().flatten().for_each(|v| *v *= factor);
            }
            figure.svg()
        };
        for factor in [5e-324, 1e-310, 1e-290, 1e-200, 1e200, 1e298] {
            scaled(factor).unwrap_or_else(|error| panic!("{factor:e}: {error}"));
        }
        let words = scaled(1e302).unwrap_err().to_string();
        assert!(words.contains("cannot be drawn"), "{words}");
        assert!(scaled(f64::NAN).is_err());
    }

    #[test]
    fn rounding_is_no_range() {
        let mut flat = wave(false);
        for (k, point) in flat.curves[0].points.iter_mut().enumerate() {
            *point = [1.0 + 1e-15 * k as f64, 0.0];
        }
        flat.curves.truncate(1);
        let [low, high] = flat.range(0);
        assert!((low - 0.95).abs() < 1e-9 && (high - 1.05).abs() < 1e-9);
        assert_eq!(flat.range(1), [-1.0, 1.0]);
    }

    #[test]
    fn marks_keep_their_distance() {
        // Points crowd where a sine turns; the marks do not.
        let sine: Vec<[f64; 2]> = (0..=1000)
            .map(|k| [(f64::from(k) * std::f64::consts::PI / 1000.0).cos(), 0.0])
            .collect();
        let marks = spaced(&sine, [-1.0, 1.0], [-1.0, 1.0]);
        for pair in marks.windows(2) {
            let gap = (pair[0].0 - pair[1].0) * MARKS as f64 / 2.0;
            assert!((1.0..1.1).contains(&gap), "{gap}");
        }
    }

    #[test]
    fn few_marks_are_all_drawn() {
        let points = [[0.0, 0.0], [0.001, 0.0], [1.0, 0.0]];
        assert_eq!(spaced(&points, [0.0, 1.0], [0.0, 1.0]).len(), 3);
    }

    #[test]
    fn pictures_are_reproducible() {
        assert_eq!(wave(false).svg().unwrap(), wave(false).svg().unwrap());
    }
}
