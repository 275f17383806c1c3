//! What the paper measures of an autumn (section 4): how many colours there are, and how each of them lies in the tree.

/// Red, green, blue.
pub(crate) type Colour = [u8; 3];

/// Colours that pictures are reduced to before they are counted, as in the paper.
const PALETTE: usize = 128;

/// A palette of k-means, found on a common sample of all pictures that are compared: one palette a picture would give every picture about
/// the entropy ln 128.
pub(crate) struct Palette(Vec<[f64; 3]>);

impl Palette {
    /// Lloyd's iteration from evenly drawn colours of `sample`, 12 times: afterwards the entropy moves by less than 0.01.
    pub(crate) fn of(sample: &[Colour]) -> Self {
        let sample: Vec<[f64; 3]> = sample.iter().map(|colour| colour.map(f64::from)).collect();
        let step = (sample.len() / PALETTE).max(1);
        let mut palette = Self(sample.iter().step_by(step).take(PALETTE).copied().collect());
        for _ in 0..12 {
            let mut sums = vec![([0.; 3], 0.); palette.0.len()];
            for colour in &sample {
                let (sum, count) = &mut sums[palette.nearest(colour)];
                (0..3).for_each(|i| sum[i] += colour[i]);
                *count += 1.;
            }
            for (centre, (sum, count)) in palette.0.iter_mut().zip(sums).filter(|(_, (_, count))| *count > 0.)
            {
                *centre = sum.map(|channel| channel / count);
            }
        }
        palette
    }

    fn nearest(&self, colour: &[f64; 3]) -> usize {
        let distance = |centre: &[f64; 3]| (0..3).map(|i| (centre[i] - colour[i]).powi(2)).sum::<f64>();
        let distances = self.0.iter().map(distance).enumerate();
        distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index)
    }

    /// H = −Σ P ln P (eq. 16) of the palette's colours among `colours`.
    pub(crate) fn entropy(&self, colours: &[Colour]) -> f64 {
        let mut counts = vec![0_u32; self.0.len()];
        colours.iter().for_each(|colour| counts[self.nearest(&colour.map(f64::from))] += 1);
        let shares =
            counts.iter().filter(|&&count| count > 0).map(|&count| f64::from(count) / colours.len() as f64);
        -shares.map(|share| share * share.ln()).sum::<f64>()
    }
}

/// The colours that the paper parts pictures into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    Green,
    Yellow,
    Red,
}

impl Class {
    pub(crate) const ALL: [Self; 3] = [Self::Green, Self::Yellow, Self::Red];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Green => "green",
            Self::Yellow => "yellow",
            Self::Red => "red",
        }
    }

    /// The class of a colour, by its hue: green 68° to 180°, yellow 36° to 68°, red below 36° or from 300°.
    pub(crate) fn of(colour: Colour) -> Option<Self> {
        match hue(colour)? {
            hue if (68. ..180.).contains(&hue) => Some(Self::Green),
            hue if (36. ..68.).contains(&hue) => Some(Self::Yellow),
            hue if !(36. ..300.).contains(&hue) => Some(Self::Red),
            _ => None,
        }
    }
}

/// Hue in degrees; greys have none.
fn hue(colour: Colour) -> Option<f64> {
    let [r, g, b] = colour.map(f64::from);
    let (most, least) = (r.max(g).max(b), r.min(g).min(b));
    let spread = most - least;
    if spread < 1. {
        return None;
    }
    let sixth = if most == r {
        (g - b) / spread
    } else if most == g {
        (b - r) / spread + 2.
    } else {
        (r - g) / spread + 4.
    };
    Some((sixth * 60.).rem_euclid(360.))
}

/// Sides of the boxes in pixels.
const BOXES: [usize; 6] = [2, 4, 8, 16, 32, 64];

/// Fewer boxes than these, of the smallest size, tell no dimension.
const FEWEST_BOXES: usize = 8;

/// The fractal dimension by box counting: the slope of ln(boxes) over ln(1/side); 0 where there is next to nothing.
pub(crate) fn dimension(is_set: &[bool], width: usize) -> f64 {
    let counts = BOXES.map(|side| boxes(is_set, width, side));
    if counts[0] < FEWEST_BOXES {
        return 0.;
    }
    let points = BOXES.iter().zip(counts).map(|(&side, count)| (-(side as f64).ln(), (count as f64).ln()));
    slope(&points.collect::<Vec<_>>())
}

fn boxes(is_set: &[bool], width: usize, side: usize) -> usize {
    let across = width.div_ceil(side);
    let mut hit = vec![false; across * (is_set.len() / width).div_ceil(side)];
    for (at, _) in is_set.iter().enumerate().filter(|(_, set)| **set) {
        hit[at / width / side * across + at % width / side] = true;
    }
    hit.iter().filter(|hit| **hit).count()
}

/// The slope of the line of least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_has_two_dimensions_a_line_one_and_nothing_none() {
        let side = 256;
        assert!((dimension(&vec![true; side * side], side) - 2.).abs() < 1e-9);
        let line: Vec<bool> = (0..side * side).map(|at| at / side == 100).collect();
        assert!((dimension(&line, side) - 1.).abs() < 1e-9);
        assert_eq!(dimension(&vec![false; side * side], side), 0.);
    }

    #[test]
    fn a_carpet_of_sierpinski_has_its_dimension() {
        // In boxes of powers of two, the triangle: Pascal's, modulo 2.
        let side = 512;
        let triangle: Vec<bool> = (0..side * side).map(|at| (at / side) & (at % side) == 0).collect();
        assert!((dimension(&triangle, side) - 3_f64.log2()).abs() < 1e-9);
    }

    #[test]
    fn entropy_is_that_of_the_colours() {
        let colours: Vec<Colour> =
            (0..4_096).map(|i| [0, 60, 120, 180].map(|x| [x, 255 - x, 7])[i / 1_024]).collect();
        let palette = Palette::of(&colours);
        assert!((palette.entropy(&colours) - 4_f64.ln()).abs() < 1e-9);
        assert_eq!(palette.entropy(&colours[..1]), 0.);
    }

    #[test]
    fn hues_fall_into_their_classes() {
        for (colour, class) in [
            ([60, 140, 30], Some(Class::Green)),
            ([220, 200, 60], Some(Class::Yellow)),
            ([200, 40, 20], Some(Class::Red)),
            ([200, 20, 90], Some(Class::Red)),
            ([40, 60, 220], None),
            ([90, 90, 90], None),
        ] {
            assert_eq!(Class::of(colour), class, "{colour:?}");
        }
    }
}
