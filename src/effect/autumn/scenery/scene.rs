//! Where a tree stands: one scene or another.

/// What is behind a tree, from the zenith to the viewer's feet. Colours are sRGB, places and heights are of 256 of the picture's height.
#[derive(Debug, PartialEq, Eq)]
pub(in super::super) struct Scene {
    /// What species files call it.
    name: &'static str,
    /// Colours down the sky, and where each is, of 256 between the zenith and the horizon.
    pub(super) sky: [(i32, [i32; 3]); 4],
    /// The light around the low sun, to the left, and how much of it there is, of 256.
    pub(super) glow: ([i32; 3], i32),
    /// How dense clouds are at most, of 256.
    pub(super) clouds: i32,
    /// The farthest first.
    pub(super) hills: &'static [Hill],
    /// The colour of what lies in valleys, and of distance.
    pub(super) mist: [i32; 3],
    pub(super) wood: Option<Wood>,
    pub(super) horizon: i32,
    /// Where the ground begins; from the horizon to here there is water.
    pub(super) shore: i32,
    /// The ground at its far end, and at the viewer's feet.
    pub(super) ground: [[i32; 3]; 2],
    /// Colours of blades of grass.
    pub(super) blades: [[i32; 3]; 3],
    /// How tall the blades are, of 256 of those of a meadow.
    pub(super) tall: i32,
}

/// A line of hills.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Hill {
    pub(super) rise: i32,
    /// How many ups and downs there are.
    pub(super) rough: i32,
    pub(super) colour: [i32; 3],
    /// Whether they are mountains, with snow.
    pub(super) peaks: bool,
}

/// A wood at the horizon.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Wood {
    pub(super) crowns: [[i32; 3]; 4],
    pub(super) rise: i32,
    pub(super) conifers: bool,
}

const fn hill(rise: i32, rough: i32, colour: [i32; 3]) -> Hill {
    Hill { rise, rough, colour, peaks: false }
}

const fn peaks(rise: i32, rough: i32, colour: [i32; 3]) -> Hill {
    Hill { rise, rough, colour, peaks: true }
}

/// All that there are; the first is usual.
static SCENES: [Scene; 5] = [
    // A golden evening at the edge of a wood.
    Scene {
        name: "meadow",
        sky: [(0, [116, 148, 184]), (110, [180, 194, 202]), (190, [238, 216, 182]), (256, [252, 214, 156])],
        glow: ([255, 236, 190], 190),
        clouds: 120,
        hills: &[hill(40, 5, [186, 180, 184]), hill(27, 8, [164, 160, 152])],
        mist: [232, 210, 172],
        wood: Some(Wood {
            crowns: [[146, 112, 66], [120, 112, 66], [98, 100, 64], [160, 126, 70]],
            rise: 15,
            conifers: false,
        }),
        horizon: 212,
        shore: 212,
        ground: [[156, 146, 92], [70, 72, 32]],
        blades: [[132, 130, 54], [172, 152, 80], [92, 106, 42]],
        tall: 256,
    },
    // The lawn of a park on a clear day.
    Scene {
        name: "park",
        sky: [(0, [70, 118, 182]), (110, [118, 162, 212]), (190, [172, 202, 228]), (256, [218, 228, 232])],
        glow: ([255, 250, 236], 90),
        clouds: 60,
        hills: &[hill(30, 4, [168, 184, 196])],
        mist: [206, 216, 216],
        wood: Some(Wood {
            crowns: [[76, 98, 62], [92, 108, 66], [66, 86, 62], [112, 114, 68]],
            rise: 27,
            conifers: false,
        }),
        horizon: 210,
        shore: 210,
        ground: [[126, 150, 86], [58, 88, 36]],
        blades: [[98, 132, 56], [120, 148, 68], [78, 112, 46]],
        tall: 110,
    },
    // A lake in the north.
    Scene {
        name: "lake",
        sky: [(0, [128, 154, 182]), (110, [176, 192, 204]), (190, [216, 216, 212]), (256, [244, 228, 200])],
        glow: ([255, 244, 216], 150),
        clouds: 170,
        hills: &[hill(38, 4, [166, 180, 194]), hill(22, 7, [128, 146, 156])],
        mist: [214, 216, 210],
        wood: Some(Wood {
            crowns: [[66, 86, 80], [58, 76, 68], [82, 96, 74], [74, 88, 66]],
            rise: 13,
            conifers: true,
        }),
        horizon: 194,
        shore: 211,
        ground: [[172, 150, 96], [98, 80, 40]],
        blades: [[190, 162, 92], [156, 130, 70], [124, 116, 60]],
        tall: 300,
    },
    // Under high mountains, after the sun has gone.
    Scene {
        name: "mountains",
        sky: [(0, [86, 104, 148]), (110, [150, 154, 186]), (190, [224, 190, 184]), (256, [250, 212, 174])],
        glow: ([255, 216, 180], 120),
        clouds: 90,
        hills: &[peaks(92, 10, [132, 138, 168]), hill(46, 8, [118, 126, 146]), hill(27, 10, [92, 104, 112])],
        mist: [196, 186, 188],
        wood: Some(Wood {
            crowns: [[54, 70, 66], [60, 76, 64], [48, 64, 60], [70, 82, 66]],
            rise: 16,
            conifers: true,
        }),
        horizon: 210,
        shore: 210,
        ground: [[138, 130, 98], [70, 70, 46]],
        blades: [[122, 116, 70], [92, 98, 58], [152, 132, 90]],
        tall: 200,
    },
    // Nothing but light, for a tree that is a drawing.
    Scene {
        name: "plain",
        sky: [(0, [206, 214, 218]), (110, [222, 226, 224]), (190, [236, 232, 220]), (256, [244, 236, 216])],
        glow: ([255, 255, 255], 0),
        clouds: 0,
        hills: &[],
        mist: [244, 236, 216],
        wood: None,
        horizon: 212,
        shore: 212,
        ground: [[226, 218, 190], [166, 160, 118]],
        blades: [[184, 176, 130], [200, 190, 148], [162, 158, 112]],
        tall: 120,
    },
];

impl Scene {
    /// What a species file may name.
    pub(in super::super) const NAMES: &'static str = "meadow, park, lake, mountains or plain";

    /// The scene of this name.
    pub(in super::super) fn named(name: &str) -> Option<&'static Self> {
        SCENES.iter().find(|scene| scene.name == name)
    }

    /// That of a species that names none.
    pub(in super::super) const fn usual() -> &'static Self {
        &SCENES[0]
    }

    /// Where things can lie on the ground from, of 256 of the picture's height.
    pub(in super::super) const fn ground_top(&self) -> i32 {
        self.shore
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_has_its_name_in_the_message_and_stands_above_the_tree_s_foot() {
        for scene in &SCENES {
            assert!(Scene::NAMES.contains(scene.name));
            assert_eq!(Scene::named(scene.name), Some(scene));
            assert!(scene.horizon <= scene.shore && scene.shore < 222, "{}", scene.name);
        }
        assert_eq!(Scene::named("desert"), None);
    }
}
