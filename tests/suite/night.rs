//! Night: every minute of two years in three time zones, clocks that are wrong, and presses.

use jiff::{Timestamp, civil::DateTime, tz::TimeZone};
use proptest::prelude::*;
use yurameki::{
    app::night::{FULL, Night, level_at, light, next_edge},
    config::night::{self, Edge, Level, MAX_EDGES, Zone},
    os::local_time::{LocalTime, Trust},
};

fn schedule(edges: &[&str]) -> night::Night {
    let mut schedule = night::Night::default();
    for edge in edges {
        schedule.insert(edge.parse().expect("an edge")).expect("room");
    }
    schedule
}

fn at(time: &str) -> u16 {
    format!("{time} off").parse::<Edge>().expect("a time").minute
}

fn clock(zone: &str) -> LocalTime {
    let zone = Zone::Named(zone.try_into().expect("short"));
    LocalTime::new(&zone, Trust::AsItIs).expect("a zone")
}

/// Daylight saving as the law writes it: seconds east of Greenwich in winter, and when summer begins and ends in a year, in
/// seconds since 1970.
struct Law {
    zone: &'static str,
    winter: i64,
    summer: Option<fn(i64) -> (i64, i64)>,
}

/// Seconds at 0:00 UTC of the `nth` Sunday (the last one: 5) of a month.
fn sunday(year: i64, month: i64, nth: i64) -> i64 {
    let days = |year, month| {
        // Days since 1970 of the first of a month, counted one year and month after the other.
        let leap = |year: i64| (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
        let lengths = [31, if leap(year) { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
        let years: i64 = (1970..year).map(|year| if leap(year) { 366 } else { 365 }).sum();
        years + lengths[..month as usize - 1].iter().sum::<i64>()
    };
    // The first of January 1970 was a Thursday.
    let first = days(year, month) + (3 - days(year, month)).rem_euclid(7);
    let length = days(year, month + 1) - days(year, month);
    let all = (0..5).map(|week| first + 7 * week).filter(|day| day - days(year, month) < length);
    all.take(nth as usize).last().expect("every month has Sundays") * 86_400
}

const LAWS: [Law; 3] = [
    Law {
        zone: "CET-1CEST,M3.5.0,M10.5.0/3",
        winter: 3_600,
        summer: Some(|year| (sunday(year, 3, 5) + 3_600, sunday(year, 10, 5) + 3_600)),
    },
    Law {
        zone: "EST5EDT,M3.2.0,M11.1.0",
        winter: -5 * 3_600,
        summer: Some(|year| (sunday(year, 3, 2) + 7 * 3_600, sunday(year, 11, 1) + 6 * 3_600)),
    },
    Law { zone: "JST-9", winter: 9 * 3_600, summer: None },
];

#[test]
fn every_minute_of_two_years_has_the_level_of_its_wall_clock() {
    let schedule = schedule(&["2:30 5%", "06:15 80%", "9:00 100%", "21:30 40%", "23:59 off"]);
    // What is said above, a minute of the day after the other.
    let mut levels = [Level::Off; 1440];
    levels[150..375].fill(Level::Percent(5));
    levels[375..540].fill(Level::Percent(80));
    levels[540..1290].fill(FULL);
    levels[1290..1439].fill(Level::Percent(40));
    // 2024 has a leap day.
    let start: Timestamp = "2024-01-01T14:00:00Z".parse().expect("a time");
    let year_seconds = |year: i64| sunday(year, 1, 1) - 6 * 86_400;
    for Law { zone, winter, summer } in LAWS {
        let time = clock(zone);
        for minute in 0..2 * 366 * 1440 {
            let seconds = start.as_second() + minute * 60;
            let year = if seconds < year_seconds(2025) + 6 * 86_400 { 2024 } else { 2025 };
            let is_summer =
                summer.map(|law| law(year)).is_some_and(|(from, to)| (from..to).contains(&seconds));
            let local = seconds + winter + if is_summer { 3_600 } else { 0 };
            let want = levels[(local.rem_euclid(86_400) / 60) as usize];
            let now = time.minute_at(Timestamp::from_second(seconds).expect("in range")).expect("a minute");
            assert_eq!(level_at(schedule.edges(), now), want, "{zone} {seconds}");
        }
    }
}

#[test]
fn daylight_saving_does_what_the_wall_clock_says() {
    let zone = TimeZone::posix(LAWS[0].zone).expect("a zone");
    let time = clock(LAWS[0].zone);
    let mut night = Night::new(schedule(&["2:30 off", "7:00 100%"]));
    let mut levels = |from: DateTime, minutes: i64| -> Vec<Level> {
        let from = zone.to_timestamp(from).expect("in range").as_second();
        let times = (0..minutes).map(|minute| Timestamp::from_second(from + 60 * minute).expect("in range"));
        times.map(|instant| night.turn(time.minute_at(instant))).collect()
    };
    // In spring 2:30 does not come: it is night from 3:00 on, which is one minute after 1:59.
    let spring = levels("2025-03-30T01:59:00".parse().expect("a date"), 2);
    assert_eq!(spring, [FULL, Level::Off]);
    // In autumn it comes twice: half an hour of night, half an hour of the evening again.
    let autumn = levels("2025-10-26T01:00:00".parse().expect("a date"), 240);
    let off = |range: std::ops::Range<usize>| autumn[range].iter().all(|&level| level == Level::Off);
    let on = |range: std::ops::Range<usize>| autumn[range].iter().all(|&level| level == FULL);
    assert!(on(0..90) && off(90..120) && on(120..150) && off(150..240));
}

#[test]
fn nothing_happens_until_the_clock_is_sure() {
    let mut night = Night::new(schedule(&["22:00 off", "7:00 60%"]));
    assert_eq!(night.turn(None), FULL, "it may be day");
    assert_eq!(night.turn(Some(at("23:00"))), Level::Off);
    assert_eq!(night.turn(None), Level::Off, "what was known stays");
    assert!(night.wake());
    assert_eq!(night.turn(None), FULL);
    let time = clock("UTC0");
    let minute = |text: &str| time.minute_at(text.parse().expect("a time"));
    assert_eq!(minute("1970-01-01T00:12:00Z"), None);
    assert_eq!(minute("2023-12-31T23:59:59Z"), None);
    assert_eq!(minute("2024-01-01T00:00:00Z"), Some(at("0:00")));
    assert_eq!(minute("2024-02-29T13:05:59Z"), Some(at("13:05")));
}

#[test]
fn a_clock_that_goes_back_or_forward_by_a_year_changes_nothing() {
    let time = clock("UTC0");
    let mut night = Night::new(schedule(&["22:00 off", "7:00 60%"]));
    for overruled in [false, true] {
        if overruled {
            night.overrule(Level::Percent(33));
        }
        let times =
            ["2026-05-05T09:00:00Z", "2025-05-05T09:00:00Z", "1970-01-01T02:00:00Z", "2036-05-05T09:01:00Z"];
        for text in times {
            let level = night.turn(time.minute_at(text.parse().expect("a time")));
            assert_eq!(level, Level::Percent(if overruled { 33 } else { 60 }), "{text}");
        }
    }
}

#[test]
fn a_press_in_the_night_holds_until_the_next_edge() {
    let mut night = Night::new(schedule(&["22:00 off", "5:00 10%", "7:00 60%"]));
    assert_eq!(night.turn(Some(at("23:30"))), Level::Off);
    assert!(night.wake());
    for time in ["23:31", "0:00", "4:59"] {
        assert_eq!(night.turn(Some(at(time))), FULL, "{time}");
    }
    assert!(!night.wake(), "it is awake");
    assert_eq!(night.turn(Some(at("5:00"))), Level::Percent(10));
    night.overrule(Level::Off);
    assert_eq!(night.turn(Some(at("6:59"))), Level::Off);
    assert_eq!(night.turn(Some(at("7:01"))), Level::Percent(60), "the edge may be passed between two turns");
    night.overrule(Level::Off);
    assert!(night.wake());
    assert_eq!(night.level(), Level::Percent(60), "asleep by day, it wakes up to the day's level");
    night.overrule(FULL);
    for time in ["8:00", "7:30", "6:45"] {
        assert_eq!(night.turn(Some(at(time))), FULL, "{time}: a clock that is put back passes no edge");
    }
    assert_eq!(night.turn(Some(at("7:00"))), Level::Percent(60));
}

#[test]
fn a_level_that_holds_all_day_can_be_overruled_until_its_time_comes_again() {
    let mut night = Night::new(schedule(&["12:00 30%"]));
    assert_eq!(night.turn(Some(at("11:00"))), Level::Percent(30));
    night.overrule(FULL);
    assert_eq!(night.turn(Some(at("11:59"))), FULL);
    assert_eq!(night.turn(Some(at("12:00"))), Level::Percent(30));
    let mut always = Night::new(night::Night::default());
    assert_eq!((always.turn(Some(at("3:00"))), next_edge(&[], at("3:00"))), (FULL, None));
}

#[test]
fn levels_are_even_to_the_eye() {
    // CIE 1976 in floating point.
    let lightness =
        |percent: f64| if percent > 8.0 { ((percent + 16.0) / 116.0).powi(3) } else { percent / 903.3 };
    for percent in 1..=100 {
        let want = lightness(f64::from(percent)) * 65_536.0;
        assert!((f64::from(light(Level::Percent(percent))) - want).abs() <= 0.51, "{percent}");
    }
    assert_eq!((light(Level::Off), light(Level::Percent(255))), (0, 65_536));
}

#[test]
fn an_unknown_time_zone_is_named_with_the_cure() {
    let error = LocalTime::new(&"Europe/Atlantis".parse().expect("a name"), Trust::AsItIs)
        .expect_err("there is none");
    assert!(error.to_string().contains("Europe/Atlantis") && error.to_string().contains("tzdata"));
}

proptest! {
    #[test]
    fn every_schedule_agrees_with_a_walk_backwards(edges in prop::collection::btree_map(0_u16..1440, 0_u8..=100, 1..MAX_EDGES)) {
        let level = |percent| if percent == 0 { Level::Off } else { Level::Percent(percent) };
        let mut schedule = night::Night::default();
        for (&minute, &percent) in edges.iter().rev() {
            prop_assert_eq!(schedule.insert(Edge { minute, level: level(percent) }), Ok(()));
        }
        for now in 0..1440 {
            let begun = (0..1440).map(|back| (now + 1440 - back) % 1440).find_map(|m| edges.get(&m)).expect("one");
            prop_assert_eq!(level_at(schedule.edges(), now), level(*begun));
            let next = (1..=1440).map(|on| (now + on) % 1440).find(|m| edges.contains_key(m)).expect("one");
            prop_assert_eq!(next_edge(schedule.edges(), now).map(|edge| edge.minute), Some(next));
        }
    }
}
