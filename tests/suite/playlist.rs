//! The order of photos: the deck, the listing, the way back, and what a restart keeps.

use proptest::prelude::*;
use std::{collections::HashSet, time::Duration};
use yurameki::{
    app::playlist::{Dwell, HISTORY, PhotoId, Playlist, SOON, Slot},
    config::Order,
};

type Photos = Playlist<Vec<Slot>>;

fn ids(numbers: impl IntoIterator<Item = u64>) -> Vec<PhotoId> {
    numbers.into_iter().map(PhotoId).collect()
}

fn playlist(order: Order, seed: u64, photos: &[PhotoId]) -> Photos {
    let mut playlist = Playlist::new(vec![Slot::EMPTY; 100], order, seed);
    assert_eq!(playlist.update(photos), 0);
    playlist
}

fn current(playlist: &Photos) -> u64 {
    playlist.current().expect("there are photos").0
}

/// The current photo and those after it, `count` in all.
fn run(playlist: &mut Photos, count: usize) -> Vec<u64> {
    (0..count)
        .map(|_| {
            let id = current(playlist);
            playlist.next();
            id
        })
        .collect()
}

#[test]
fn every_round_of_the_deck_shows_every_photo_once_and_none_twice_running() {
    for photos in [2, 3, 40] {
        for seed in 0..50 {
            let mut playlist = playlist(Order::Shuffle, seed, &ids(0..photos));
            let shown = run(&mut playlist, 20 * photos as usize);
            for round in shown.chunks(photos as usize) {
                assert_eq!(round.iter().collect::<HashSet<_>>().len(), photos as usize);
            }
            assert!(shown.windows(2).all(|pair| pair[0] != pair[1]), "seed {seed}: {shown:?}");
        }
    }
}

#[test]
fn rounds_and_seeds_are_shuffled_in_their_own_ways() {
    let photos = ids(0..30);
    let shown: Vec<_> = (0..20).map(|seed| run(&mut playlist(Order::Shuffle, seed, &photos), 60)).collect();
    let mut rounds = HashSet::new();
    assert!(shown.iter().flat_map(|two| two.chunks(30)).all(|round| rounds.insert(round)));
    // The listing decides nothing.
    let backwards = ids((0..30).rev());
    assert_eq!(run(&mut playlist(Order::Shuffle, 7, &backwards), 60), shown[7]);
}

#[test]
fn the_deck_has_no_favourite_place_for_a_photo() {
    // Photo 0 of 10 over 2,000 seeds: 200 times at each place, with a standard deviation of 13.4.
    let mut places = [0_i32; 10];
    for seed in 0..2_000 {
        let shown = run(&mut playlist(Order::Shuffle, seed, &ids(0..10)), 10);
        places[shown.iter().position(|&id| id == 0).expect("shown")] += 1;
    }
    assert!(places.iter().all(|count| (count - 200).abs() < 67), "{places:?}");
}

#[test]
fn a_listing_is_shown_in_its_order_in_both_directions() {
    for order in [Order::Name, Order::Date] {
        let mut playlist = playlist(order, 1, &ids([5, 3, 9, 1]));
        assert_eq!(run(&mut playlist, 5), [5, 3, 9, 1, 5]);
        playlist = self::playlist(order, 1, &ids([5, 3, 9, 1]));
        let back: Vec<_> = (0..5)
            .map(|_| {
                playlist.previous();
                current(&playlist)
            })
            .collect();
        assert_eq!(back, [1, 9, 3, 5, 1]);
        playlist.next();
        assert_eq!(current(&playlist), 5);
    }
}

#[test]
fn a_listing_that_changes_goes_on_behind_the_current_photo() {
    let mut playlist = playlist(Order::Name, 1, &ids([10, 20, 30, 40]));
    playlist.next();
    playlist.update(&ids([5, 10, 15, 20, 25, 30, 40]));
    assert_eq!(run(&mut playlist, 4), [20, 25, 30, 40]);
    assert_eq!(current(&playlist), 5, "it goes round");
    for _ in 0..4 {
        playlist.next();
    }
    assert_eq!(current(&playlist), 25);
    playlist.update(&ids([10, 30, 40]));
    assert_eq!(current(&playlist), 30, "25 is gone");
    playlist.next();
    playlist.update(&ids([10, 30]));
    assert_eq!(current(&playlist), 10, "the last is gone");
}

#[test]
fn going_back_is_true_history_and_forwards_again_the_same() {
    let mut playlist = playlist(Order::Shuffle, 3, &ids(0..7));
    let shown = run(&mut playlist, 20);
    for &id in shown.iter().rev() {
        playlist.previous();
        assert_eq!(current(&playlist), id);
    }
    playlist.previous();
    assert_eq!(current(&playlist), shown[0], "nothing is remembered before the first");
    assert_eq!(run(&mut playlist, 20), shown);
}

#[test]
fn the_history_is_bounded() {
    let mut playlist = playlist(Order::Shuffle, 3, &ids(0..90));
    let shown = run(&mut playlist, 3 * HISTORY);
    for _ in 0..2 * HISTORY {
        playlist.previous();
    }
    assert_eq!(current(&playlist), shown[3 * HISTORY + 1 - HISTORY]);
}

#[test]
fn the_way_back_passes_over_what_is_gone_or_hidden() {
    let mut playlist = playlist(Order::Shuffle, 5, &ids(0..10));
    let shown = run(&mut playlist, 5);
    playlist.hide(PhotoId(shown[4]));
    playlist.update(&ids((0..10).filter(|&id| id != shown[3])));
    playlist.previous();
    assert_eq!(current(&playlist), shown[2]);
}

#[test]
fn a_bad_photo_is_skipped_in_the_direction_of_travel() {
    let mut playlist = playlist(Order::Shuffle, 5, &ids(0..10));
    let shown = run(&mut playlist, 10);
    playlist.previous();
    playlist.previous();
    playlist.skip();
    assert_eq!(current(&playlist), shown[7]);
    playlist.next();
    playlist.skip();
    assert_eq!(current(&playlist), shown[9]);
    for _ in 0..9 {
        playlist.previous();
    }
    playlist.skip();
    assert_eq!(current(&playlist), shown[1], "there is nothing further back");
}

#[test]
fn skipping_tries_every_photo_within_two_rounds() {
    for &(_, order) in Order::NAMES {
        for backwards in [false, true] {
            let mut playlist = playlist(order, 4, &ids(0..10));
            run(&mut playlist, 13);
            if backwards {
                playlist.previous();
            }
            let mut tried = HashSet::new();
            for _ in 0..2 * playlist.len() {
                tried.insert(current(&playlist));
                playlist.skip();
            }
            assert!(tried.len() == 10 || backwards, "{order}: {tried:?}");
        }
    }
}

#[test]
fn a_new_photo_comes_soon_and_once_in_its_round() {
    for seed in 0..200 {
        let mut playlist = playlist(Order::Shuffle, seed, &ids(0..50));
        let before = run(&mut playlist, seed as usize % 50);
        playlist.update(&ids(0..51));
        let shown = run(&mut playlist, 51 - before.len());
        let place = shown.iter().position(|&id| id == 50).expect("it comes in this round");
        assert!((1..=SOON).contains(&place), "seed {seed}: {place}");
        assert_eq!(before.iter().chain(&shown).collect::<HashSet<_>>().len(), 51);
    }
}

#[test]
fn photos_that_are_copied_one_by_one_all_come_soon() {
    let mut playlist = Playlist::new(vec![Slot::EMPTY; 2_000], Order::Shuffle, 9);
    playlist.update(&ids(0..50));
    run(&mut playlist, 10);
    for copied in 50..1_000 {
        assert_eq!(playlist.update(&ids(0..=copied)), 0);
    }
    let shown = run(&mut playlist, 950 + SOON);
    assert_eq!(shown.iter().filter(|&&id| id >= 50).collect::<HashSet<_>>().len(), 950);
}

#[test]
fn a_stick_that_is_pulled_out_and_plugged_in_keeps_its_place_in_the_round() {
    let (all, card) = (ids(0..60), ids(0..20));
    let mut playlist = playlist(Order::Shuffle, 2, &all);
    let mut shown = run(&mut playlist, 30);
    playlist.update(&card);
    assert!(current(&playlist) < 20, "the show goes on with what is there");
    shown.extend(run(&mut playlist, 2));
    playlist.update(&all);
    shown.extend(run(&mut playlist, 28));
    let now = current(&playlist);
    shown.truncate(59);
    assert_eq!(shown.iter().collect::<HashSet<_>>().len(), shown.len(), "nothing came twice");

    // Without any other photo the show waits.
    playlist.update(&[]);
    assert_eq!((playlist.current(), playlist.is_empty()), (None, true));
    playlist.next();
    playlist.previous();
    playlist.skip();
    assert_eq!((playlist.current(), playlist.upcoming()), (None, None));
    playlist.update(&all);
    assert_eq!(current(&playlist), now);
}

#[test]
fn hidden_photos_never_come() {
    for &(_, order) in Order::NAMES {
        let mut playlist = Playlist::new(vec![Slot::EMPTY; 20], order, 1);
        assert!(playlist.hide(PhotoId(3)), "before it is known");
        playlist.update(&ids(0..10));
        let now = current(&playlist);
        assert!(playlist.hide(PhotoId(now)));
        assert_ne!(current(&playlist), now);
        playlist.update(&ids(5..10));
        playlist.update(&ids(0..10));
        let hidden = HashSet::from([3, now]);
        assert!(run(&mut playlist, 100).iter().all(|id| !hidden.contains(id)), "{order}");
        assert_eq!(playlist.len(), 10 - hidden.len());
        for id in 0..10 {
            playlist.hide(PhotoId(id));
        }
        assert_eq!(playlist.current(), None);
    }
}

#[test]
fn what_there_is_no_room_for_is_counted_and_the_rest_is_shown() {
    let mut playlist = Playlist::new(vec![Slot::EMPTY; 8], Order::Shuffle, 1);
    assert_eq!(playlist.update(&ids(0..10)), 2);
    assert_eq!(playlist.len(), 8);
    assert!(!playlist.hide(PhotoId(77)));
    assert_eq!(playlist.update(&ids(2..10)), 0, "photos that are gone make room");
    assert_eq!(run(&mut playlist, 8).into_iter().filter(|&id| id >= 2).collect::<HashSet<_>>().len(), 8);
    let mut none = Playlist::new(Vec::new(), Order::Shuffle, 1);
    assert_eq!((none.update(&ids(0..3)), none.current()), (3, None));
}

#[test]
fn the_whole_capacity_is_shown_once_a_round() {
    let mut playlist = Playlist::new(vec![Slot::EMPTY; 2_000], Order::Shuffle, 1);
    // Ids that differ in their high bits only.
    let photos = ids((0..2_000).map(|i| i << 48));
    assert_eq!(playlist.update(&photos), 0);
    assert_eq!(run(&mut playlist, 2_000).into_iter().collect::<HashSet<_>>().len(), 2_000);
}

#[test]
fn a_photo_that_is_told_twice_is_shown_once() {
    for &(_, order) in Order::NAMES {
        let mut playlist = playlist(order, 1, &ids([1, 2, 1, 3, 2]));
        assert_eq!(playlist.len(), 3);
        assert_eq!(run(&mut playlist, 3).into_iter().collect::<HashSet<_>>().len(), 3);
    }
}

#[test]
fn a_restart_shows_the_same_photo_and_goes_on_as_if_there_had_been_none() {
    for &(_, order) in Order::NAMES {
        for (steps, back) in [(0, 0), (3, 0), (9, 2), (10, 0), (25, 1), (200, 5)] {
            let mut playlist = playlist(order, 6, &ids(0..10));
            run(&mut playlist, steps);
            playlist.update(&ids(0..14));
            (0..back).for_each(|_| playlist.previous());
            let mut again = Playlist::restore(vec![Slot::EMPTY; 100], order, 99, &playlist.snapshot());
            assert_eq!(again.current(), None, "the photos are not known yet");
            again.update(&ids(0..14));
            assert_eq!(again.snapshot(), playlist.snapshot(), "{order} {steps} {back}");
            assert_eq!(run(&mut again, 60), run(&mut playlist, 60));
        }
    }
}

#[test]
fn a_restart_in_another_order_keeps_the_photo_and_the_way_back() {
    let mut playlist = playlist(Order::Shuffle, 6, &ids(0..10));
    let shown = run(&mut playlist, 5);
    let now = current(&playlist);
    let mut again = Playlist::restore(vec![Slot::EMPTY; 100], Order::Name, 6, &playlist.snapshot());
    again.update(&ids(0..10));
    assert_eq!(run(&mut again, 3), [now, (now + 1) % 10, (now + 2) % 10]);
    (0..4).for_each(|_| again.previous());
    assert_eq!(current(&again), shown[4]);
}

#[test]
fn a_photo_is_due_when_it_was_shown_for_its_time() {
    let second = Duration::from_secs(1);
    let mut dwell = Dwell::new(Some(3 * second));
    assert_eq!([second; 4].map(|time| dwell.pass(time)), [false, false, true, true]);
    assert!(dwell.is_over());
    assert!(!Dwell::new(None).pass(Duration::MAX));
}

/// What can happen to a show.
#[derive(Clone, Debug)]
enum Event {
    Next,
    Add(u64),
    Remove(u64),
    Hide(u64),
    Back(usize),
    Restart,
}

fn events() -> impl Strategy<Value = Vec<Event>> {
    let event = prop_oneof![
        12 => Just(Event::Next),
        3 => (0_u64..24).prop_map(Event::Add),
        2 => (0_u64..24).prop_map(Event::Remove),
        1 => (0_u64..24).prop_map(Event::Hide),
        1 => (1_usize..4).prop_map(Event::Back),
        1 => Just(Event::Restart),
    ];
    prop::collection::vec(event, 0..200)
}

proptest! {
    /// A photo that was drawn is not drawn again before all have been that were there all the time, were there at a round's
    /// beginning, or came since.
    #[test]
    fn no_photo_comes_twice_before_all_were_shown(seed: u64, events in events()) {
        let mut there: HashSet<u64> = (0..12).collect();
        let mut hidden = HashSet::new();
        let listing = |there: &HashSet<u64>| {
            let mut photos = ids(there.iter().copied());
            photos.sort_unstable();
            photos
        };
        let mut playlist = playlist(Order::Shuffle, seed, &listing(&there));
        let mut round = HashSet::from([current(&playlist)]);
        // Photos that were away at a restart: whether they were shown before may be remembered, or not, so that it is not clear
        // from outside in which round they are.
        let mut away = HashSet::new();
        let mut last = playlist.snapshot().place;
        for event in events {
            match event {
                Event::Next => playlist.next(),
                Event::Add(id) => {
                    there.insert(id);
                    playlist.update(&listing(&there));
                }
                Event::Remove(id) => {
                    there.remove(&id);
                    playlist.update(&listing(&there));
                }
                Event::Hide(id) => {
                    hidden.insert(id);
                    prop_assert!(playlist.hide(PhotoId(id)));
                }
                Event::Back(steps) => (0..steps).for_each(|_| playlist.previous()),
                Event::Restart => {
                    let slots = vec![Slot::EMPTY; 100];
                    playlist = Playlist::restore(slots, Order::Shuffle, seed, &playlist.snapshot());
                    for &id in &hidden {
                        prop_assert!(playlist.hide(PhotoId(id)));
                    }
                    playlist.update(&listing(&there));
                    away.extend(round.extract_if(|id| !there.contains(id)));
                }
            }
            let visible: HashSet<u64> = there.difference(&hidden).copied().collect();
            prop_assert_eq!(playlist.len(), visible.len());
            match playlist.current() {
                Some(id) => prop_assert!(visible.contains(&id.0)),
                None => prop_assert!(visible.is_empty()),
            }
            let place = playlist.snapshot().place;
            if let (Some((_, drawn)), true) = (place, place != last)
                && !round.insert(drawn.0)
            {
                let shown = |id| round.contains(id) || away.contains(id);
                prop_assert!(visible.iter().all(shown), "{} again, {:?} of {:?}", drawn.0, round, visible);
                round = HashSet::from([drawn.0]);
            }
            last = place;
        }
    }
}
