//! Strokes that were drawn over the picture: paths of an SVG drawing, or lists of points.

use super::GuidanceError;
use kurbo::{Affine, BezPath, PathEl, Point};
use roxmltree::{Document, Node};
use std::path::Path;
use svgtypes::{PointsParser, TransformListParser, TransformListToken, ViewBox};

/// A line in pixels of the picture, in the direction of the flow; at least two points.
pub type Stroke = Vec<[f32; 2]>;

/// How far, in the drawing's units, a straight piece may be from the curve that it stands for: a tenth of a pixel is not seen.
const FLATNESS: f64 = 0.1;

/// No drawing of a person is larger; what is would take the time of a small eternity.
const LONGEST: u64 = 16 << 20;

/// Reads strokes from a file that ends in `.svg` or `.json`.
///
/// SVG: every path, line and polyline, with its transforms; the view box covers the whole picture (without one, units are pixels). JSON: a
/// list of strokes, each a list of points [x, y] in pixels from the upper left corner. Strokes must lie on the picture.
pub fn strokes(file: &Path, (width, height): (usize, usize)) -> Result<Vec<Stroke>, GuidanceError> {
    let fault = |fault: String| GuidanceError::new(file, fault);
    let length = std::fs::metadata(file).map_err(|error| fault(error.to_string()))?.len();
    if length > LONGEST {
        return Err(fault(format!("a drawing of {length} bytes is too large: {LONGEST} are allowed")));
    }
    let text = std::fs::read_to_string(file).map_err(|error| fault(error.to_string()))?;
    let svg = file.extension().is_some_and(|kind| kind.eq_ignore_ascii_case("svg"));
    let found = if svg { drawing(&text, width as f64, height as f64) } else { lists(&text) };
    let mut strokes = found.map_err(fault)?;
    strokes.retain(|stroke| stroke.iter().any(|point| *point != stroke[0]));
    if strokes.is_empty() {
        return Err(fault(
            "there are no strokes in it: draw lines along the flow, as paths and not as pictures".into(),
        ));
    }
    for (number, stroke) in (1..).zip(&strokes) {
        let inside =
            |&[x, y]: &[f32; 2]| (-0.5..=width as f32).contains(&x) && (-0.5..=height as f32).contains(&y);
        if let Some([x, y]) = stroke.iter().find(|point| !inside(point)) {
            return Err(fault(format!(
                "stroke {number} leaves the picture at ({x:.0}, {y:.0}): the picture is {width} × {height} pixels"
            )));
        }
    }
    Ok(strokes)
}

fn lists(text: &str) -> Result<Vec<Stroke>, String> {
    serde_json::from_str(text)
        .map_err(|error| format!("not a list of strokes such as [[[10, 20], [30, 40]]]: {error}"))
}

fn drawing(text: &str, width: f64, height: f64) -> Result<Vec<Stroke>, String> {
    let document = Document::parse(text).map_err(|error| format!("not a drawing: {error}"))?;
    let root = document.root_element();
    let mut placed = Affine::IDENTITY;
    if let Some(view) = root.attribute("viewBox") {
        let view: ViewBox =
            view.parse().map_err(|error| format!("its viewBox is not four numbers: {error}"))?;
        placed = Affine::scale_non_uniform(width / view.w, height / view.h)
            * Affine::translate((-view.x, -view.y));
    }
    let mut strokes = Vec::new();
    // Nodes still to be seen and what moves them, last first.
    let mut open = vec![(root, placed)];
    while let Some((node, outer)) = open.pop() {
        if matches!(node.tag_name().name(), "defs" | "clipPath" | "symbol" | "marker" | "pattern" | "mask") {
            continue;
        }
        let moved = outer * transform(node)?;
        if let Some(path) = path(node)? {
            collect(moved * path, &mut strokes);
        }
        let children: Vec<_> = node.children().filter(Node::is_element).collect();
        open.extend(children.into_iter().rev().map(|child| (child, moved)));
    }
    Ok(strokes)
}

/// The line that an element draws.
fn path(node: Node) -> Result<Option<BezPath>, String> {
    let number = |name: &str| {
        node.attribute(name).map_or(Ok(0.0), str::parse::<f64>).map_err(|error| error.to_string())
    };
    match node.tag_name().name() {
        "path" => {
            let text = node.attribute("d").unwrap_or_default();
            BezPath::from_svg(text).map(Some).map_err(|error| format!("a path cannot be read: {error}"))
        }
        "line" => {
            let mut path = BezPath::new();
            path.move_to((number("x1")?, number("y1")?));
            path.line_to((number("x2")?, number("y2")?));
            Ok(Some(path))
        }
        "polyline" => {
            let points = PointsParser::from(node.attribute("points").unwrap_or_default()).map(Point::from);
            let element =
                |(index, point)| if index == 0 { PathEl::MoveTo(point) } else { PathEl::LineTo(point) };
            Ok(Some(points.enumerate().map(element).collect()))
        }
        _ => Ok(None),
    }
}

fn transform(node: Node) -> Result<Affine, String> {
    let mut all = Affine::IDENTITY;
    for token in TransformListParser::from(node.attribute("transform").unwrap_or_default()) {
        all *= match token.map_err(|error| format!("a transform cannot be read: {error}"))? {
            TransformListToken::Matrix { a, b, c, d, e, f } => Affine::new([a, b, c, d, e, f]),
            TransformListToken::Translate { tx, ty } => Affine::translate((tx, ty)),
            TransformListToken::Scale { sx, sy } => Affine::scale_non_uniform(sx, sy),
            TransformListToken::Rotate { angle } => Affine::rotate(angle.to_radians()),
            TransformListToken::SkewX { angle } => Affine::skew(angle.to_radians().tan(), 0.0),
            TransformListToken::SkewY { angle } => Affine::skew(0.0, angle.to_radians().tan()),
        };
    }
    Ok(all)
}

/// Adds the straight pieces of a path; each subpath is a stroke.
fn collect(path: BezPath, strokes: &mut Vec<Stroke>) {
    let mut start = Point::ZERO;
    kurbo::flatten(path, FLATNESS, |element| {
        let point = match element {
            PathEl::MoveTo(point) => {
                start = point;
                strokes.push(Stroke::new());
                point
            }
            PathEl::LineTo(point) => point,
            _ => start,
        };
        if let Some(stroke) = strokes.last_mut() {
            stroke.push([point.x as f32, point.y as f32]);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str, text: &str) -> Result<Vec<Stroke>, String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        strokes(&file, (200, 100)).map_err(|error| error.to_string())
    }

    #[test]
    fn paths_are_placed_by_the_view_box_and_their_transforms() {
        let text = r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 50"><defs><path d="M0 0L9 9"/></defs>
            <g transform="translate(10, 5)"><path d="M0 0 l10 0"/></g><line x1="1" y1="2" x2="3" y2="4"/>
            <polyline points="5,5 6,6 7,5"/></svg>"#;
        let strokes = read("drawing.svg", text).unwrap();
        assert_eq!(strokes[0], [[20.0, 10.0], [40.0, 10.0]]);
        assert_eq!(strokes[1], [[2.0, 4.0], [6.0, 8.0]]);
        assert_eq!(strokes[2], [[10.0, 10.0], [12.0, 12.0], [14.0, 10.0]]);
        assert_eq!(strokes.len(), 3);
    }

    #[test]
    fn curves_become_short_lines() {
        let strokes = read("drawing.svg", r#"<svg><path d="M10 50 C 10 10, 90 10, 90 50"/></svg>"#).unwrap();
        assert!(strokes[0].len() > 5);
        assert_eq!((strokes[0][0], strokes[0][strokes[0].len() - 1]), ([10.0, 50.0], [90.0, 50.0]));
    }

    #[test]
    fn lists_of_points_are_read() {
        assert_eq!(read("a.json", "[[[1, 2], [3.5, 4]]]").unwrap(), [[[1.0, 2.0], [3.5, 4.0]]]);
    }

    #[test]
    fn what_is_wrong_is_said_by_name() {
        for (name, text, words) in [
            ("a.json", "[[[1, 2], [3, 400]]]", "stroke 1 leaves the picture at (3, 400)"),
            ("a.json", "[[[1, 2], [-30, 4]]]", "leaves the picture at (-30, 4)"),
            ("a.json", "{}", "not a list of strokes"),
            ("a.json", "[]", "no strokes"),
            ("a.json", "[[[7, 7], [7, 7]], []]", "no strokes"),
            ("a.svg", "<svg><path d='M1 z'/></svg>", "path"),
            ("a.svg", "<svg", "not a drawing"),
            ("a.svg", "<svg viewBox='1 2'/>", "viewBox"),
            ("a.svg", "<svg><image/></svg>", "no strokes"),
        ] {
            let error = read(name, text).unwrap_err();
            assert!(error.contains(words) && error.contains(name), "{error}");
        }
    }
}
