//! Keys that have no effect are refused or noted with what to do, and so is what one object alone lacks.

use recipe::{Recipe, SampleNeeds};

#[test]
fn facets_on_a_pack_are_refused() {
    let text = "name: a\nsubject: blister\nunstated: fixed\nclasses: {one: {share: 1}}\nlaser: {glints_per_mm: 1}\n";
    let error = Recipe::parse("a.yaml", text).expect_err("no facets").to_string();
    assert!(error.contains("laser.glints_per_mm") && error.contains("below its film"), "{error}");
}

/// What a class alone has, or lacks, is told of that class.
#[test]
fn notes_name_the_class() {
    let text = "name: a\nsubject: wood\nunstated: fixed\n\
        knots: {width_mm: 9}\nclasses:\n  knotty: {share: 1, knots: {sound_count: \
        2}}\n  \
                clear: {share: 1, knots: {bark_mm: 2}}\n";
    let recipe = Recipe::parse("a.yaml", text).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(recipe.notes().len(), 1, "{:?}", recipe.notes());
    assert!(recipe.notes()[0].starts_with(
        "classes.clear.knots.bark_mm has no effect while `knots.dead_count` and `knots.hole_count` and \
            `knots.loose_count` are 0; "
    ));
}

/// What is asked and cannot show is told: wet places that are dry, a core like all other wood, tubes that have no room.
#[test]
fn what_cannot_show_is_told() {
    let recipe = |keys: &str| {
        let text = format!("name: a\nsubject: wood\nunstated: fixed\nclasses: {{one: {{share: 1}}}}\n{keys}\n");
        Recipe::parse("a.yaml", &text).unwrap_or_else(|error| panic!("{error}"))
    };
    for (keys, note) in [
        (
            "speckle: {strength: 0, surface_patterns: 2}",
            "speckle.surface_patterns has no effect while `speckle.strength` is 0",
        ),
        ("moisture: {patch_count: 2, filled: 0}", "moisture.patch_count has no effect while `moisture.filled` is 0"),
        ("log: {juvenile_rings: 9, juvenile_latewood_ratio: 1}", "log.juvenile_rings has no effect while"),
        ("anatomy: {canals_per_mm2: 20, canal_um: 500}", "anatomy.canal_um can be 500, and where 20 canals stand"),
        ("anatomy: {pores_per_mm2: {uniform: [1, 100]}}", "at most 85 um wide"),
    ] {
        let notes = recipe(keys).notes().to_vec();
        assert!(notes.len() == 1 && notes[0].contains(note), "{keys}: {notes:?}");
    }
    assert!(recipe("anatomy: {pores_per_mm2: 72}").notes().is_empty());
}

/// Counts say themselves that there is nothing; what boards from elsewhere have is not asked of counts that these don't
/// have.
#[test]
fn counts_are_never_lacking() {
    let of = |source: &str, path: &str| {
        let canonical = serde_json::json!({"subject": "wood", "log": {"source": source}});
        SampleNeeds::new(&canonical, path)
    };
    for source in ["placed", "stem", "measured", "picture", "slices"] {
        for path in
            ["knots.sound_count", "knots.dead_count", "knots.hole_count", "knots.loose_count", "rot.pocket_count"]
        {
            assert!(of(source, path).is_none(), "{path} of {source}");
        }
        for path in ["rot.heart_mm", "rot.reach_mm", "exposure.time_us", "physics.speckle_volume", ""] {
            assert!(of(source, path).is_none(), "{path} of {source}");
        }
        if source != "placed" {
            for path in
                ["knots.width_mm", "knots.hole_depth_mm", "knots.loose_gap_mm", "knots.flow_ratio", "media.knot_n_eff"]
            {
                assert!(of(source, path).is_none(), "{path} of {source}");
            }
        }
    }
    let needs = of("placed", "knots.width_mm").expect("there may be no knot");
    assert_eq!(needs.deciders().len(), 4);
    assert!(needs.are_unmet(&[Some(0.0); 4]) && !needs.are_unmet(&[Some(0.0), None, Some(2.0), None]));
    // A dataset of before such knots were there has none of them.
    assert!(needs.are_unmet(&[None, None, Some(0.0), None]));
}
