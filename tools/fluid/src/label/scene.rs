//! What a picture shows.

use super::{candidates::Search, target::Target};
use crate::{features::Features, footage::Class};

/// Candidates that are asked for their class, of each patch.
const VOTERS: usize = 50;

/// The class that the patches like the picture's belong to more often than chance; none if no patch has a class, or the picture no fluid.
///
/// Each of the picture's patches asks its most similar patches of all classes, by both of their word maps. A class is counted against its
/// share of the database, as the largest would win otherwise. Costs as much as the search of [`super::label`] over all classes.
pub fn scene_class(
    target: &Target,
    features: &[Features],
    class: impl Fn(u32) -> Option<Class>,
) -> Option<Class> {
    let classes = [Class::Water, Class::Fire, Class::Smoke];
    let of = |patch: &Features| classes.iter().position(|&known| class(patch.patch.video) == Some(known));
    let mut share = [0.0f64; 3];
    features.iter().filter_map(of).for_each(|class| share[class] += 1.0);
    let mut votes = [0.0f64; 3];
    for candidate in Search::new(features, true).scan(target, VOTERS).iter().flatten() {
        if let Some(class) = of(&features[candidate.patch as usize]) {
            votes[class] += 1.0 / share[class];
        }
    }
    let winner = (0..3).max_by(|&a, &b| votes[a].total_cmp(&votes[b])).filter(|&class| votes[class] > 0.0)?;
    Some(classes[winner])
}
