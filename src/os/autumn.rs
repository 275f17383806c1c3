//! The tree, the plates and the season of an autumn, as they were chosen.

use super::{Failure, document::read_text, local_time::LocalTime, photo};
use crate::{
    config::{
        night::Zone,
        season::{Calendar, Day},
    },
    effect::autumn::{KNOWN, PLATE_CELLS, PLATE_SIDE, Plates, STAGES, Species, Stage},
    frame::{Size, srgb},
    math::Turns,
};
use std::{
    convert::Infallible,
    path::{Path, PathBuf},
    str::FromStr,
    time::Duration,
};

/// Which colours leaves have.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum PlatesChoice {
    /// Those of the species' pigments.
    #[default]
    Synthetic,
    /// Those of the seven photos of leaves in this folder.
    Folder(PathBuf),
}

impl FromStr for PlatesChoice {
    type Err = Infallible;

    fn from_str(word: &str) -> Result<Self, Infallible> {
        Ok(if word == "synthetic" { Self::Synthetic } else { Self::Folder(word.into()) })
    }
}

/// Which species.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TreeChoice {
    /// One that the program carries.
    Known(&'static str),
    /// One in a file.
    File(PathBuf),
}

impl Default for TreeChoice {
    fn default() -> Self {
        Self::Known(KNOWN[0].0)
    }
}

impl FromStr for TreeChoice {
    type Err = Infallible;

    fn from_str(word: &str) -> Result<Self, Infallible> {
        let known = KNOWN.iter().find(|(name, _)| *name == word);
        Ok(known.map_or_else(|| Self::File(word.into()), |(name, _)| Self::Known(name)))
    }
}

/// The stages that an autumn goes through, if not those of the calendar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Season {
    /// From where to where.
    pub stages: Option<(Stage, Stage)>,
    /// In how many minutes of a show; then it begins again.
    pub minutes: Option<u32>,
}

impl Season {
    /// Green to bare.
    const WHOLE: (Stage, Stage) = (Stage::GREEN, Stage::BARE);
    /// How long a part of the season takes in a show where nobody has said it.
    const USUAL_MINUTES: u32 = 5;

    /// The stage when `done` frames of a film of `frames` were shown.
    pub(super) fn of_film(&self, done: u32, frames: u32) -> Stage {
        let (from, to) = self.stages.unwrap_or(Self::WHOLE);
        from.towards(to, done.into(), u64::from(frames.max(2)) - 1)
    }
}

/// The camera's way around a tree.
///
/// A tree is painted as it is seen from one side; from another it is another picture. So the camera goes in steps: each is prepared
/// while the one before is shown, and they fade into each other. A machine that takes longer for a tree goes in larger steps.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Orbit {
    minutes: Option<u32>,
    azimuth: Turns,
}

impl Orbit {
    /// Steps of a turn: with 2° the outermost leaves move by a hundredth of the picture's height.
    const STEPS: u128 = 180;

    /// Around the tree in `minutes`; without them, the camera stands.
    pub(super) const fn new(minutes: Option<u32>) -> Self {
        Self { minutes, azimuth: Turns(0) }
    }

    /// From where the tree is seen.
    pub(super) const fn azimuth(&self) -> Turns {
        self.azimuth
    }

    /// Goes to where the camera is to be, `now` after the start of the show.
    pub(super) fn go(&mut self, now: Duration) {
        if let Some(minutes) = self.minutes {
            let turn = u128::from(minutes) * 60_000;
            let step = now.as_millis() * Self::STEPS / turn % Self::STEPS;
            self.azimuth = Turns(((step << 32) / Self::STEPS) as u32);
        }
    }
}

/// The season of a show.
#[derive(Debug)]
pub(super) struct SeasonClock {
    season: Season,
    calendar: Calendar,
    clock: LocalTime,
}

impl SeasonClock {
    /// # Errors
    /// A time zone that the system does not know.
    pub(super) fn new(season: Season, calendar: Calendar, zone: &Zone) -> Result<Self, Failure> {
        Ok(Self { season, calendar, clock: LocalTime::new(zone, Default::default())? })
    }

    /// The stage `now` after the start of the show. While the date is not known for sure, the tree has all its colours.
    pub(super) fn stage(&mut self, now: Duration) -> Stage {
        match self.season {
            Season { stages: None, minutes: None } => {
                self.clock.date().map_or(Stage::COLOURED, |(month, day, minute)| {
                    Day::new(month, day).map_or(Stage::COLOURED, |day| self.calendar.stage(day, minute))
                })
            }
            Season { stages, minutes } => {
                let whole = u128::from(minutes.unwrap_or(Season::USUAL_MINUTES).max(1)) * 60_000;
                let (from, to) = stages.unwrap_or(Season::WHOLE);
                from.towards(to, (now.as_millis() % whole) as u64, whole as u64)
            }
        }
    }
}

/// Reads the species that was chosen.
///
/// # Errors
/// A file that cannot be read, or what is wrong in it, with its line and column.
pub fn species(choice: &TreeChoice) -> Result<Species, Failure> {
    match choice {
        TreeChoice::Known(name) => Species::known(name).ok_or_else(|| unknown(Path::new(name))),
        TreeChoice::File(path) if !path.exists() => Err(unknown(path)),
        TreeChoice::File(path) => Species::parse(&read_text(path)?)
            .map_err(|error| Failure::new(format!("{}: {error}", path.display()))),
    }
}

fn unknown(path: &Path) -> Failure {
    let names: Vec<&str> = KNOWN.iter().map(|(name, _)| *name).collect();
    Failure::new(format!(
        "{}: there is no such tree; name a file, or one of {}",
        path.display(),
        names.join(", ")
    ))
}

/// Reads the plates that were chosen; `None` for the synthetic ones.
///
/// # Errors
/// A folder without exactly seven photos of one size, or one that cannot be read.
pub fn plates(choice: &PlatesChoice) -> Result<Option<Box<Plates>>, Failure> {
    let PlatesChoice::Folder(folder) = choice else { return Ok(None) };
    let refused = |why: String| Failure::new(format!("{}: {why}", folder.display()));
    let paths = photo::list([folder])?;
    if paths.len() != STAGES {
        return Err(refused(format!(
            "{} photos are here; seven are needed, from green to the last colour, in the order of their names",
            paths.len()
        )));
    }
    let mut plates = Box::new([[[0; 3]; PLATE_CELLS]; STAGES]);
    let mut first: Option<Size> = None;
    for (path, plate) in paths.iter().zip(plates.iter_mut()) {
        let limits = photo::Limits::default();
        let leaf = photo::load_within(path, Size::new(512, 512), &limits)?;
        let size = *first.get_or_insert(leaf.source_size);
        if leaf.source_size != size {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            return Err(refused(format!(
                "{name} has {} pixels, and the first photo has {size}; make all of one size",
                leaf.source_size
            )));
        }
        *plate = plate_of(&leaf);
    }
    Ok(Some(plates))
}

/// The colours of a photographed leaf, in the square of its middle; what is of the colour of the photo's corners is no leaf, and gets
/// the leaf's mean.
fn plate_of(leaf: &photo::Photo) -> [[u8; 3]; PLATE_CELLS] {
    let pixels = leaf.rgb.as_chunks::<3>().0;
    let (width, height) = (leaf.size.width as usize, leaf.size.height as usize);
    let corners = [0, width - 1, (height - 1) * width, height * width - 1].map(|at| pixels[at]);
    let is_leaf = |pixel: &[u8; 3]| {
        corners.iter().all(|corner| (0..3).map(|i| u32::from(corner[i].abs_diff(pixel[i]))).sum::<u32>() > 60)
    };
    let (mut sum, mut count) = ([0_u64; 3], 0);
    for pixel in pixels.iter().filter(|pixel| is_leaf(pixel)) {
        (0..3).for_each(|i| sum[i] += u64::from(srgb::to_linear(pixel[i])));
        count += 1;
    }
    // A photo that is leaf from corner to corner is taken as it is.
    let mean = sum.map(|sum| srgb::to_srgb(sum.checked_div(count).unwrap_or(0) as u16));
    let cut_out = count * 10 > pixels.len() as u64;
    let side = width.min(height);
    let (left, top) = ((width - side) / 2, (height - side) / 2);
    let rows = (top..top + side).flat_map(|y| &pixels[y * width + left..][..side]);
    let square: Vec<[u8; 3]> =
        rows.map(|pixel| if cut_out && !is_leaf(pixel) { mean } else { *pixel }).collect();
    shrunk(&square, side)
}

/// The square as a plate: each cell is the mean light of its pixels.
fn shrunk(square: &[[u8; 3]], side: usize) -> [[u8; 3]; PLATE_CELLS] {
    let range = |cell: usize| {
        let start = cell * side / PLATE_SIDE;
        start..((cell + 1) * side / PLATE_SIDE).max(start + 1)
    };
    std::array::from_fn(|cell| {
        let (mut sum, mut count) = ([0_u64; 3], 0);
        for y in range(cell / PLATE_SIDE) {
            for x in range(cell % PLATE_SIDE) {
                (0..3).for_each(|i| sum[i] += u64::from(srgb::to_linear(square[y * side + x][i])));
                count += 1;
            }
        }
        sum.map(|sum| srgb::to_srgb((sum / count) as u16))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// A folder of leaves, each of one colour on white, of these sizes.
    fn leaves(sizes: &[u32]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (stage, &size) in sizes.iter().enumerate() {
            let leaf = image::RgbImage::from_fn(size, size, |x, y| {
                let inside = (size / 8..size * 7 / 8).contains(&x) && (size / 8..size * 7 / 8).contains(&y);
                image::Rgb(if inside { [20 * stage as u8 + 40, 100, 30] } else { [255; 3] })
            });
            leaf.save(folder.path().join(format!("leaf{stage}.png"))).unwrap();
        }
        folder
    }

    fn line(sizes: &[u32]) -> String {
        let folder = leaves(sizes);
        let error = plates(&PlatesChoice::Folder(folder.path().into())).expect_err("bad plates");
        error.to_string()
    }

    #[test]
    fn plates_have_the_colours_of_the_leaves_and_none_of_what_is_behind_them() {
        let folder = leaves(&[64; 7]);
        let plates = plates(&PlatesChoice::Folder(folder.path().into())).unwrap().unwrap();
        for (stage, plate) in plates.iter().enumerate() {
            let red = 20 * stage as u8 + 40;
            assert!(
                plate.iter().all(|[r, g, _]| r.abs_diff(red) <= 1 && g.abs_diff(100) <= 1),
                "stage {stage}"
            );
        }
    }

    #[test]
    fn six_plates_and_plates_of_different_sizes_are_refused() {
        assert!(line(&[64; 6]).contains("6 photos are here; seven are needed"));
        let line = line(&[64, 64, 64, 48, 64, 64, 64]);
        assert!(line.contains("leaf3.png has 48×48 pixels, and the first photo has 64×64"), "{line}");
    }

    #[test]
    fn a_bad_tree_is_named_with_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("oak.tree");
        fs::write(&path, "tree oak\na(s) -> F(s) [ a(s/2)\n").unwrap();
        let error = species(&TreeChoice::File(path)).expect_err("an open bracket").to_string();
        assert!(error.contains("oak.tree: line 2, column 14: this [ is never closed"), "{error}");
        let error = species(&TreeChoice::File("nowhere.tree".into())).expect_err("no file").to_string();
        assert!(error.contains("there is no such tree") && error.contains("maple"), "{error}");
    }

    #[test]
    fn the_camera_goes_around_in_its_minutes_or_stands() {
        let mut orbit = Orbit::new(Some(10));
        for (seconds, degrees) in [(0, 0), (150, 90), (151, 90), (599, 358), (600, 0)] {
            orbit.go(Duration::from_secs(seconds));
            let off = orbit.azimuth().0.abs_diff(Turns::from_degrees(degrees).0);
            assert!(off < 1 << 16, "after {seconds} s it is {off} off");
        }
        let mut still = Orbit::new(None);
        still.go(Duration::from_secs(150));
        assert_eq!(still.azimuth(), Turns(0));
    }

    #[test]
    fn a_film_goes_through_its_stages_from_end_to_end() {
        let season = Season::default();
        assert_eq!(season.of_film(0, 120), Stage::GREEN);
        assert_eq!(season.of_film(119, 120), Stage::BARE);
        let still = Season { stages: Some((Stage::COLOURED, Stage::COLOURED)), minutes: None };
        assert_eq!(still.of_film(7, 120), Stage::COLOURED);
        assert_eq!(still.of_film(0, 1), Stage::COLOURED);
    }
}
